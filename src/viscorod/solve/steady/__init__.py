"""Steady rotations: motions in which every rod turns like a rigid body, bent and stressed as it is."""
