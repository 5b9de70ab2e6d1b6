"""Warnings to a reader of a result."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING

import numpy as np

from viscorod.quantity_text import quantity
from viscorod.results.array_pieces import extremes
from viscorod.results.step_error import motion_doubt
from viscorod.results.text_numbers import number
from viscorod.results.validity import SMALL_STRAIN
from viscorod.typing import Floats

if TYPE_CHECKING:
    from viscorod.results.result import Result
    from viscorod.results.state_arrays import Stored

_GAP = 1e-2
_MESH = 0.01  # accepted error of positions by the mesh, as a part of the largest displacement
_FORCE = 0.05  # accepted error of section forces by the mesh, as a part of the largest one
_LOAD = 0.01  # accepted error of critical loads by the mesh, as a part of each
_FREQUENCY = 0.01  # accepted error of frequencies by the mesh, as a part of each
_NAMED = 8  # modes that a warning names at most
_MODES = 0.1  # accepted difference from the motion in half as many modes, whose error is the larger one
_OPEN = 1e-3  # accepted distance of a place from where it is held, over the size of the model
_NUMERICAL = 0.01  # accepted remainder of the energy account, as a part of what moved
_OF_LOSS = 0.2  # accepted remainder, as a part of what the material, dampers and drag took
_FREE = 0.01  # work of loads, as a part of what moved, up to which a motion is left to itself
_UNSEEN = 1e-5  # and as a part of what moved: less is no decay that anybody sees
_OF_ALL = 1e-6  # and as a part of all energy that is there: a body that turns evenly moves next to none
_OF_EVEN = 1e-4  # the same where neither strains nor dampers take part: what a steady top moves is what its steps lose


def stored_warnings(data: Stored) -> list[str]:
    """Return the warnings stored with a result: ``doubts`` about the model, and ``warnings``; each once."""
    stored = (text for name in ("doubts", "warnings") for text in json.loads(data.attrs.get(name, "[]")))
    return [str(text) for text in dict.fromkeys(stored)]


def warnings_of(result: Result) -> list[str]:
    """Return the warnings stored with a result and those that its data call for.

    Added to the stored ones are:
    a remainder of the energy account (see `energy_doubt`), steps whose errors are estimated to add up to more than 1 %
    of the motion, a mesh whose error is estimated as more than 1 % of the largest displacement or 5 % of the largest
    section force, or could not be estimated, critical loads and frequencies that change by more than 1 % with it, and
    shear, stretch, or bending and twist times half width beyond 0.1, where the Kelvin-Voigt law for small strains
    (Linn, Lang and Tuganov, section 2.2) is doubtful.
    """
    data = result.stored
    texts = stored_warnings(data)
    lost = energy_doubt(data)
    if lost and lost not in texts:
        texts.append(lost)
    doubt = motion_doubt(data.attrs)
    if doubt and doubt not in texts:
        texts.append(doubt)
    gap = float(data.attrs.get("pose_gap", 0.0)) / float(data.attrs.get("scale_length", 1.0))
    if gap > _GAP:
        texts.append(
            f"poses integrated in time and along the rods differ by {gap:.2g} of the model's size: "
            "the mesh is too coarse for this motion; use more elements or a higher order"
        )
    texts += (
        _mesh_warnings(result) + _critical_warnings(data) + _frequency_warnings(data) + _mode_warnings(result)
    )
    return texts + _strain_warnings(result)


def _mode_warnings(result: Result) -> list[str]:
    """Return warnings of a motion in too few modes."""
    attrs, texts = result.stored.attrs, []
    gap = float(attrs.get("modes_motion_gap", 0.0))
    if gap > _MODES:
        texts.append(
            f"in {attrs['modes_fewer']} modes the motion differs by {number(100.0 * gap, 2)} % of the largest "
            f"displacement from that in {attrs['modes']}: use more modes"
        )
    opened = float(attrs.get("modes_open", 0.0)) / float(attrs.get("scale_length", 1.0))
    if opened > _OPEN:
        texts.append(
            f"rods between supports, or in loops, miss their ends by up to {opened:.2g} of the model's size: use more "
            "modes"
        )
    return texts


def energy_doubt(data: Stored) -> str:
    """Return a warning of a remainder of the energy account that is above what is accepted, else nothing.

    That is 1 % of the energy that moved, and 20 % of what damping took from a motion that is left to itself: its decay
    is not the material's then, however small. Bodies that turn evenly exchange nothing; of theirs it is a
    ten-thousandth of all energy.
    """
    if "numerical" not in data or "kinetic" not in data:
        return ""
    from viscorod.results.energy import Energy

    energy = Energy.of(data)
    moved, there = energy.moved, float(energy.total.max())
    made, lost, most = float(energy.numerical[-1]), energy.lost, float(np.abs(energy.numerical).max())
    fraction = most / moved if moved > 0.0 else 0.0
    setting = "tolerance" if "tolerance" in data.attrs else "time_step"
    used = f" than {data.attrs[setting]:.2g}" if setting in data.attrs else ""
    even = max(float(np.ptp(energy.elastic)), lost) <= most
    if fraction > _NUMERICAL and most > (_OF_EVEN if even else _OF_ALL) * there:
        return (
            f"the numerical remainder of the energy account reaches {number(100.0 * fraction, 2)} % "
            f"of the energy that moved; use a smaller {setting}{used}"
        )
    least = max(_OF_LOSS * lost, _UNSEEN * moved, _OF_ALL * there)
    if lost > 0.0 and abs(made) > least and energy.driven <= _FREE * moved:
        return (
            f"steps {'made' if made > 0.0 else 'took'} {quantity(abs(made), 'J', 2)} of energy, damping took "
            f"{quantity(lost, 'J', 2)}: the decay of this motion is not the material's; use a smaller {setting}{used}"
        )
    return ""


def _mesh_warnings(result: Result) -> list[str]:
    """Return warnings of a mesh that is too coarse for what was computed, or whose error is unknown."""
    attrs, texts = result.stored.attrs, []
    motion, force = (float(attrs.get(f"mesh_{name}_error", 0.0)) for name in ("motion", "force"))
    worst = max(result.mesh_errors.items(), key=lambda pair: pair[1], default=("", np.inf))
    # what is less than the steps were asked for tells nothing of the mesh, such as the rest of a shaft that only spins
    if motion > _MESH and worst[1] > float(attrs.get("tolerance", 0.0)):
        rod = worst[0]
        texts.append(
            f"positions may be off by {number(100.0 * motion, 2)} % of the largest displacement, most in rod "
            f"{rod!r}, whose mesh is coarse for this; use more elements or a higher order"
        )
    if force > _FORCE:
        texts.append(
            f"section forces may be off by {number(100.0 * force, 2)} % of the largest, because the mesh is coarse for "
            "them; use more elements or a higher order"
        )
    if attrs.get("mesh_lost") and (result.dimension == "load_factor" or not result.mesh_errors):
        texts.append(
            "the error of the mesh is unknown: on a finer one no solution was found near this; try more elements, and "
            "look for another solution nearby"
        )
    return texts


def _critical_warnings(data: Stored) -> list[str]:
    """Return a warning of critical loads that change with the mesh."""
    errors = data["critical_error"].values if "critical_error" in data else np.zeros(0)
    doubtful = np.flatnonzero(errors > _LOAD)
    if not len(doubtful):
        return []
    numbers = ", ".join(str(k + 1) for k in doubtful)
    which = f"critical load {numbers} is" if len(doubtful) == 1 else f"critical loads {numbers} are"
    return [
        f"{which} another by up to {number(100.0 * float(errors.max()), 2)} % on a finer mesh; use more elements. "
        "If that does not help, something is free to move without stiffness at every load, such as a round ring "
        "about its own line: hold it"
    ]


def _frequency_warnings(data: Stored) -> list[str]:
    """Return a warning of oscillating modes, or of resonances, whose frequencies change with the mesh."""
    resonances = float(data.attrs.get("frequency_error", 0.0))
    if resonances > _FREQUENCY:
        return [
            f"frequencies of resonances may be off by up to {number(100.0 * resonances, 2)} %, because the mesh is "
            "coarse for this; use more elements or a higher order"
        ]
    if "mode_error" not in data or "eigenvalue" not in data:
        return []
    (decay, swing), errors = np.abs(data["eigenvalue"].values).T, data["mode_error"].values
    doubtful = np.flatnonzero((errors > _FREQUENCY) & (swing > decay))
    if not len(doubtful):
        return []
    listed = ", ".join(str(k + 1) for k in doubtful[:_NAMED]) + (", ..." if len(doubtful) > _NAMED else "")
    which = f"the frequency of mode {listed}" if len(doubtful) == 1 else f"frequencies of modes {listed}"
    return [
        f"{which} may be off by up to {number(100.0 * float(errors[doubtful].max()), 2)} %, because the mesh is coarse "
        "for this; use more elements or a higher order"
    ]


def _strain_warnings(result: Result) -> list[str]:
    """Return one warning each for crushed sections, for shear or stretch, and for bending or twist that are large."""
    data = result.stored
    if "strain" not in data or not data["strain"].sizes.get("point", 0):
        return []
    low, high = extremes(result, "strain")
    strain = np.maximum(np.abs(low), np.abs(high))
    texts = []
    crushed, _, where = _largest(data, -low[:, 2:3])
    if crushed >= 1.0:
        texts.append(
            f"sections are pressed through each other{where}: the stretch is {-crushed:.3g}, below -1; "
            "no material does that, and results from there on mean nothing"
        )
    value, component, where = _largest(data, strain[:, :3])
    if value > SMALL_STRAIN:
        name = ("shear 1", "shear 2", "stretch")[component]
        texts.append(f"the strain {name} reaches {value:.2g}{where}; {_law(value)}")
    if "half_width" in data:
        half = np.asarray(data["half_width"].values, dtype=float)
        value, component, where = _largest(data, strain[:, 3:] * half[:, None])
        if value > SMALL_STRAIN:
            name = ("bend 1", "bend 2", "twist")[component]
            texts.append(
                f"{name} times the half width of the section reaches {value:.2g}{where}; {_law(value)}"
            )
    return texts


def _law(strain: float) -> str:
    """Return what a strain means for the material law."""
    if strain < 1.0:
        return "the material law is meant for strains well below 1"
    return (
        "the material law is linear and meant for strains well below 1: no material follows it there, and these "
        "results are its alone; compare the loads with the stiffness, and their units"
    )


def _largest(data: Stored, values: Floats) -> tuple[float, int, str]:
    """Return the largest of ``(point, component)``, its component and " at rod@s"."""
    point, component = (int(k) for k in np.unravel_index(int(np.argmax(values)), values.shape))
    where = ""
    if "point_rod" in data and "point_s" in data:
        where = f" at {data['point_rod'].values[point]}@{float(data['point_s'].values[point]):.4g}"
    return float(values[point, component]), component, where
