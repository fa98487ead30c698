"""Measurements: speed and gain sweeps; run by `make bench` or as `python -m bench.NAME`."""
