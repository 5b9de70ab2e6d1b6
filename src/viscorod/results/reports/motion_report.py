"""The report of a motion as plain text."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING

import numpy as np

from viscorod.results.data_schema import AXES
from viscorod.results.reports.effort import counted, effort
from viscorod.results.reports.report_parts import drift, ends, heading, places, stress, validity, warnings
from viscorod.results.text_numbers import per_cent, percent, quantity
from viscorod.results.text_table import page

if TYPE_CHECKING:
    from viscorod.results.run import Run

__all__ = ["run_report"]

_WORKING = 0.01  # more work of the loads than this part of what moved, meanwhile, makes it no free decay
_MOST_EVENTS = 20


def run_report(run: Run) -> str:
    """Return the report of a run."""
    judged = run.validity()
    return page(
        [
            heading(run, _summary(run)),
            _began(run),
            ends(run, *_shown_state(run)),
            _decay(run),
            str(run.energy),
            _events(run),
            stress(run),
            validity(run, judged),
            _heating(run),
            drift(run),
            effort(run),
            warnings(run, judged),
        ]
    )


def _summary(run: Run) -> str:
    """Say how long a motion was followed, and by what."""
    attrs = run.stored.attrs
    text = f"{quantity(float(run.time[-1] - run.time[0]), 's')} simulated"
    text += f" in {counted(int(attrs['steps']), 'steps')}" if "steps" in attrs else ""
    text += f" of {quantity(float(attrs['time_step']), 's')}" if "time_step" in attrs else ""
    text += f" that follow the error, tolerance {attrs['tolerance']:.3g}" if "tolerance" in attrs else ""
    text += (
        f" ({per_cent(100.0 * attrs['part_of_motion'], 3)} of the motion)"
        if "part_of_motion" in attrs
        else ""
    )
    text += f", {str(attrs['integrator']).replace('_', '-')}" if attrs.get("integrator") else ""
    if attrs.get("formulation", "geometric") == "geometric":
        return text
    kind = "linear dynamics, " if attrs["dynamics"] == "linear" else ""
    kind += f"{attrs['modes']} modes, " if "modes" in attrs else ""
    return f"{text}; intrinsic formulation, {kind}{attrs['damping']} damping"


def _began(run: Run) -> str:
    """Report what the motion started from, unless it is the reference shape or the plain equilibrium."""
    text = str(run.stored.attrs.get("began_from", ""))
    return f"Started from {text}" if "settling" in text or " at " in text else ""


def _events(run: Run) -> str:
    """Report the events of the run."""
    attrs = run.stored.attrs
    if "events" not in attrs:
        return ""
    events = json.loads(attrs["events"])
    if not events:
        return "Events: none of those that the run watched for"
    lines = [f"  {event['time']:.9g} s  {event['event']}" for event in events[:_MOST_EVENTS]]
    if len(events) > _MOST_EVENTS:
        lines.append(f"  and {len(events) - _MOST_EVENTS} more")
    if attrs.get("ended_by"):
        lines.append("The last of them ended the run")
    return "\n".join(["Events", *lines])


def _heating(run: Run) -> str:
    """Say how much the motion warms the rods whose specific heat is known."""
    known = "heat_capacities" in run.stored.attrs and "dissipation" in run.stored and run.time.size > 1
    return str(run.self_heating()) if known else ""


def _shown_state(run: Run) -> tuple[str, int]:
    """Return the state whose rod ends are reported: the held start, or the end where the rods start undeformed."""
    time = run.time
    if time.size == 1 or np.any(run.field("displacement", states=0)):
        return f"{places(run)} at {quantity(float(time[0]), 's')}, the start", 0
    return f"{places(run)} at {quantity(float(time[-1]), 's')}", -1


def _decay(run: Run) -> str:
    site, axis = run.main_motion
    moved = run.vector(run.sites.at(site.label), "displacement")  # a data array would import xarray
    spread = float(np.ptp(moved[:, AXES.index(axis)]))
    if run.time.size > 1 and run.rests:
        turns = "Nothing is displaced, it only turns" if run.energy.moved else "Nothing moves"
        return f"{turns}: what displacements change by is rounding"
    largest = f"{site.label} along {axis} has the largest range of displacement, {quantity(spread, 'm')}"
    decay = run.free_decay(site.label, axis)
    if decay is None:
        return (
            f"No regular decay: {largest}, and its maxima make no cycles of a damping ratio "
            "(model.modes() gives those of small vibrations)"
        )
    energy = run.energy
    since = energy.time >= decay.time[0]
    late, drag_loss = energy.supplied[since], float(np.ptp(energy.outside[since]))
    lines = [str(decay), f"  ({largest})"]
    if drag_loss > _WORKING * energy.moved:
        share = drag_loss / (drag_loss + float(np.ptp(energy.viscous[since])))
        lines.append(f"  (drag takes {percent(share, 3)} of what is lost meanwhile, the material the rest)")
    if float(np.ptp(late)) > _WORKING * energy.moved:
        who = "rest strains, loads or supports" if energy.actuator.any() else "loads or supports"
        lines.append(f"  ({who} do work meanwhile: these ratios describe the motion, not only the material)")
    return "\n".join(lines)
