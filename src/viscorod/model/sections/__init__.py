"""Cross sections and their variation along a rod."""
