"""The declared action modes, one module for each family of controllers."""
