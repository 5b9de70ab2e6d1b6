"""The element sets of a problem as arrays over all elements, and the order of their Gauss points in results."""

from __future__ import annotations

from itertools import accumulate
from typing import NamedTuple

import numpy as np

from viscorod.mechanics.elements.basis import lobatto
from viscorod.mechanics.elements.gauss_batch import ElementGroup
from viscorod.mechanics.elements.geometric_element import strains
from viscorod.mechanics.elements.internal_force import Elements
from viscorod.solve.formulations.system import GaussPositions
from viscorod.solve.once import once, once_of_layout
from viscorod.solve.problem.problem import ElementSet, Problem
from viscorod.typing import Floats, Integers


class ElementArrays(NamedTuple):
    """All elements of a problem; systems share these arrays and change none of them.

    Attributes:
        groups: which elements have one order; elements: all, with the strains of the reference shape.
        positions: of the Gauss points in the order of results; places: where these are in the arrays of ``elements``.
    """

    groups: tuple[ElementGroup, ...]
    elements: Elements
    positions: GaussPositions
    places: Integers


@once
def element_arrays(problem: Problem) -> ElementArrays:
    """Return the arrays of all elements of a problem, with the strains of the interpolated reference shape."""
    elements = all_elements(problem, unstressed_strains(problem))
    return ElementArrays(
        element_groups(problem), elements, gauss_positions(problem), _gauss_order(problem)[0]
    )


def all_branches(problem: Problem) -> Floats:
    """Return the stiffnesses of the Maxwell branches of all sections, numbered as in :func:`all_elements`."""
    return np.concatenate([e.branches for e in problem.sets])


@once_of_layout
def _gauss_order(problem: Problem) -> tuple[Integers, Integers, tuple[Integers, Floats, Floats]]:
    """Return the places of all Gauss points in the arrays of all elements, in the order of rods and arc lengths.

    Also that order of the points set by set, and their rods, arc lengths [m] and the lengths they stand for [m] in it.
    """
    rod, s, length = [], [], []
    for e in problem.sets:
        inside = e.shapes @ lobatto(e.order)[0]  # xi of the points
        rod.append(np.repeat(e.rod, e.section.shape[1]))
        s.append((e.start[:, None] + e.half_lengths[:, None] * (1.0 + inside)).ravel())
        length.append((e.half_lengths[:, None] * e.weights).ravel())
    rods, places = np.concatenate(rod), np.concatenate(s)
    order = np.lexsort((places, rods))
    along = rods[order], places[order], np.concatenate(length)[order]
    return gauss_indices(problem.sets)[order], order, along


def gauss_positions(problem: Problem) -> GaussPositions:
    """Return all Gauss points by rod and arc length, with their sections."""
    half_width, stiffness, damping, section = [], [], [], []
    first = 0
    for e in problem.sets:
        half_width.append(e.half_widths.ravel())
        stiffness.append(e.stiffness[e.section].reshape(-1, 6, 6))
        damping.append(e.damping[e.section].reshape(-1, 6, 6))
        section.append(e.section.ravel() + first)
        first += len(e.stiffness)
    _, order, along = _gauss_order(problem)
    return GaussPositions(
        *along,
        np.concatenate(half_width)[order],
        np.concatenate(stiffness)[order],
        np.concatenate(damping)[order],
        np.concatenate(section)[order],
    )


def gauss_indices(sets: tuple[ElementSet, ...]) -> Integers:
    """Return where all Gauss points are in the flattened arrays of :func:`all_elements`, set by set."""
    top = max(e.order for e in sets)
    places, first = [], 0
    for e in sets:
        numbers = top * np.arange(first, first + len(e.nodes))[:, None] + np.arange(e.order)
        places.append(numbers.ravel())
        first += len(e.nodes)
    return np.concatenate(places)


def element_groups(problem: Problem) -> tuple[ElementGroup, ...]:
    """Return which of the elements of a problem have one order."""
    first = accumulate((len(e.nodes) for e in problem.sets), initial=0)
    return tuple(
        ElementGroup(begin, len(e.nodes), e.order, e.coupled, e.damped, bool(e.held.any()))
        for begin, e in zip(first, problem.sets, strict=False)
    )


@once_of_layout
def unstressed_strains(problem: Problem) -> Floats:
    """Return the strains of the interpolated reference shape at all Gauss points ``(e, points, 6)``."""
    top = max(e.order for e in problem.sets)
    out = np.zeros((sum(len(e.nodes) for e in problem.sets), top, 6))
    frames = np.zeros((*out.shape[:2], 4))
    strains(all_elements(problem, out), problem.positions, problem.quaternions, out, frames)
    return out


class _Places(NamedTuple):
    """What of ``Elements`` does not depend on sections; see there."""

    order: Integers
    nodes: Integers
    links: Integers
    shapes: Floats
    slopes: Floats
    weights: Floats
    half_lengths: Floats
    slots: Integers


@once_of_layout
def _element_places(problem: Problem) -> _Places:
    """Return where all elements of a problem are."""
    top = max(e.order for e in problem.sets)
    count = sum(len(e.nodes) for e in problem.sets)
    shapes, slopes = np.zeros((top + 1, top, top + 1)), np.zeros((top + 1, top, top + 1))
    weights = np.zeros((top + 1, top))
    nodes = np.zeros((count, top + 1), dtype=np.int64)
    links = np.full((count, top + 1), -1, dtype=np.int64)
    slots = np.zeros((count, top + 1, top + 1), dtype=np.int64)
    first = 0
    for e in problem.sets:
        p = e.order
        rows = slice(first, first + len(e.nodes))
        shapes[p, :p, : p + 1], slopes[p, :p, : p + 1], weights[p, :p] = e.shapes, e.slopes, e.weights
        nodes[rows, : p + 1], links[rows, : p + 1] = e.nodes, e.links
        slots[rows, : p + 1, : p + 1] = e.slots
        first += len(e.nodes)
    order = np.repeat([e.order for e in problem.sets], [len(e.nodes) for e in problem.sets])
    half_lengths = np.concatenate([e.half_lengths for e in problem.sets])
    return _Places(order, nodes, links, shapes, slopes, weights, half_lengths, slots)


def all_elements(problem: Problem, reference: Floats) -> Elements:
    """Return all elements of a problem as one structure, with the strains of their unstressed shape."""
    where = _element_places(problem)
    section = np.zeros((len(where.nodes), where.weights.shape[1]), dtype=np.int64)
    first = first_section = 0
    for e in problem.sets:
        section[first : first + len(e.nodes), : e.order] = e.section + first_section
        first += len(e.nodes)
        first_section += len(e.stiffness)
    damping = np.concatenate([e.damping for e in problem.sets])
    return Elements(
        where.order,
        where.nodes,
        where.links,
        problem.link_positions,
        problem.link_quaternions,
        where.shapes,
        where.slopes,
        where.weights,
        where.half_lengths,
        section,
        np.concatenate([e.stiffness for e in problem.sets]),
        damping,
        problem.laws.present or bool(damping.any()),
        reference,
        where.slots,
        problem.laws,
    )
