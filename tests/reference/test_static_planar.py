"""Planar statics against elliptic integrals, a published beam and the exact circle (cases A1, A3, A5, A7)."""

from __future__ import annotations

import numpy as np
import pytest

import viscorod as vr

from .cases import cantilever, slope, stiff

# lambda = P L^2/EI: w/L, u/L, rotation of the tip; elliptic integrals, the rows 1, 2, 5, 10 equal Mattiasson 1981
# Table 1
ELASTICA = {
    0.2: (0.066364, 0.002647, 0.099636),
    1: (0.301721, 0.056433, 0.461352),
    2: (0.493457, 0.160642, 0.781750),
    5: (0.713792, 0.387628, 1.215368),
    10: (0.810609, 0.554996, 1.430286),
    15: (0.847716, 0.635286, 1.501840),
}


@pytest.mark.parametrize("load", ELASTICA)
def test_elastica(load):
    """A1, six digits: the section is so stiff in shear and stretch (1e9) that neither shows in the sixth digit."""
    model = cantilever(stiff(1e9, 1e9, 1.0, 1.0), elements=4, order=6)
    model.force("beam.end", (0, load, 0))
    found = model.equilibrium()
    w, u, angle = ELASTICA[load]
    moved = found.displacement("beam.end")
    assert moved[1] == pytest.approx(w, abs=6e-7)
    assert -moved[0] == pytest.approx(u, abs=6e-7)
    assert found.rotation("beam.end")[2] == pytest.approx(angle, abs=6e-7)
    assert abs(moved[2]) < 1e-12


def test_geradin_cardona_cantilever():
    """A3: converged by an independent solver; SHARPy's test asserts 0.596, -2.159, 0.6720."""
    model = cantilever(stiff(3.231e8, 4.8e8, 9.346e6, 1e6), length=5.0, elements=4, order=5)
    model.force("beam.end", (0, -600e3, 0))
    found = model.equilibrium()
    assert found.displacement("beam.end")[:2] == pytest.approx([-0.596471, -2.159694], abs=1e-6)
    assert abs(found.rotation("beam.end")[2]) == pytest.approx(0.672006, abs=1e-6)


def rolled(elements, order, turns=1.0):
    """Errors over length, at element ends and at all nodes, of a cantilever rolled up by an end moment."""
    length, stiffness = 12.0, 30e6 / 12
    model = cantilever(stiff(1.25e7, 30e6, stiffness, 4e6), length=length, elements=elements, order=order)
    moment = 2 * np.pi * turns * stiffness / length
    model.moment("beam.end", (0, 0, moment))
    found = model.equilibrium()
    stations = found.data["station_s"].values
    radius = stiffness / moment
    exact = np.column_stack(
        [radius * np.sin(stations / radius), radius * (1 - np.cos(stations / radius)), 0 * stations]
    )
    error = np.abs(found.data["position"].values[-1] - exact) / length
    return error[::order].max(), error.max()


def test_roll_up_to_full_circle():
    """A5: exact for any moment, since the section force vanishes; inner nodes converge less fast than element ends."""
    ends, everywhere = rolled(4, 5)
    assert ends < 1e-8
    assert everywhere < 1e-7


@pytest.mark.parametrize("order", [1, 2, 3, 4])
def test_roll_up_order(order):
    """A5: the error over all nodes falls at order p + 1 at least."""
    counts = {1: (16, 32, 64), 2: (8, 16, 32), 3: (6, 12, 24), 4: (4, 8, 16)}[order]
    errors = [rolled(n, order)[1] for n in counts]
    assert slope([1 / n for n in counts], errors) > order + 1 - 0.2


@pytest.mark.parametrize(
    ("angle", "load", "x", "y"),
    [
        (20, 1.01540, 0.96973, 0.21941),
        (60, 1.15172, 0.74102, 0.59321),
        (100, 1.51839, 0.34899, 0.79154),
        (140, 2.54226, -0.10692, 0.75039),
    ],
)
def test_post_buckling_of_clamped_column(angle, load, x, y):
    """A7: elliptic integrals. The tip's rotation is prescribed, so the bent branch is found; its moment must vanish."""
    critical = np.pi**2 / 4
    bent = cantilever(stiff(1e9, 1e9, 1.0, 1.0), elements=4, order=6)
    bent.force("beam.end", (-load * critical, 0, 0))
    bent.support("beam.end", ("rx", "ry"), motion={"rz": vr.Constant(np.radians(angle))})
    found = bent.equilibrium(load_steps=4)
    assert found.position("beam.end")[:2] == pytest.approx([x, y], abs=1e-5)
    moment = found.reactions.sel(support="beam.end", motion="mz")
    assert abs(float(moment)) < 1e-4 * load * critical
    assert np.degrees(found.rotation("beam.end")[2]) == pytest.approx(angle, abs=1e-9)


@pytest.mark.parametrize(
    ("ends", "factor"),
    [("clamped-free", 0.25), ("pinned", 1.0), ("clamped", 4.0)],
)
def test_euler_loads_by_inertia_count(ends, factor):
    """A7: one more negative eigenvalue of the tangent on either side of the critical load, to 0.01 %."""
    critical = factor * np.pi**2

    def negative(load):
        model = vr.Model()
        section = vr.StiffnessSection([1e8, 1e8, 1e8, 1.0, 5.0, 1.0], [1, 1, 1, 1e-3, 1e-3, 2e-3])
        model.add("column", vr.Rod.straight((0, 0, 0), (1, 0, 0), section=section, elements=4, order=5))
        if ends == "pinned":
            model.support("column.start", ("ux", "uy", "uz", "rx"))
            model.support("column.end", ("uy", "uz"))
        else:
            model.clamp("column.start")
        if ends == "clamped":
            model.guide("column.end", along=(1, 0, 0))
        model.force("column.end", (-load, 0, 0))
        return model.equilibrium(search=False).negative_eigenvalues

    assert negative(critical * (1 - 1e-4)) == 0
    assert negative(critical * (1 + 1e-4)) == 1


def test_greenhill_self_weight():
    """A8: a standing column buckles under its own weight at 7.8373474 EI/L^2 per length (root of J_-1/3)."""

    def negative(weight):
        model = cantilever(vr.StiffnessSection([1e8, 1e8, 1e8, 1, 5, 1], [1, 1, 1, 1e-3, 1e-3, 2e-3]))
        model.distributed_force("beam", (-weight, 0, 0))
        return model.equilibrium(search=False).negative_eigenvalues

    assert negative(7.8373474 * (1 - 1e-4)) == 0
    assert negative(7.8373474 * (1 + 1e-4)) == 1


def test_turns_that_the_first_mesh_cannot_tell():
    """A5 with meshes left to the program: four turns and a quarter are beyond the two elements it begins with.

    A motion and modes begin there as well; elements that were given stay, and the message asks for more.
    """
    model, angle = vr.Model(), 2.0 * np.pi * 4.25
    model.add("beam", vr.Rod.straight((0, 0, 0), (1, 0, 0), section=stiff(1e6, 1e6, 1.0, 1.0)))
    model.clamp("beam.start")
    model.moment("beam.end", (0, 0, angle))
    exact = np.array([np.sin(angle), 1.0 - np.cos(angle), 0.0]) / angle
    assert model.equilibrium().position("beam.end") == pytest.approx(exact, abs=2e-5)
    assert model.modes(1).positions[-1] == pytest.approx(exact, abs=2e-5)
    assert model.simulate(1e-7).data["position"].values[0, -1] == pytest.approx(exact, abs=2e-5)
    model.rods["beam"] = vr.Rod.straight((0, 0, 0), (1, 0, 0), section=stiff(1e6, 1e6, 1.0, 1.0), elements=2)
    with pytest.raises(vr.SolveError, match="give the rod more elements"):
        model.equilibrium()
