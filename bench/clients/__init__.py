"""Libraries that use the environments through Gymnasium alone, each in a virtual environment of its own."""
