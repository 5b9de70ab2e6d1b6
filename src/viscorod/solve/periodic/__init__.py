"""Periodic motions: orbits by Fourier collocation, their stability, and how they change with frequency or amplitude."""
