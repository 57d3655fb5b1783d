"""The method "iterative-bayesian", of Hartmann, Cheng, Thornton (2022)."""
