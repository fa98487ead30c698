"""Tests of prp_gym.recording."""
