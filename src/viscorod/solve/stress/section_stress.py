"""Stress, strain and loss at the points of a section, from its section forces and strains (LLT 2.2 to 2.6).

A point (x, y) of a section with the strains eps has, with J0 = 1 + y U01 - x U02 of the reference curvature,

    e33 = (stretch + bend_1 y - bend_2 x)/J0,    e11 = e22 = -nu e33                         (LLT 10, 13, 16)
    (2 e31, 2 e32) = shear strains of Saint-Venant's flexure and torsion under the shear forces and the torque

and the stresses s33 = E e33 + eta_E e33_t, s3a = 2 (G e3a + eta e3a_t) (LLT 17), with Maxwell branches likewise. LLT's
plane sections (their H1, H2) give the shear force and the torque only with correction factors; here warping does.

Stresses follow from forces: every part of a section force (elastic, viscous, of a branch, held) is spread over the
section as its moduli are, and so that its resultants are that part. In a curved rod that is Winkler's distribution of
the axial stress. The shear stress of dashpots in composites is that of the elastic section's strains, and what these
leave unbalanced is spread as the elastic stress is. The loss is that of strain rates spread likewise, scaled so that
the section loses what the rod does: the shear factors of simple shapes are Cowper's, which differ by some percent from
those of the energy.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from viscorod.model.sections.curved_section import curved_branches, curved_matrices
from viscorod.model.sections.stress_field import SectionSamples, resultants
from viscorod.solve.stress.recorded_rods import SectionHere
from viscorod.typing import Floats

__all__ = ["ForceParts", "PointFields", "SectionStress", "von_mises"]

AXIAL, SHEAR = [2, 3, 4], [0, 1, 5]
"""Strains that stretch fibres, and those that shear."""
DIRECTIONS = 150
"""Section forces under which the points that carry most are sought."""
AT_ONCE = 200
"""Section forces whose stresses are computed together."""
LITTLE = 1e-10
"""Part of the largest eigenvalue of a matrix with a unit diagonal that counts as nothing."""


@dataclass(frozen=True)
class ForceParts:
    """The parts of section forces ``(..., 6)`` [N, N m].

    Attributes:
        elastic: of the strains, and reactions that hold strains.
        viscous: of the rates, of the material's viscosity.
        branches: of the Maxwell branches ``(..., n, 6)``.
        unknown: of Maxwell branches whose strains were not kept; no loss follows from it.
    """

    elastic: Floats
    viscous: Floats
    branches: Floats
    unknown: Floats

    def mixed(self, weights: Floats) -> ForceParts:
        """Return the mean of the parts ``(t, k, ...)`` with the weights ``(k,)``."""
        return ForceParts(*(np.tensordot(weights, part, (0, 1)) for part in vars(self).values()))

    def at(self, chosen: np.ndarray) -> ForceParts:
        """Return the parts at some places of the first dimension."""
        return ForceParts(*(part[chosen] for part in vars(self).values()))


@dataclass(frozen=True)
class PointFields:
    """Fields at points of a section, ``(t, n, 3)`` in the order 31, 32, 33, and the loss ``(t, n)``.

    Attributes:
        stress: elastic and viscous together [Pa]; viscous: the viscous part [Pa].
        strain: shear strains 2 e31, 2 e32 and e33 of the elastic part; loss: power lost per volume [W/m^3].
    """

    stress: Floats
    viscous: Floats
    strain: Floats
    loss: Floats


class SectionStress:
    """One section with its materials: how it carries forces.

    Args:
        here: the section.
        curvature: reference curvatures about d1 and d2 ``(2,)`` [1/m].
    """

    def __init__(self, here: SectionHere, curvature: Floats) -> None:
        self.curvature = curvature
        self.field = here.section.stress_field(here.material)
        matrices = here.section.matrices(here.material)
        relaxing = here.section.branch_matrices(here.material)
        if here.corrected:
            matrices = curved_matrices(matrices, here.section, here.material, curvature)
            relaxing = curved_branches(relaxing, here.section, here.material, curvature)
        (stiffness, damping, _), (self.times, branches) = matrices, relaxing
        free = np.outer(*(2 * [~np.array(here.held)]))
        self.stiffness, self.damping = free * stiffness, free * damping
        self.branches = free * branches
        self._shear = stiffness[np.ix_(SHEAR, SHEAR)]
        materials = self.field.materials
        self._elastic = np.array([(m.youngs_modulus, m.shear_modulus) for m in materials])
        viscous = [
            (0.0, 0.0) if m.branches else (m.extensional_viscosity, m.shear_viscosity) for m in materials
        ]
        self._viscous = np.array(viscous)
        self._relaxing = [
            np.array(
                [
                    sum(
                        (np.array([b.youngs_modulus, b.shear_modulus]) for b in m.branches if b.time == time),
                        np.zeros(2),
                    )
                    for m in materials
                ]
            )
            for time in self.times
        ]
        rule, weight = self.field.rule, self.field.weight
        self._curved = rule.curved(curvature)
        balance = resultants(rule.points, weight, rule.flow / self._curved[:, None, None])
        self._balanced = np.linalg.inv(balance)

    def parts(self, strain: Floats, force: Floats, springs: Floats | None, *, moving: bool) -> ForceParts:
        """Return the parts of section forces.

        Args:
            strain, force: of the section ``(..., 6)``.
            springs: strains of the branches' springs ``(..., n, 6)``, None where they were not kept.
            moving: whether strains change; branches are relaxed, and nothing is viscous, where not.
        """
        elastic = strain @ self.stiffness
        none = np.zeros((*force.shape[:-1], len(self.times), 6))
        rest = force - elastic
        zero = np.zeros_like(force)
        if not moving:
            return ForceParts(force, zero, none, zero)
        if len(self.times) and springs is None:
            held = ~self.stiffness.any(axis=0)
            return ForceParts(elastic + rest * held, zero, none, rest * ~held)
        relaxing = none if springs is None else np.einsum("jab,...jb->...ja", self.branches, springs)
        rest = rest - relaxing.sum(axis=-2)
        viscous = rest @ (_inverse(self.damping) @ self.damping)
        return ForceParts(elastic + rest - viscous, viscous, relaxing, zero)

    def fields(self, samples: SectionSamples, parts: ForceParts) -> PointFields:
        """Return stress, strain and loss at samples of the section, from parts of forces ``(t, ...)``."""
        elastic = self._stress(samples, self._elastic, self.stiffness, parts.elastic)
        unknown = self._stress(samples, self._elastic, self.stiffness, parts.unknown)
        viscous = unknown + self._stress(samples, self._viscous, self.damping, parts.viscous)
        loss = self._loss(samples, self._viscous, self.damping, parts.viscous)
        for k, (moduli, time) in enumerate(zip(self._relaxing, self.times, strict=True)):
            force = parts.branches[..., k, :]
            viscous = viscous + self._stress(samples, moduli, self.branches[k], force)
            loss = loss + self._loss(samples, moduli, self.branches[k], force) / time
        young, shear = self._elastic[samples.region].T
        strain = elastic / np.stack([shear, shear, young], axis=-1)
        return PointFields(elastic + viscous, viscous, strain, loss)

    def bound(self, parts: ForceParts) -> Floats:
        """Return bounds of the von Mises stress anywhere in the section ``(t,)`` [Pa], from parts of forces."""
        samples = self.field.patch.samples
        total = np.zeros((2, *parts.elastic.shape[:-1]))
        terms = [(self._elastic, self.stiffness, parts.elastic + parts.unknown)]
        terms += [(self._viscous, self.damping, parts.viscous)]
        terms += [
            (moduli, self.branches[k], parts.branches[..., k, :]) for k, moduli in enumerate(self._relaxing)
        ]
        for moduli, matrix, force in terms:
            axial, shear = self._maps(samples, moduli, matrix)
            total[0] += np.abs(force[..., AXIAL]) @ np.abs(axial).max(axis=0)
            total[1] += np.abs(force[..., SHEAR]) @ np.linalg.norm(shear, axis=1).max(axis=0)
        return np.asarray(np.sqrt(total[0] ** 2 + 3.0 * total[1] ** 2))

    def peaks(self, parts: ForceParts) -> Floats:
        """Return the largest von Mises stress in the section ``(t,)`` [Pa], to about a percent."""
        found = [
            von_mises(self.fields(self._likely, parts.at(rows)).stress).max(axis=1) for rows in _pieces(parts)
        ]
        return np.concatenate(found)

    @cached_property
    def _likely(self) -> SectionSamples:
        """The points that carry most under some one of many forces: other forces are worst near one of these."""
        samples = self.field.patch.samples
        axial, shear = self._maps(samples, self._elastic, self.stiffness)
        forces = np.random.default_rng(0).normal(size=(DIRECTIONS, 6))
        forces[:, AXIAL] /= np.abs(axial).max(axis=0)
        forces[:, SHEAR] /= np.linalg.norm(shear, axis=1).max(axis=0)
        worst = [
            np.argmax(von_mises(self._stress(samples, self._elastic, self.stiffness, force[None]))[0])
            for force in forces
        ]
        chosen = np.unique(worst)
        return SectionSamples(samples.points[chosen], samples.region[chosen], samples.flow[chosen])

    def _flow(self, samples: SectionSamples) -> Floats:
        """Return the shear stress of unit forces ``(n, 2, 3)``, over J0 and in balance with them."""
        return np.asarray(samples.flow / samples.curved(self.curvature)[:, None, None] @ self._balanced)

    def _sheared(self, samples: SectionSamples) -> Floats:
        """Return the shear strains times J0 ``(n, 2, 3)`` of unit shear strains and twist of the section."""
        factor = samples.curved(self.curvature) / self._elastic[samples.region, 1]
        return np.asarray(factor[:, None, None] * self._flow(samples) @ self._shear)

    def _maps(self, samples: SectionSamples, moduli: Floats, matrix: Floats) -> tuple[Floats, Floats]:
        """Return s33 per axial force ``(n, 3)`` and (s31, s32) per shear force ``(n, 2, 3)``.

        Args:
            samples: the points; moduli: in extension and shear of every region; matrix: of the section.
        """
        rule = self.field.rule
        weight = self.field.weight * moduli[rule.region, 0] / self._curved
        carried = np.einsum("q,qi,qj->ij", weight, rule.axial, rule.axial)
        modulus = moduli[samples.region]
        axial = (modulus[:, 0] / samples.curved(self.curvature))[:, None] * samples.axial @ _inverse(carried)
        share = moduli[:, 1] / self._elastic[:, 1]
        flow = self._flow(samples)
        if np.ptp(share) == 0.0:
            return axial, flow if share.any() else 0.0 * flow
        # as the strains of the elastic section make it, and the rest, which that does not balance, elastically
        spread = self._shear @ _inverse(matrix[np.ix_(SHEAR, SHEAR)])
        own = share[rule.region][:, None, None] * self._flow(rule) @ spread
        rest = np.eye(3) - resultants(rule.points, self.field.weight, own)
        return axial, share[samples.region][:, None, None] * flow @ spread + flow @ rest

    def _stress(self, samples: SectionSamples, moduli: Floats, matrix: Floats, force: Floats) -> Floats:
        axial, shear = self._maps(samples, moduli, matrix)
        across = np.einsum("ndi,ti->tnd", shear, force[..., SHEAR])
        return np.concatenate([across, (force[..., AXIAL] @ axial.T)[..., None]], axis=-1)

    def _loss(self, samples: SectionSamples, moduli: Floats, matrix: Floats, force: Floats) -> Floats:
        """Return the power per volume ``(t, n)`` of forces in dashpots, over a viscosity per modulus of 1 s."""
        found = np.zeros((len(force), len(samples.points)))
        if not moduli.any():
            return found
        rule, rate = self.field.rule, force @ _inverse(matrix)
        strains = (
            (AXIAL, 0, rule.axial[:, None], samples.axial[:, None]),
            (SHEAR, 1, self._sheared(rule), self._sheared(samples)),
        )
        for which, kind, everywhere, here in strains:
            weight = self.field.weight * moduli[rule.region, kind] / self._curved
            lost = np.einsum("q,qdi,qdj->ij", weight, everywhere, everywhere)
            own = rate[:, which] @ _between(lost, matrix[np.ix_(which, which)]).T
            size = np.einsum("ndi,ti->tnd", here, own) / samples.curved(self.curvature)[:, None]
            found += moduli[samples.region, kind] * np.sum(size**2, axis=-1)
        return found


def von_mises(stress: Floats) -> Floats:
    """Return the von Mises stress of s31, s32, s33 ``(..., 3)``."""
    return np.asarray(np.sqrt(stress[..., 2] ** 2 + 3.0 * (stress[..., 0] ** 2 + stress[..., 1] ** 2)))


def _pieces(parts: ForceParts) -> list[np.ndarray]:
    """Return the rows of forces in pieces whose stresses fit into memory."""
    count = len(parts.elastic)
    return np.array_split(np.arange(count), max(1, count // AT_ONCE))


def _scale(matrix: Floats) -> Floats:
    diagonal = np.diag(matrix)
    return np.divide(1.0, np.sqrt(diagonal), out=np.zeros(len(matrix)), where=diagonal > 0.0)


def _inverse(matrix: Floats) -> Floats:
    """Return the inverse of a symmetric, positive semi-definite matrix; 0 for what costs nothing."""
    scale = _scale(matrix)
    scaled = matrix * np.outer(scale, scale)
    return np.asarray(np.linalg.pinv(scaled, rcond=LITTLE, hermitian=True) * np.outer(scale, scale))


def _between(lost: Floats, wanted: Floats) -> Floats:
    """Return A with A^T lost A = wanted, the unit matrix where both are the same.

    Strain rates A e lose what the rates e do in the rod.
    """
    scale = _scale(lost)
    inverse = np.divide(1.0, scale, out=np.zeros_like(scale), where=scale > 0.0)
    first, second = (matrix * np.outer(scale, scale) for matrix in (lost, wanted))
    root, back = _root(first), _root(np.asarray(np.linalg.pinv(first, rcond=LITTLE, hermitian=True)))
    return np.asarray(scale[:, None] * (back @ _root(root @ second @ root) @ back) * inverse)


def _root(matrix: Floats) -> Floats:
    """Return the square root of a symmetric, positive semi-definite matrix."""
    values, vectors = np.linalg.eigh(0.5 * (matrix + matrix.T))
    return np.asarray((vectors * np.sqrt(np.maximum(values, 0.0))) @ vectors.T)
