"""Comparison: classical controllers and learned agents on the same episodes, with the same statistics."""
