"""Derivatives of equilibria and motions by the arrays of the discretised problem: directly, and by the adjoint."""
