"""Draw models and results: plots, animations, and a page with the motion in space."""
