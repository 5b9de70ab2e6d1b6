"""Results: runs, equilibria, steady rotations and sweeps, read from a data set alone."""
