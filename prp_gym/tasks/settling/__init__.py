"""When a response counts as settled, as tasks declare it."""
