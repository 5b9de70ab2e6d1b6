"""Materials and the descriptions of their damping."""
