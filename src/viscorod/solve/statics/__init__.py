"""Static equilibria and paths of them."""
