"""Processes and signals: locks of folders, interruptions, temporary files, workers."""
