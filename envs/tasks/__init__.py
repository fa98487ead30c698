"""The tasks, each in a file of its own beside its numbers."""
