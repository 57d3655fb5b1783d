"""Samples, the densities that they are drawn from, and their weights."""
