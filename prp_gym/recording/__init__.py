"""Videos of episodes: an environment's frames beside numbers and strip charts that run with the time."""
