"""Training of agents: recipes, runs with checkpoints, and the export of trained models."""
