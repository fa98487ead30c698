"""Tests of prp_gym.drawing."""
