"""Fields and energies at the end of a step and between its stages, read from the stages."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from viscorod.mechanics.compilation.compiled import kernel, part
from viscorod.mechanics.nodes.inertia import kinetic_energy
from viscorod.mechanics.nodes.support_rows import Directions, SupportedNodes, reaction_wrenches
from viscorod.mechanics.rotations.pose_interpolation import MovingPoses, interpolate_poses
from viscorod.solve.transient.integrators.stage_data import Stages
from viscorod.solve.transient.integrators.step_task import StepAccount
from viscorod.solve.transient.integrators.tableau import Tableau
from viscorod.typing import Floats, Integers


class Reading(NamedTuple):
    """What fields and energies are read with.

    Attributes:
        places: where the points of the results are in ``(e, points)`` flattened; mass: of the nodes ``(n, 6, 6)``.
        split: marks nodes that are held in part ``(n,)``; supports: all of them.
        directions, scratch ``(10, 6)``: of one support and of one node.
    """

    places: Integers
    mass: Floats
    split: Floats
    supports: SupportedNodes
    directions: Directions
    scratch: Floats

    @classmethod
    def of(cls, places: Integers, mass: Floats, split: Floats, supports: SupportedNodes) -> Reading:
        """Allocate."""
        return cls(places, mass, split, supports, Directions.of(1), np.zeros((10, 6)))


@part
def copy_nodes(stages: Floats, stage: int, out: Floats) -> None:
    """Copy the rows of one stage ``(s, n, i)``."""
    for k in range(out.shape[0]):
        for a in range(out.shape[1]):
            out[k, a] = stages[stage, k, a]


@part
def copy_points(field: Floats, out: Floats, stage: int) -> None:
    """Copy a field at Gauss points ``(e, points, 6)`` to one stage of another."""
    for e in range(field.shape[0]):
        for g in range(field.shape[1]):
            for a in range(6):
                out[stage, e, g, a] = field[e, g, a]


@part
def read_points(strain: Floats, rate: Floats, force: Floats, places: Integers, out: Floats) -> float:
    """Bring the last stage of three fields into the order of results; return the largest shear or stretch."""
    last, top = strain.shape[0] - 1, strain.shape[2]
    largest = 0.0
    for g in range(places.shape[0]):
        e, point = places[g] // top, places[g] % top
        for a in range(6):
            out[0, g, a] = strain[last, e, point, a]
            out[1, g, a] = rate[last, e, point, a]
            out[2, g, a] = force[last, e, point, a]
        for a in range(3):
            size = abs(strain[last, e, point, a])
            largest = max(largest, size if size <= 1e300 else 1e300)
    return largest


@kernel
def read_state(strain: Floats, rate: Floats, force: Floats, places: Integers, out: Floats) -> float:
    """Bring strains, strain rates and section forces of a state into the order of results.

    Args:
        strain, rate, force: of one stage ``(1, e, points, 6)``.
        places: where the points of the results are in ``(e, points)`` flattened.
        out: ``(3, m, 6)``.

    Returns:
        the largest shear or stretch, 1e300 if any is undefined.
    """
    return read_points(strain, rate, force, places, out)


class StepEnd(NamedTuple):
    """The end of a step, made anew for every step, which snapshots keep.

    Attributes:
        r, q, twist, rate: of the nodes, with the rate of the twists ``(n, ...)``.
        points: strains, their rates and section forces in the order of results ``(3, m, 6)``.
        reactions: global wrenches of the supports at all stages ``(s, supports, 6)``.
    """

    r: Floats
    q: Floats
    twist: Floats
    rate: Floats
    points: Floats
    reactions: Floats

    @classmethod
    def of(cls, stages: Stages, reading: Reading) -> StepEnd:
        """Allocate."""
        s, n, _ = stages.r.shape
        return cls(
            np.empty((n, 3)),
            np.empty((n, 4)),
            np.empty((n, 6)),
            np.empty((n, 6)),
            np.empty((3, len(reading.places), 6)),
            np.empty((s, len(reading.supports.nodes), 6)),
        )


class Kept(NamedTuple):
    """What the next step begins with, overwritten at the end of every step.

    Attributes:
        force, reaction, stress: what accelerates the nodes ``(n, 6)``, reactions along the axes of the supports
            ``(m, 6)``, and the stresses ``(e, points, 6)`` at the end.
        X, stresses: coordinates of the stages, and stresses at the start and at the stages, for the prediction.
    """

    force: Floats
    reaction: Floats
    stress: Floats
    X: Floats
    stresses: Floats


@kernel
def end_step(
    h: float,
    method: Tableau,
    stages: Stages,
    account: StepAccount,
    target: Floats,
    reading: Reading,
    kept: Kept,
    end: StepEnd,
) -> tuple[float, float, float, float, float]:
    """Take the last stage of a step as its end.

    Args:
        h: step [s]; target: prescribed values of the supports at the stages ``(s, m, 6)``.
        kept, end: outputs.

    Returns:
        kinetic energy [J]; largest shear or stretch, 1e300 if any is undefined; work, viscous loss, and what loads
        dissipate outside [J].
    """
    last, several = stages.X.shape[0] - 1, stages.X.shape[0] > 1
    reaction_wrenches(
        reading.supports, target, stages.r, stages.q, stages.reaction, reading.directions, end.reactions
    )
    if several:
        copy_points(kept.stress, kept.stresses, 0)
        for i in range(last + 1):
            copy_points(stages.stress[i], kept.stresses, i + 1)
            copy_nodes(stages.X, i, kept.X[i])
    for e in range(kept.stress.shape[0]):
        for g in range(kept.stress.shape[1]):
            for a in range(6):
                kept.stress[e, g, a] = stages.stress[last, e, g, a]
    copy_nodes(stages.force, last, kept.force)
    copy_nodes(stages.reaction, last, kept.reaction)
    copy_nodes(stages.r, last, end.r)
    copy_nodes(stages.q, last, end.q)
    copy_nodes(stages.twist, last, end.twist)
    copy_nodes(stages.acceleration, last, end.rate)
    largest = read_points(stages.strain, stages.strain_rate, stages.stress, reading.places, end.points)
    work = loss = outside = 0.0
    for i in range(last + 1):
        work += account.powers[0, i] * method.weights[i]
        loss += account.powers[1, i] * method.weights[i]
        outside += account.powers[2, i] * method.weights[i]
    return kinetic_energy(reading.mass, end.twist), largest, h * work, h * loss, h * outside


class StageFields(NamedTuple):
    """Fields at the stages of a step ``(s, ...)``.

    Attributes:
        twist: of the nodes ``(s, n, 6)``; strain, rate, force: at the Gauss points ``(s, e, points, 6)``.
        reactions: of the supports ``(s, m, 6)``.
        powers: of loads, viscosity, and what loads dissipate ``(3, s)`` [W].
    """

    twist: Floats
    strain: Floats
    rate: Floats
    force: Floats
    reactions: Floats
    powers: Floats


class ResultFields(NamedTuple):
    """Strains, their rates and section forces ``(3, ..., m, 6)`` in the order of results; reactions ``(..., m, 6)``."""

    points: Floats
    reactions: Floats


class Between(NamedTuple):
    """Everything at ``k`` parts of a step, from ``row`` on.

    Attributes:
        row: index of the first part in the arrays, which may have more.
        r, q, twist: of the nodes ``(k, n, ...)``; fields: as in :class:`ResultFields`.
        energies: kinetic; work, viscous loss, and what loads dissipate outside, since the start of the step; and
            nothing ``(5, k)`` [J].
    """

    row: int
    r: Floats
    q: Floats
    twist: Floats
    fields: ResultFields
    energies: Floats

    @classmethod
    def of(cls, count: int, nodes: int, points: int, supports: int) -> Between:
        """Allocate for ``count`` parts."""
        return cls(
            0,
            np.empty((count, nodes, 3)),
            np.empty((count, nodes, 4)),
            np.empty((count, nodes, 6)),
            ResultFields(np.empty((3, count, points, 6)), np.empty((count, supports, 6))),
            np.zeros((5, count)),
        )

    def first(self, count: int) -> Between:
        """Return what it has of the first ``count`` parts, with fields and energies that are not written yet."""
        (_, _, points, _), (_, supports, _) = self.fields.points.shape, self.fields.reactions.shape
        fresh = Between.of(count, self.r.shape[1], points, supports)
        return fresh._replace(r=self.r[:count], q=self.q[:count], twist=self.twist[:count])


@part
def start_rates(method: Tableau, h: float, stages: Floats, twist: Floats, out: Floats) -> None:
    """Write the rates of the twists ``(n, 6)`` at the start of a step, of the polynomials through the stages."""
    for k in range(out.shape[0]):
        for a in range(6):
            total = 0.0
            for i in range(stages.shape[0]):
                total += method.start_derivative[i] / h * (stages[i, k, a] - twist[k, a])
            out[k, a] = total


@part
def between_stages(
    parts: Floats,
    k: int,
    h: float,
    method: Tableau,
    begin: ResultFields,
    stages: StageFields,
    places: Integers,
    found: Between,
) -> None:
    """Interpolate fields, and integrate powers, up to the place ``parts[k]`` of a step."""
    start, start_reaction = begin.points, begin.reactions
    out, reaction = found.fields.points, found.fields.reactions
    top, powers, place = stages.strain.shape[2], stages.powers, parts[k]
    k += found.row
    work = lost = outside = 0.0
    for g in range(places.shape[0]):
        for a in range(6):
            for field in range(3):
                out[field, k, g, a] = start[field, g, a]
    for m in range(reaction.shape[1]):
        for a in range(6):
            reaction[k, m, a] = start_reaction[m, a]
    for i in range(stages.strain.shape[0]):
        power, c, integral = place, 0.0, 0.0
        for p in range(stages.strain.shape[0]):
            c += method.values[i, p] * power
            integral += method.integrals[i, p] * power
            power *= place
        work += h * powers[0, i] * integral
        lost += h * powers[1, i] * integral
        outside += h * powers[2, i] * integral
        for g in range(places.shape[0]):
            e, point = places[g] // top, places[g] % top
            for a in range(6):
                out[0, k, g, a] += c * (stages.strain[i, e, point, a] - start[0, g, a])
                out[1, k, g, a] += c * (stages.rate[i, e, point, a] - start[1, g, a])
                out[2, k, g, a] += c * (stages.force[i, e, point, a] - start[2, g, a])
        for m in range(reaction.shape[1]):
            for a in range(6):
                reaction[k, m, a] += c * (stages.reactions[i, m, a] - start_reaction[m, a])
    found.energies[1, k], found.energies[2, k], found.energies[3, k] = work, lost, outside


@kernel
def read_between(
    parts: Floats,
    h: float,
    method: Tableau,
    start: MovingPoses,
    end: MovingPoses,
    begin: ResultFields,
    stages: StageFields,
    whole_loss: float,
    reading: Reading,
    poses: bool,
    fields: bool,
    found: Between,
) -> None:
    """Interpolate between the stages of a step.

    Poses and twists are polynomials of degree 5 through both ends of the step, of degree 3 where there is one stage;
    fields are those through the stages.

    Args:
        parts: places in the step ``(k,)``, 0 to 1, ascending; h: step [s].
        start, end: of the step; the rates at the start are written; begin: fields there.
        whole_loss: viscous loss of the step [J].
        poses, fields: write poses and twists; write the rest, in which these are.
        found: outputs.
    """
    if poses:
        start_rates(method, h, stages.twist, start.twist, start.rate)
        smooth, first = stages.twist.shape[0] > 1, found.row
        until = first + parts.shape[0]
        interpolate_poses(
            parts,
            h,
            start,
            end,
            reading.split,
            smooth,
            found.r[first:until],
            found.q[first:until],
            found.twist[first:until],
            reading.scratch,
        )
    if fields:
        loss = 0.0
        for k in range(parts.shape[0]):
            between_stages(parts, k, h, method, begin, stages, reading.places, found)
            row = found.row + k
            loss = max(
                loss, min(found.energies[2, row], whole_loss)
            )  # interpolation must not give energy back
            found.energies[0, row], found.energies[2, row] = (
                kinetic_energy(reading.mass, found.twist[row]),
                loss,
            )
