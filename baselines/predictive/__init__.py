"""One iteration of iterative LQR with torque limits, in NumPy and in code compiled from its formulas."""
