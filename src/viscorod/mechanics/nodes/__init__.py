"""Nodes: inertia, applied loads, supports, prescribed motion, rigidly attached rod ends."""
