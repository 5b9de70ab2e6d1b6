"""Results of every kind as small files, to be damaged."""

import copy
import warnings

import viscorod as vr
from helpers.damaged_cases import CASES
from viscorod.analyses.case_run import run_case
from viscorod.casefile.case import case_from_dict
from viscorod.results.sweep_members import SweepRun
from viscorod.results.sweep_result import Sweep

ANALYSES = {"equilibrium": {}, "path": {"points": 6}, "steady": {"spin": [0.0, 0.0, 4.0]}}
STATES = 9
KINDS = ("motion", "mechanism", "branches", "equilibrium", "path", "steady", "sweep", "sweep of others")


def small_results():
    """Return results by kind: motions of few states, with joints, Maxwell branches, and all else that there is."""
    found = {
        "motion": _computed("cantilever_swing"),
        "mechanism": _computed("four_bar"),
        "branches": _computed("rubber_strip"),
        **{word: _computed("cantilever_swing", word) for word in ANALYSES},
    }
    run = found["mechanism"]
    shorter = vr.Run(run.data.isel(time=slice(0, 4)))
    failed = SweepRun(2, {"x": 3.0}, None, "it failed", "refused")
    found["sweep"] = Sweep(
        [SweepRun(0, {"x": 1.0}, run), SweepRun(1, {"x": 2.0}, run), failed], "stacked", ["a note"]
    )
    found["sweep of others"] = Sweep(
        [SweepRun(0, {"x": 1.0}, run), SweepRun(1, {"x": 2.0}, shorter)], "apart"
    )
    return found


def _computed(name, analysis="own"):
    case = copy.deepcopy(CASES[name])
    if analysis != "own":
        del case["simulate"]
        case[analysis] = copy.deepcopy(ANALYSES[analysis])
    else:
        case["simulate"]["duration"] /= 500.0
        case["simulate"].pop("output_interval", None)
        case["simulate"].pop("time_step", None)
    for rod in case["rods"].values():
        rod |= {"order": 2, "elements": 4}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", vr.AccuracyWarning)
        result = run_case(case_from_dict(case))
    if isinstance(result, vr.Run):
        return vr.Run(result.data.isel(time=slice(0, STATES)))
    return result


def identical(one, other):
    """Whether two results hold the same."""
    if type(one) is not type(other):
        return False
    if isinstance(one, Sweep):
        return len(one.members) == len(other.members) and all(
            (a.values, a.message, a.outcome, a.result is None)
            == (b.values, b.message, b.outcome, b.result is None)
            and (a.result is None or identical(a.result, b.result))
            for a, b in zip(one.members, other.members, strict=True)
        )
    return one.data.identical(other.data)


def use(result, folder, *, pictures):
    """Do with a result what users do: report it, ask for places, draw it."""
    assert result.report()
    if isinstance(result, Sweep):
        for member in result.members:
            if member.result is not None:
                use(member.result, folder, pictures=False)
        return
    for rod in result.sites.rods:
        start, end = result.sites.ends(rod)
        result.probe(rod, s=[0.4 * start.s + 0.6 * end.s])
    result.history(0)
    result.probe(0)
    if "joint" in result.data:
        result.joint(str(result.data["joint"].values[0]))
    if pictures:
        result.plot(folder / "picture.png")
        if not isinstance(result, vr.Steady):
            vr.view(result, folder / "page.html", frames=4)
