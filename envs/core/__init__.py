"""The episode loop and what it is made of."""
