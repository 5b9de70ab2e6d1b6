"""The base class of everything a user describes, and the values that its fields accept."""
