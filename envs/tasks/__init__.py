"""The tasks, one a file, each beside its numbers."""
