"""Limits of what the texts of files may hold, far above anything that this package writes."""

DEPTH = 32
"""Largest number of mappings and lists within each other."""

INTEGER_DIGITS = 40
"""Largest number of digits of a whole number; the 128 bits of a generator's state have 39."""
