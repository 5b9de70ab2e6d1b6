"""Modes followed along a parameter, a speed or a load factor, and the values at which something happens to them."""
