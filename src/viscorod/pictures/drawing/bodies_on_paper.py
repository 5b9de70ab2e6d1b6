"""Rigid bodies in the picture of a model: what their shape covers, their mass centre, what is fixed to them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from viscorod.model.bodies.body_shapes import Box, Cylinder, Sphere
from viscorod.model.connections.place import AnyPlace, BodyPlace
from viscorod.model.connections.resolved_places import position_of
from viscorod.pictures.drawing.paper import MOST_NAMES, Paper
from viscorod.pictures.style import GREEN
from viscorod.results.text_numbers import quantity
from viscorod.typing import Floats

if TYPE_CHECKING:
    from viscorod.model.bodies.body_base import AnyBody
    from viscorod.model.connections.joint_base import ResolvedJoint
    from viscorod.model.connections.spring import ResolvedSpring
    from viscorod.model.description.model_description import ModelDescription

__all__ = ["corners_of", "draw_bodies"]

_ROUND = 48
"""Points of a circle."""
_MOST_POINTS = 4
"""Named points of a body that are named in the picture."""


def draw_bodies(paper: Paper, model: ModelDescription, parts: list[ResolvedJoint | ResolvedSpring]) -> None:
    """Draw all bodies; ``parts``: joints and springs, whose places on bodies are fixed to them."""
    named = len(model.rods) + len(model.bodies) <= MOST_NAMES
    fixed = _fixed_to_bodies(model, parts)
    for name, body in model.bodies.items():
        centre = body.position()
        _outline(paper, body)
        for point in fixed[name]:
            paper.line(np.array([centre, point]), color=GREEN, linewidth=1.2, zorder=3)
        if body.points:
            points = np.array([body.position(point) for point in body.points])
            style: dict[str, Any] = {"color": GREEN, "markeredgewidth": 1.4, "zorder": 4}
            paper.symbols(points, "x", 5.0, "point of a body", **style)
        style = {"color": GREEN, "markeredgecolor": "white", "zorder": 5}
        paper.symbols(centre[None], "D", 9.0, "body", **style)
        if named:
            at = paper.view.on_paper(centre[None])[:, 0]
            paper.labels.add(at, f"{name}, {quantity(body.total_mass(), 'kg', 3)}", GREEN)
            if len(body.points) <= _MOST_POINTS:
                for word in body.points:
                    paper.labels.add(paper.view.on_paper(body.position(word)[None])[:, 0], word, GREEN)


def corners_of(body: AnyBody) -> Floats | None:
    """Return points of a body's surface whose hull it fills ``(n, 3)`` [m]; None of a body without a shape."""
    if isinstance(body, Box):
        signs = np.array(np.meshgrid(*[(-0.5, 0.5)] * 3)).reshape(3, -1).T
        local = signs * np.asarray(body.sides, dtype=float)
    elif isinstance(body, Cylinder | Sphere):
        angle = 2.0 * np.pi * np.arange(_ROUND) / _ROUND
        circle = np.stack([np.cos(angle), np.sin(angle), np.zeros(_ROUND)], axis=1)
        if isinstance(body, Sphere):  # its circles of latitude, from pole to pole
            sine, height = np.sin(angle[: _ROUND // 2 + 1]), np.cos(angle[: _ROUND // 2 + 1])
            rings = sine[:, None, None] * circle + height[:, None, None] * np.array([0.0, 0.0, 1.0])
            local = body.radius * rings.reshape(-1, 3)
        else:
            end = np.array([0.0, 0.0, 0.5 * body.length])
            local = np.concatenate([body.radius * circle - end, body.radius * circle + end])
    else:
        return None
    corners: Floats = body.position() + local @ body.frame().T
    return corners


def _outline(paper: Paper, body: AnyBody) -> None:
    """Draw what the shape of a body covers."""
    corners = corners_of(body)
    if corners is None:
        return
    from scipy.spatial import ConvexHull, QhullError

    flat = paper.view.on_paper(corners)
    try:
        hull = ConvexHull(flat.T).vertices
    except QhullError:  # thinner than can be seen
        return
    paper.axes.fill(*flat[:, hull], facecolor=GREEN, alpha=0.16, edgecolor=GREEN, linewidth=0.8, zorder=1.2)


def _fixed_to_bodies(
    model: ModelDescription, parts: list[ResolvedJoint | ResolvedSpring]
) -> dict[str, list[Floats]]:
    """Return what is drawn as fixed to each body: points, attached rod ends, places of joints and springs."""
    fixed = {name: [body.position(point) for point in body.points] for name, body in model.bodies.items()}

    def add(place: AnyPlace | None, point: Floats) -> None:
        if isinstance(place, BodyPlace):
            fixed[place.body].append(point)

    for group in model.nodes():
        for place in group:
            for other in group:
                if not isinstance(other, BodyPlace):
                    add(place, position_of(model, other)[0])
    for part in parts:
        add(part.a, part.at_a)
        add(part.b, part.at_b)
    return fixed
