"""A Kirchhoff rod in every analysis: the limit of rods that are ever stiffer against shear and stretch.

What is the same in all: the distance to the rod that holds these strains falls as one over the stiffness. Between both
formulations it falls with the mesh.
"""

from __future__ import annotations

import numpy as np
import pytest

import viscorod as vr

STIFF = (1e4, 1e6)
DAMPING = 0.02
LINEAR = {"formulation": "intrinsic", "damping": "linearised", "dynamics": "linear"}


def bow(large=None, order=4, elements=1, curved=True):
    """A cantilever, curved or straight, with three rotary inertias: held (None) or stiff in shear and stretch."""
    C = np.diag([large or 1.0] * 3 + [1.0, 1.6, 0.8])
    C[3, 5] = C[5, 3] = 0.2
    section = vr.StiffnessSection(C, [1.0, 1.0, 1.0, 0.02, 0.05, 0.07], DAMPING * C)
    more = {"section": section, "elements": elements, "order": order}
    more |= {} if large else {"constraints": "kirchhoff"}
    model = vr.Model()
    if curved:
        rod = vr.Rod.arc((0, 0, 0), (1, 0, 0), (0, 1, 0), 1.0, 1.2, **more)
    else:
        rod = vr.Rod.straight((0, 0, 0), (1, 0, 0), **more)
    model.add("bow", rod)
    model.clamp("bow.start")
    return model


def loaded(*args, **more):
    """The same under a swelling load."""
    model = bow(*args, **more)
    model.force("bow.end", (0.4, 0.8, 1.5), time=vr.Sine(1.0, amplitude=-1.0, phase=0.5 * np.pi, offset=1.0))
    return model


def statics(model):
    model.force("bow.end", (0.4, 0.8, 1.5))
    return model.equilibrium().field("position")[-1]


def path(model):
    model.force("bow.end", (0.2, 0.4, 0.5))
    return model.path(load_factor=1.0).field("position")[-1]


def modes(model):
    return model.modes(3, about="reference").eigenvalues


def moved(**settings):
    def run(model):
        model.force(
            "bow.end", (0.4, 0.8, 1.5), time=vr.Sine(1.0, amplitude=-1.0, phase=0.5 * np.pi, offset=1.0)
        )
        return model.simulate(0.2, initial="reference", **settings).field("position")[-1]

    return run


def turned(**settings):
    def run(model):
        found = model.steady(spin=(0, 0, 2.0), modes=3, **settings)
        return np.concatenate([found.eigenvalues, found.position("bow.end")])

    return run


ANALYSES = {
    "statics": statics,
    "path": path,
    "modes": modes,
    "radau": moved(tolerance=1e-8),
    "midpoint": moved(integrator="midpoint", time_step=0.01),
    "generalized_alpha": moved(integrator="generalized_alpha", time_step=0.01),
    "intrinsic radau": moved(tolerance=1e-8, formulation="intrinsic"),
    "intrinsic midpoint": moved(integrator="midpoint", time_step=0.01, formulation="intrinsic"),
    "linear dynamics": moved(tolerance=1e-8, **LINEAR),
    "steady": turned(),
    "intrinsic steady": turned(formulation="intrinsic"),
}


@pytest.mark.parametrize("name", ANALYSES)
def test_limit_of_stiff_rods(name):
    analysis = ANALYSES[name]
    limit = analysis(bow())
    size = np.abs(limit).max()
    errors = [np.abs(analysis(bow(large)) - limit).max() / size for large in STIFF]
    assert errors[1] < 1e-4
    assert errors[1] < 0.03 * errors[0]


def test_both_formulations_of_motion_agree_with_the_mesh():
    """Positions and forces of held strains: both formulations share no formula of strains."""
    settings = {"initial": "reference", "tolerance": 1e-8}
    errors = []
    for order in (3, 6):
        runs = [
            loaded(order=order).simulate(0.3, formulation=f, **settings) for f in ("geometric", "intrinsic")
        ]
        places, forces = (
            [run.data[field].values[-1] for run in runs] for field in ("position", "section_force")
        )
        errors.append([np.abs(np.subtract(*pair)).max() / np.abs(pair[0]).max() for pair in (places, forces)])
    errors = np.array(errors)
    assert (errors[1] < 0.1 * errors[0]).all()
    assert (errors[1] < [1e-4, 1e-3]).all()


def test_one_formulation_goes_on_where_the_other_ended():
    """Held strains of the other are off by the error of the mesh; closed at once, they make no energy."""
    model = bow()
    model.force("bow.end", (0.2, 0.3, 0.5), until=0.0)
    first = model.simulate(0.03, tolerance=1e-5, formulation="intrinsic")
    second = model.simulate(0.03, start=first, tolerance=1e-5)
    assert abs(second.energy.numerical[-1]) < 1e-5 * second.energy.elastic[0]
    assert second.energy.kinetic[0] == pytest.approx(first.energy.kinetic[-1], rel=1e-4)
