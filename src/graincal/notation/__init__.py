"""How numbers, quantities and their symbols are written, in sentences, tables and on axes: whoever says something uses it."""
