"""Learned agents: what training with Stable-Baselines3 needs; this module imports no learning library."""
