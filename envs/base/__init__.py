"""What tasks are composed of."""
