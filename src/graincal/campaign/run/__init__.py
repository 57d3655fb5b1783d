"""The run: the loop around the filter, from the first sample to the answer."""
