"""prp_gym."""
