"""One short program for each library; the documentation shows them as they are."""
