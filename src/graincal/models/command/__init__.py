"""Anybody's program as a model: its inputs, a folder for each evaluation, how it is run, and what it came to."""
