"""Approximate theories of planar straight beams: Euler-Bernoulli, Timoshenko, von Karman."""
