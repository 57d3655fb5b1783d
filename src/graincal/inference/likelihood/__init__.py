"""How probable a reference is, given a response: what its errors are, and at which states it is compared."""
