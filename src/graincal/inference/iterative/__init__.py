'''"iterative-bayesian", the method of Hartmann, Cheng, Thornton (2022).'''
