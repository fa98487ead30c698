"""Compiled libraries of the packaged tasks, controllers and action modes, for wheels (`make wheel`)."""
