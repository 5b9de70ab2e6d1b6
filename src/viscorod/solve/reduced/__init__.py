"""The intrinsic equations in a few modes of velocities and strains, with quadratic coefficients."""
