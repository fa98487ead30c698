"""Between this suite and Stable-Baselines3."""
