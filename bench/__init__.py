"""Measurements of speed; run by `make bench` or as `python -m bench.NAME`."""
