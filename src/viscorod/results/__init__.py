"""What comes back: runs and equilibria, read from a data set alone."""
