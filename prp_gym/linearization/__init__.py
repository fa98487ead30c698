"""Linearisation: exact derivatives of the sampled robot, and of its loop with a controller."""

from prp_gym.linearization.linearize import linearize
from prp_gym.linearization.result import Linearization

__all__ = ["Linearization", "linearize"]
