"""Solvers: discretisation, linear algebra, statics, transients, modes, steady rotations."""
