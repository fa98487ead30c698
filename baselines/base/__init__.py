"""The parts of which controllers are built: policies, settings, gains, references, declarations."""
