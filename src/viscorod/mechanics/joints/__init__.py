"""Joints and springs between nodes: coordinates, forces, tangents."""
