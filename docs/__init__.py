"""The documentation; its tables are generated from the code by `docs.generate`."""
