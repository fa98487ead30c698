"""A second computation of the report's experiments, which shares no code with the package.

Pinocchio's rigid-body algorithms on numbers written here, controllers and references written anew, and the
same sampling: torques held for 1 ms, semi-implicit Euler steps of 1 ms. Its results are the literals in the
files of the experiments. `python -m tests.reproduction.independent` compares them, `--write` renews them.
"""
