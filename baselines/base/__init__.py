"""What controllers are built from: policies, settings, gains, references, declarations."""
