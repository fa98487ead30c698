"""Fuzzing: arguments, files and command lines that no user means, against the promise of typed errors."""
