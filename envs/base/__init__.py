"""The components of which the suite's tasks are composed."""
