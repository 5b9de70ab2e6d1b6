"""Motions that a symmetry keeps in a plane: solved for in it, they are those of all unknowns. What has no such plane.

The reference is the same motion solved for in space (symmetry = "ignored"), and the same model turned.
"""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import viscorod as vr
from viscorod.analyses.discrete import DiscreteModel
from viscorod.analyses.motion import initial_state
from viscorod.analyses.motion_unknowns import motion_unknowns
from viscorod.solve.settings.motion import SimulateSettings

STIFFNESS = np.array([400.0, 500.0, 900.0, 0.06, 0.04, 0.05])
INERTIA = [0.1, 0.1, 0.1, 1e-6, 2e-6, 3e-6]
UPRIGHT = np.eye(3)
SLANTED = Rotation.from_rotvec([0.4, -0.7, 0.3]).as_matrix()
DURATION = 0.03


def section(stiffness=None, **given):
    C = np.diag(STIFFNESS) if stiffness is None else stiffness
    given = given or {"damping": (1e-4 * STIFFNESS).tolist()}
    return vr.StiffnessSection(C.tolist(), INERTIA, **given)


def coupled(i, j, size):
    """A stiffness in which two strains are coupled by a part of what there could be at most."""
    C = np.diag(STIFFNESS)
    C[i, j] = C[j, i] = size * np.sqrt(C[i, i] * C[j, j])
    return C


def gallows(R=UPRIGHT, own=None, out=0.0):
    """A pinned post with an arm on it, in the plane of x and y turned by R, held by a roller on a slope.

    All kinds of loads in the plane act on it, and ``out`` across it.
    """
    own = own or section()
    model = vr.Model()
    top = R @ [0.05, 0.3, 0.0]
    normal = tuple(R[:, 2])
    # the arm has other axes than the post, and is attached to it at an angle
    model.add("post", vr.Rod.straight((0, 0, 0), tuple(top), section=own, d1=normal, elements=2, order=2))
    model.add(
        "arm",
        vr.Rod.straight(
            tuple(top),
            tuple(top + R @ [0.2, 0.05, 0.0]),
            section=own,
            d1=tuple(np.cross(normal, R @ [0.2, 0.05, 0.0])),
            elements=1,
            order=3,
        ),
    )
    model.attach("post.end", "arm.start")
    axes = [tuple(R @ [0.3, 1.0, 0.0]), normal]
    model.support("post.start", fixed=["ux", "uy", "uz"], axes=axes)
    model.support("arm.end", fixed=["ux"], axes=axes)
    model.gravity(tuple(R @ [0.0, -9.81, 0.0]))
    model.force("arm@0.1", tuple(R @ [0.2, -0.3, out]))
    model.force("post.end", (0.0, 0.1, 0.2), following=True)
    model.moment("arm.end", tuple(R @ [0.0, 0.0, 0.01]), time=vr.Sine(amplitude=1.0, frequency=20.0))
    return model


def motion(model, symmetry="used", **given):
    given = {"duration": DURATION, "initial": "reference", "output_interval": DURATION / 6} | given
    return model.simulate(symmetry=symmetry, **given)


def close(found, wanted, within, R=UPRIGHT):
    """Compare positions (turned back by R), strains and section forces over their largest values."""
    for name, turn in (("position", R), ("strain", UPRIGHT), ("section_force", UPRIGHT)):
        a, b = found.data[name].values, wanted.data[name].values
        a = a @ turn if name == "position" else a
        np.testing.assert_allclose(a, b, rtol=0, atol=within * np.abs(b).max(), err_msg=name)


INTEGRATORS = {
    "radau": {"tolerance": 1e-4},
    "generalized_alpha": {"integrator": "generalized_alpha", "time_step": DURATION / 12},
    "midpoint": {"integrator": "midpoint", "time_step": DURATION / 12},
    "intrinsic": {"tolerance": 1e-4, "formulation": "intrinsic"},
}


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_a_motion_in_its_plane_is_that_of_all_unknowns(integrator):
    """Partly held nodes, rods with other axes, dead and following loads; and the same turned as a whole."""
    given = INTEGRATORS[integrator]
    found, wanted = motion(gallows(), **given), motion(gallows(), "ignored", **given)
    assert found.data.attrs["symmetry"] == "about the plane normal to z"
    assert wanted.data.attrs["symmetry"] == "ignored"
    close(found, wanted, 1e-9)
    assert np.abs(found.data["position"].values[..., 2]).max() < 1e-15
    turned = motion(gallows(SLANTED), **given)
    assert turned.data.attrs["symmetry"].startswith("about the plane normal to (")
    close(turned, found, 1e-9, SLANTED)


@pytest.mark.parametrize("formulation", ["geometric", "intrinsic"])
def test_initial_strains_in_a_plane_are_looked_at(formulation):
    def bent(*strain):
        model = vr.Model()
        rod = vr.Rod.straight((0, 0, 0), (0.3, 0, 0), section=section(), d1=(0, 0, 1), elements=1, order=3)
        model.add("beam", rod)
        model.clamp("beam.start")
        model.strain("beam", strain)
        return model

    given = {"tolerance": 1e-4, "formulation": formulation}
    found = motion(bent(0, 0, 0.01, 2.0, 0, 0), **given)
    assert found.data.attrs["symmetry"] == "about the plane normal to z"
    close(found, motion(bent(0, 0, 0.01, 2.0, 0, 0), "ignored", **given), 1e-9)
    twisted = motion(bent(0, 0, 0.01, 2.0, 0, 1e-6), **given)
    assert twisted.data.attrs["symmetry"].startswith("none")


def test_branches_in_a_plane_are_those_of_all_unknowns():
    relaxing = section(branches=[vr.MaxwellBranch(0.01, (0.5 * STIFFNESS).tolist())])
    found = motion(gallows(own=relaxing), tolerance=1e-4)
    assert found.data.attrs["symmetry"].startswith("about")
    close(found, motion(gallows(own=relaxing), "ignored", tolerance=1e-4), 1e-9)


def test_a_motion_next_to_a_plane_is_not_taken_for_one_in_it():
    """A load that is 1e-7 across the plane moves what it acts on, and leaves the rest as it was to second order."""
    flat, found = motion(gallows(), tolerance=1e-6), motion(gallows(out=1e-7), tolerance=1e-6)
    assert "normal to z, loads act out of the plane" in found.data.attrs["symmetry"]
    aside = np.abs(found.data["position"].values[..., 2]).max()
    assert 1e-11 < aside < 1e-7
    np.testing.assert_allclose(
        found.data["position"].values[..., :2], flat.data["position"].values[..., :2], rtol=0, atol=1e-10
    )


def cantilever(own=None, **given):
    model = vr.Model()
    rod = vr.Rod.straight((0, 0, 0), (0.3, 0, 0), section=own or section(), elements=1, order=2, **given)
    model.add("beam", rod)
    model.clamp("beam.start")
    model.force("beam.end", (0.0, 0.1, 0.0))
    return model


def with_joint():
    model = cantilever()
    model.add("more", vr.Rod.straight((0.3, 0, 0), (0.5, 0, 0), section=section(), elements=1, order=2))
    model.revolute("beam.end", "more.start", axis=(0, 0, 1))
    return model


def with_body(offset):
    model = cantilever()
    model.add("weight", vr.Body(mass=0.1, inertia=[1e-4, 1e-4, 1e-4], centre=(0.3, 0.02, offset)))
    model.attach("beam.end", "weight")
    return model


def changed(change):
    model = cantilever()
    change(model)
    return model


AXIS = {"d1": (0, 0, 1)}
ASYMMETRIC = {
    "a weak load across": (
        lambda: changed(lambda m: m.force("beam.end", (0, 0, 1e-12))),
        "normal to z, loads act",
    ),
    "a moment across": (
        lambda: changed(lambda m: m.moment("beam.end", (0, 1e-9, 0))),
        "normal to z, loads act",
    ),
    "a load at a station": (
        lambda: changed(lambda m: m.force("beam@0.1", (0, 1, 1e-9))),
        "normal to z, loads act",
    ),
    "a following load": (
        lambda: changed(lambda m: m.force("beam.end", (1e-9, 1e-9, 0), following=True)),
        "normal to z, loads act",
    ),
    "weight aslant": (lambda: changed(lambda m: m.gravity((0, -9.81, 1e-9))), "normal to z, loads act"),
    "a turned section": (lambda: cantilever(d1=(0, 1e-9, 1)), "1e-09, 1), loads act"),
    "a twisted rod": (lambda: cantilever(twist=1e-6), "normal to z, sections or bodies are turned"),
    "bending coupled": (
        lambda: cantilever(section(coupled(3, 4, 1e-9)), **AXIS),
        "normal to z, sections are not",
    ),
    "shear coupled with twist": (
        lambda: cantilever(section(coupled(1, 5, 1e-9)), **AXIS),
        "normal to z, sections are not",
    ),
    "stretch coupled with twist": (
        lambda: cantilever(section(coupled(2, 5, 1e-9)), **AXIS),
        "normal to z, sections are not",
    ),
    "a damped coupling": (
        lambda: cantilever(section(damping=(1e-4 * coupled(3, 5, 1e-9)).tolist()), **AXIS),
        "normal to z, sections are not",
    ),
    "a joint": (with_joint, "it has joints"),
    "a body aside": (lambda: with_body(1e-6), "normal to z, the shape is not plane"),
    "a support that moves across": (
        lambda: changed(lambda m: m.roller("beam.end", (0, 0, 1), motion={"ux": vr.Sine(1e-6, 1.0)})),
        "normal to z, supports move",
    ),
    "a roller aslant": (
        lambda: changed(lambda m: m.roller("beam.end", (0, 1, 1e-9))),
        "normal to z, supports are not",
    ),
    "a velocity across": (
        lambda: changed(lambda m: m.velocity("beam", angular=(0.0, 1e-9, 0.0))),
        "normal to z, the motion begins",
    ),
    "a strain across": (
        lambda: changed(lambda m: m.rest_strain("beam", [0, 0, 0, 0, 0, 1e-9])),
        "normal to z, rods are bent or twisted",
    ),
    "a law of drag": (lambda: changed(lambda m: m.drag("beam", linear_across=0.1)), "loads see"),
}


@pytest.mark.parametrize("name", ASYMMETRIC)
def test_a_slight_asymmetry_is_seen(name):
    make, reason = ASYMMETRIC[name]
    settings = SimulateSettings(duration=1.0, initial="reference")
    discrete = DiscreteModel.of(make(), settings)
    said = motion_unknowns(discrete, settings, initial_state(discrete, settings)[0]).symmetry
    assert said.startswith("none: ")
    assert reason in said


@pytest.mark.parametrize("own", [coupled(3, 1, 0.3), coupled(0, 5, 0.3)])
def test_couplings_within_the_plane_are_allowed(own):
    """A section that couples bending about z with shear in y, or shear across with twist, is its own mirror image."""
    run = motion(cantilever(section(own), d1=(0, 0, 1)), tolerance=1e-5)
    assert run.data.attrs["symmetry"] == "about the plane normal to z"
    close(run, motion(cantilever(section(own), d1=(0, 0, 1)), "ignored", tolerance=1e-5), 1e-9)


def test_lateral_buckling_is_seen_where_something_begins_it():
    """A deep beam under three times its lateral buckling load, 4.013 sqrt(EI GJ)/L^2 (Timoshenko and Gere 1961, 6.3).

    By its plane of symmetry it stays in that, and says so with a warning; in space rounding drives it out within the
    time, as a load across of a millionth does. At nine tenths of the load nothing is said.
    """
    C = np.array([4e4, 4e4, 1e5, 60.0, 0.06, 0.05])
    deep = section(np.diag(C), damping=(1e-4 * C).tolist())
    critical = 4.013 * np.sqrt(C[4] * C[5]) / 0.09

    def beam(down, across):
        model = vr.Model()
        rod = vr.Rod.straight((0, 0, 0), (0.3, 0, 0), section=deep, d1=(0, 0, 1), elements=2, order=3)
        model.add("beam", rod)
        model.clamp("beam.start")
        if down:
            model.force("beam.end", (0.0, -down, 0.0))
        model.force("beam.end", (0.0, 0.0, across))
        return model

    given = {"duration": 0.4, "initial": "reference", "tolerance": 1e-5}
    with pytest.warns(vr.AccuracyWarning, match="is unstable from t = .* more than 4e"):
        plane = beam(3.0 * critical, 0.0).simulate(**given)
    assert np.abs(plane.data["position"].values[..., 2]).max() < 1e-12
    assert "Symmetric about the plane normal to z" in plane.report()
    space = beam(3.0 * critical, 0.0).simulate(symmetry="ignored", **given)
    assert np.abs(space.data["position"].values[..., 2]).max() > 0.1
    assert "Symmetric about" not in space.report()
    pushed = beam(3.0 * critical, 1e-6 * critical).simulate(**given)
    assert np.abs(pushed.data["position"].values[..., 2]).max() > 0.1
    below = beam(0.9 * critical, 0.0).simulate(**given)
    assert not any("unstable" in text for text in below.warnings)
