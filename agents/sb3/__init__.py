"""Adapters between the environments of this suite and Stable-Baselines3."""
