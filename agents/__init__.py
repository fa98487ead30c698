"""Learned agents: the place for training, export and loading with Stable-Baselines3.

It holds nothing yet; every environment already passes Stable-Baselines3's checker and trains with it.
"""
