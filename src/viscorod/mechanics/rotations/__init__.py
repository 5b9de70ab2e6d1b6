"""Rotations and rigid motions: quaternions, exponential maps, motion within a step."""
