"""Learned agents: their policies, their training and the learning algorithms; no library is imported here."""
