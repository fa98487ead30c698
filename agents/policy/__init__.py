"""Trained agents: their cards, files and networks; numpy is enough to run them."""
