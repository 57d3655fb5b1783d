'''"posterior", the default method.'''
