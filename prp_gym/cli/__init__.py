"""The command `prp-gym`, one module a command."""
