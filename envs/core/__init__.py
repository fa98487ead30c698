"""The episode loop and its components."""
