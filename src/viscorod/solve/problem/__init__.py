"""Discretise a model: mesh, nodes, elements, joints and loads as frozen arrays."""
