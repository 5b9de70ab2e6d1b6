"""Loads, functions of time, initial values, events."""
