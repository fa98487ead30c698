"""What frames show beside the robot: palette, overlay items, surface, light and points of view."""
