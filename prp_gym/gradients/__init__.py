"""Exact derivatives of the score of whole episodes by the settings of a controller."""
