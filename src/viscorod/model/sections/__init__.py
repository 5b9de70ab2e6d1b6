"""Cross sections and how they change along a rod."""
