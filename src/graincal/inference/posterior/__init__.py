"""The method "posterior", the default."""
