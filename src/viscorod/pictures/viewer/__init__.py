"""A result as one HTML file: the moving rods in space beside their histories, without a server or a network."""

from __future__ import annotations

from viscorod.pictures.viewer.writing import view

__all__ = ["view"]
