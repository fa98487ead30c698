"""One iteration of iterative LQR with torque limits: its formulas, in NumPy and in code compiled from them."""
