"""Figures for papers: of one episode, and of an agent's training; matplotlib is imported on use."""
