"""Finer meshes: what they show of the error of a solution, and where elements are too large."""
