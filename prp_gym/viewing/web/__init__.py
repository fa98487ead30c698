"""A page in a browser that shows a session; it needs viser, which the extra `view` installs."""
