"""Training of agents, from a recipe to a finished run."""
