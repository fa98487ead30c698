"""Trained agents: card, files and network, in numpy alone."""
