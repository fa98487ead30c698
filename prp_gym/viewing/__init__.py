"""Watching a controller or an agent while it runs: a session without graphics, and what shows it."""
