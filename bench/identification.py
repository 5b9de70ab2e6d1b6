"""Do intervals of identified numbers hold? Five problems, many noisy data sets each.

``python bench/identification.py`` makes 1000 data sets of each problem with white noise, finds its numbers in
every one, and prints how many intervals of 95 % hold the truth, and how wide they are over Cramer and Rao's bound.
The rod is computed at the truth and beside it; data sets are then fitted to the first-order expansion of its
predictions in the logarithms of the numbers, by the same estimator that `viscorod.identify` has. That is no
shortcut for what is counted, the estimator, the noise and the intervals, but says nothing of what is beyond first
order: for this, ``--real N`` fits N data sets with the rods themselves. ``--wrong`` adds a motion that the model
does not have.
"""

from __future__ import annotations

import argparse
import copy
import time

import numpy as np

import viscorod as vr
from viscorod.analyses.case_run import run_case
from viscorod.analyses.identification.case_predictions import CasePredictions
from viscorod.analyses.identification.members import members_of
from viscorod.analyses.identification.sought import series_of, sought
from viscorod.casefile.case import case_from_dict
from viscorod.solve.estimation.intervals import covariance, intervals
from viscorod.solve.estimation.least_squares import estimate
from viscorod.solve.estimation.noise import ljung_box

CLAMPED = {
    "rods": {
        "beam": {
            "shape": "straight",
            "start": [0.0, 0.0, 0.0],
            "end": [0.3, 0.0, 0.0],
            "section": {"shape": "rectangle", "width": 0.01, "height": 0.01},
            "material": "rubber",
            "elements": 2,
            "order": 4,
        }
    },
    "supports": [{"kind": "clamp", "at": "beam.start"}],
}
RUBBER = {"youngs_modulus": 1e6, "poissons_ratio": 0.3, "density": 1000.0}
E = "materials.rubber.youngs_modulus"
DAMPING = "materials.rubber.damping"


def case_of(material, simulate, loads=(), **more):
    content = copy.deepcopy(CLAMPED) | {"materials": {"rubber": RUBBER | material}, "loads": list(loads)}
    return case_from_dict(content | {"simulate": simulate} | more)


def history(case, noise, name="tip", place="beam.end", direction="y", count=500, quantity="displacement"):
    times = np.linspace(0.0, case.settings.duration, count)
    about = {"place": place, "direction": direction, "quantity": quantity, "noise": noise, "name": name}
    clean = vr.Record(times, np.zeros(count), **about).predicted(run_case(case))
    return vr.Record(times, clean, **about)


def swing():
    """LLT swing: Young's modulus and the time of bending."""
    pull = {"kind": "force", "at": "beam.end", "value": [0.0, 0.035, 0.0], "until": 0.0}
    case = case_of(
        {"damping": {"shear_time": 0.02, "bulk_time": 0.02}}, {"duration": 5.0, "tolerance": 1e-5}, [pull]
    )
    return [(case, history(case, 2e-3))], [E, f"{DAMPING}.shear_time, {DAMPING}.bulk_time"]


def branches():
    """A rod of a material with one Maxwell branch: modulus, ratio and time of the branch."""
    pull = {"kind": "force", "at": "beam.end", "value": [0.0, 0.02, 0.0], "until": 0.0}
    prony = {"kind": "prony", "extension_ratios": [0.3], "extension_times": [0.2]}
    case = case_of({"damping": prony}, {"duration": 4.0, "tolerance": 1e-5}, [pull])
    return [(case, history(case, 1e-3))], [
        E,
        f"{DAMPING}.extension_ratios[0]",
        f"{DAMPING}.extension_times[0]",
    ]


def frame():
    """Two rods with a joint that damps: material time and damper of the joint, seen at two places."""
    content = copy.deepcopy(CLAMPED)
    content["materials"] = {"rubber": RUBBER | {"damping": {"shear_time": 0.005, "bulk_time": 0.005}}}
    content["rods"]["arm"] = content["rods"]["beam"] | {"start": [0.3, 0.0, 0.0], "end": [0.3, 0.2, 0.0]}
    joint = {"kind": "revolute", "a": "beam.end", "b": "arm.start", "axis": [0.0, 0.0, 1.0]}
    content["joints"] = [joint | {"stiffness": {"rz": 5e-3}, "damping": {"rz": 2e-4}}]
    content["loads"] = [{"kind": "force", "at": "arm.end", "value": [0.0, 0.01, 0.0], "until": 0.0}]
    case = case_from_dict(content | {"simulate": {"duration": 3.0, "tolerance": 1e-5}})
    records = [
        history(case, 1e-3, "knee", "beam.end"),
        history(case, 1e-3, "hand", "arm.end", "x"),
    ]
    time_key = f"{DAMPING}.shear_time, {DAMPING}.bulk_time"
    return [(case, records)], [E, time_key, "joints[0].stiffness.rz", "joints[0].damping.rz"]


def shaft():
    """A shaft in torsion with a disc: the modulus, by Young's, and the shear time."""
    content = copy.deepcopy(CLAMPED)
    content["materials"] = {"rubber": RUBBER | {"damping": {"shear_time": 0.002, "bulk_time": 0.002}}}
    content["bodies"] = {
        "disc": {"shape": "box", "sides": [0.005, 0.06, 0.06], "centre": [0.3, 0.0, 0.0], "mass": 0.05}
    }
    content["attachments"] = [{"a": "beam.end", "b": "disc"}]
    content["loads"] = [{"kind": "moment", "at": "beam.end", "value": [0.002, 0.0, 0.0], "until": 0.0}]
    case = case_from_dict(content | {"simulate": {"duration": 3.0, "tolerance": 1e-5}})
    gauge = history(case, 0.02, "gauge", "beam@0.15", "twist", quantity="strain")
    return [(case, gauge)], [E, f"{DAMPING}.shear_time"]


def blade():
    """A blade by six frequencies with ratios: speed of sound by Young's modulus, time of bending."""
    content = copy.deepcopy(CLAMPED)
    content["materials"] = {"rubber": RUBBER | {"damping": {"shear_time": 0.002, "bulk_time": 0.002}}}
    case = case_from_dict(content | {"modes": {"count": 12, "about": "reference"}})
    found = run_case(case)
    noise = {"frequency_noise": 1e-3 * found.frequencies, "ratio_noise": 0.03 * found.damping_ratios}
    record = vr.ModesRecord(found.frequencies, found.damping_ratios, name="blade", **noise)
    return [(case, record)], [E, f"{DAMPING}.shear_time, {DAMPING}.bulk_time"]


PROBLEMS = {"swing": swing, "branches": branches, "frame": frame, "shaft": shaft, "blade": blade}


class Expanded:
    """Predictions to first order in the logarithms of the numbers about the truth."""

    accuracy = 1e-4

    def __init__(self, truth, values, slopes):
        self._truth, self._values, self._slopes = truth, values, slopes

    def values(self, unknowns):
        """Return the values by the numbers."""
        return self._values + self._slopes @ np.log(unknowns / self._truth)

    def jacobian(self, unknowns, *, rough=False):
        """Return the derivatives by the numbers; rough ones are the same."""
        del rough
        return self._slopes / unknowns

    def hold(self, unknowns):
        """Nothing is chosen."""


def run(name, sets, real, wrong, seed=0):
    pairs, keys = PROBLEMS[name]()
    began = time.process_time()
    members = members_of(pairs)
    unknowns, beliefs = sought(members, dict.fromkeys(keys), {})
    predictions = CasePredictions(members, unknowns, [])
    _, series = series_of(members, unknowns, beliefs)
    truth = np.array([one.start for one in unknowns])
    clean = predictions.values(truth)
    slopes = predictions.jacobian(truth) * truth
    noise = np.concatenate([one.noise for one in series])
    bound = np.sqrt(np.diag(np.linalg.inv((slopes / noise[:, None]).T @ (slopes / noise[:, None]))))
    model = predictions if real else Expanded(truth, clean, slopes)
    count = real or sets
    rng = np.random.default_rng(seed)
    inside, told, widths, white = np.zeros(len(truth)), 0, [], 0
    more = 0.0
    if wrong:  # what the model has not: the motion again, a little faster and smaller
        more = np.concatenate(
            [_faster(clean[one.rows]) if one.regular else np.zeros(one.count) for one in series]
        )
    for _ in range(count):
        found = estimate(model, clean + more + noise * rng.normal(size=len(clean)), series, unknowns)
        known = covariance(found)
        limits = intervals(found, known, 0.95)
        inside += [one.low <= true <= one.high for one, true in zip(limits, truth, strict=True)]
        told += sum(one.told for one in limits)
        widths.append(known.deviations / bound)
        white += all(ljung_box(found.residuals[one.rows])[1] > 0.01 for one in series if one.regular)
    print(
        f"{name}: {count} sets, {time.process_time() - began:.0f} s, residuals white in {white / count:.1%}"
    )
    for k, key in enumerate(keys):
        width = float(np.mean(np.array(widths)[:, k]))
        print(
            f"  {key:75s} covered {inside[k] / count:.1%}  width over bound {width:.3f}  relative error {bound[k]:.2g}"
        )


def _faster(values):
    at = np.arange(len(values))
    return 0.2 * np.interp(1.04 * at, at, values)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("problems", nargs="*", default=list(PROBLEMS))
    parser.add_argument("--sets", type=int, default=1000)
    parser.add_argument(
        "--real", type=int, default=0, help="data sets that are fitted with the rods themselves"
    )
    parser.add_argument("--wrong", action="store_true")
    parser.add_argument("--seed", type=int, default=0, help="of the noise")
    given = parser.parse_args()
    for word in given.problems or list(PROBLEMS):
        run(word, given.sets, given.real, given.wrong, given.seed)
