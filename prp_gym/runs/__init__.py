"""Jobs, the workers that run them, and the store of finished ones."""
