"""Centre lines of rods and their frames."""
