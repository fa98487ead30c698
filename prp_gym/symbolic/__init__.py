"""Formulas as expression graphs: traced from NumPy code, differentiated exactly, and compiled."""
