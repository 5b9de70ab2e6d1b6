"""The search of a fit ends in one minimum from all starts near it, or says that it has not come to rest.

Steps that follow their errors make a motion jump by what they err by wherever a number changes which steps are taken.
Of a rod with two Maxwell branches, whose law does not quite hold, searches ended where these jumps caught them.
"""

import numpy as np
import pytest

import viscorod as vr
from viscorod.analyses.case_run import run_case
from viscorod.analyses.identification.members import members_of
from viscorod.casefile.case import case_from_dict
from viscorod.solve.estimation.least_squares import Scaled, estimate, searched
from viscorod.solve.estimation.noise import Noise, Series, SeriesNoise
from viscorod.solve.estimation.unknowns import Unknown, Unknowns

E = "materials.silicone.youngs_modulus"
RATIOS = [f"materials.silicone.damping.extension_ratios[{k}]" for k in (0, 1)]
TIMES = np.linspace(0.0, 1.5, 150)
OMEGA, NOISE = 40.0, 1e-3


def bar(youngs_modulus=3e5, damping=None, **simulate):
    rod = {
        "shape": "straight", "start": [0.0, 0.0, 0.0], "end": [0.0, 0.0, 0.1], "d1": [1.0, 0.0, 0.0],
        "section": {"shape": "rectangle", "width": 0.03, "height": 0.03},
        "material": "silicone", "elements": 1, "order": 3,
    }  # fmt: skip
    branches = {"kind": "prony", "extension_ratios": [0.1, 0.1], "extension_times": [0.007, 0.07]}
    material = {"youngs_modulus": youngs_modulus, "poissons_ratio": 0.49, "density": 1070.0}
    return case_from_dict(
        {
            "materials": {"silicone": {**material, "damping": damping or branches}},
            "rods": {"bar": rod},
            "supports": [{"kind": "clamp", "at": "bar.start"}],
            "loads": [{"kind": "force", "at": "bar.end", "value": [0.5, 0.0, 0.0], "until": 0.0}],
            "simulate": {"duration": 1.5, **simulate},
        }
    )


ABOUT = {"place": "bar.end", "quantity": "displacement", "direction": "x"}


def test_two_branches_have_one_minimum_from_three_starts():
    """The record is that of three branches at other times, with little noise: there is no law that fits it to noise."""
    true = {
        "kind": "prony", "extension_ratios": [0.08, 0.12, 0.06], "extension_times": [0.002, 0.02, 0.2]
    }  # fmt: skip
    clock = vr.Record(TIMES, np.zeros(len(TIMES)), **ABOUT)
    clean = clock.predicted(run_case(bar(damping=true, tolerance=1e-7)))
    values = clean + 1e-5 * np.random.default_rng(2).normal(size=len(TIMES))
    record = vr.Record(TIMES, values, **ABOUT, noise=1e-5)
    fits = [
        vr.identify(
            bar(tolerance=2e-5), record, {E: start, **dict.fromkeys(RATIOS)}, coloured=False, profile=False
        )
        for start in (2.7e5, 3.0e5, 3.4e5)
    ]
    assert all(fit.unsettled == 0.0 for fit in fits)
    for key in (E, *RATIOS):
        found = [fit[key].value for fit in fits]
        assert np.ptp(found) < 0.05 * fits[0][key].standard_error


def test_a_motion_with_held_steps_is_a_smooth_function():
    """Differences over a thousandth and over a millionth of the modulus are the same derivative."""
    member = members_of([(bar(tolerance=1e-4), vr.Record(TIMES, np.zeros(len(TIMES)), **ABOUT))])[0]
    (record,) = member.records

    def slope(part):
        high, low = (member.predicted(record, {E: 3e5 * (1.0 + sign * part)}) for sign in (1.0, -1.0))
        return (high - low) / (2.0 * part)

    rough = [np.abs(slope(part)).max() for part in (1e-4, 1e-6)]
    member.hold({E: 3e5})
    wide, narrow = slope(1e-4), slope(1e-6)
    assert np.abs(wide - narrow).max() < 1e-3 * np.abs(wide).max()
    assert rough[1] > 2.0 * rough[0]  # as steps are chosen anew, a difference is mostly of what they err by


@pytest.mark.parametrize(
    "settings",
    [
        {"integrator": "midpoint", "duration": 0.3},
        {"integrator": "generalized_alpha", "duration": 0.3},
        {"duration": 1.5},
    ],
)
def test_held_steps_are_those_that_were_chosen(settings):
    """A run through the steps that a run chose is that run, up to the iteration of its steps."""
    times = TIMES[settings["duration"] >= TIMES]
    member = members_of([(bar(**settings), vr.Record(times, np.zeros(len(times)), **ABOUT))])[0]
    (record,) = member.records
    free = member.predicted(record, {E: 3e5})
    member.hold({E: 3e5})
    count = len(member.step_ends)
    held = member.predicted(record, {E: 3e5})
    assert np.abs(held - free).max() < 1e-6 * np.abs(free).max()
    member.predicted(record, {E: 3.3e5})
    assert len(member.step_ends) == count > 20


class Oscillator:
    """A damped oscillator by its stiffness and time constant, with steps: what they err by jumps, unless held."""

    accuracy = 1e-4

    def __init__(self, size):
        self.size, self.held = size, None

    def hold(self, unknowns):
        self.held = unknowns.copy()

    def values(self, unknowns):
        omega = OMEGA * np.sqrt(unknowns[0])
        chosen = unknowns if self.held is None else self.held
        jump = np.random.default_rng(abs(hash(chosen.tobytes())) % 2**32).normal(size=4)
        wave = sum(height * np.sin((k + 1.3) * TIMES) for k, height in enumerate(jump))
        return np.exp(-TIMES / unknowns[1]) * np.cos(omega * TIMES) + self.size * wave

    def jacobian(self, unknowns, *, rough=False):
        here, columns = self.values(unknowns), []
        for k in (0, 1):
            there = unknowns.copy()
            there[k] *= 1.0 + 1e-6
            columns.append((self.values(there) - here) / (1e-6 * unknowns[k]))
        return np.stack(columns, axis=1)


SOUGHT = Unknowns([Unknown("k", 1.1, logarithmic=True), Unknown("T", 0.5, logarithmic=True)])


def measured():
    return np.exp(-TIMES / 0.6) * np.cos(OMEGA * TIMES) + NOISE * np.random.default_rng(1).normal(
        size=len(TIMES)
    )


def series(size=NOISE):
    return [Series("tip", slice(0, len(TIMES)), True, np.full(len(TIMES), size), told=True)]


def test_a_search_holds_what_predictions_choose():
    """What steps err by is as large as the noise: the minimum is that of the closed form, within what they move it."""
    found = estimate(Oscillator(NOISE), measured(), series(), SOUGHT, coloured=False)
    assert found.unsettled == 0.0
    exact = estimate(Oscillator(0.0), measured(), series(), SOUGHT, coloured=False)
    errors = 1.0 / np.linalg.norm(exact.whitened_slopes, axis=0)
    assert np.abs(found.z - exact.z).max() < 2.0 * errors.max()


def test_a_search_that_does_not_come_to_rest_says_so():
    """Slopes of the wrong sign lead nowhere."""

    class Wrong(Oscillator):
        def jacobian(self, unknowns, *, rough=False):
            return -super().jacobian(unknowns)

    found = estimate(Wrong(0.0), measured(), series(), SOUGHT, coloured=False)
    assert found.unsettled > 1.0


def test_a_search_ends_where_a_step_gains_nothing():
    """The gradient of the sum of squares is zero there: the closed form's, by differences."""
    model, noise = Oscillator(0.0), Noise(tuple(series()), (SeriesNoise(1.0),))
    z = searched(Scaled(model, SOUGHT), measured(), noise, SOUGHT.bounds, SOUGHT.start, SOUGHT.start)

    def square(z):
        return float(np.sum((measured() - model.values(SOUGHT.values(z))) ** 2)) / NOISE**2

    steps = 1e-4 * np.eye(2)
    slopes = model.jacobian(SOUGHT.values(z)) * SOUGHT.values(z) / NOISE
    gradient = np.array([(square(z + step) - square(z - step)) / 2e-4 for step in steps])
    assert np.abs(gradient / np.linalg.norm(slopes, axis=0)).max() < 0.05  # of a standard error, twice
