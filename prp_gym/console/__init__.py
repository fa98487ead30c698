"""What commands write in a terminal, a pipe or a log: results, progress and notes."""
