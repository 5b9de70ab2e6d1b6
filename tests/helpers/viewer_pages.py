"""Pages read back without a browser, by a decoder of its own, and results to make them of."""

import base64
import json
import re
import zlib

import numpy as np
import xarray as xr

from helpers import synthetic_results

EVIL = "</script><img src=x onerror=\"window.hit=1\"> & <b>'bold'</b> \u2028"
"""Text that would become markup if it could."""

MODES = ((1.2, 0.30), (7.4, 0.08), (21.0, 0.02))


def parts(text):
    """What the page says of itself, and its inflated bytes."""
    meta = json.loads(re.search(r'<script type="application/json" id="meta">(.*?)</script>', text, re.S)[1])
    data = re.search(r'<script type="text/plain" id="data">(.*?)</script>', text, re.S)[1]
    return meta, zlib.decompress(base64.b64decode(data))


def array(meta, data, name):
    """An array of the page and half a step of it, its largest error."""
    entry = meta["arrays"][name]
    raw = data[entry["offset"] : entry["offset"] + entry["bytes"]]
    if entry["kind"] != "quantised":
        return np.frombuffer(raw, {"float32": "<f4", "uint32": "<u4"}[entry["kind"]]).reshape(
            entry["shape"]
        ), 0.0
    half = np.frombuffer(raw, np.uint8).reshape(2, -1).astype(np.int64)
    change = (half[0] + 256 * half[1]).reshape(entry["shape"][0], -1)
    whole = np.cumsum(change, axis=0) % 65536
    step = np.array(entry["step"])
    values = np.array(entry["low"]) + step * whole.reshape(-1, step.size)
    return values.reshape(entry["shape"]), 0.5 * step


def beating(frames=10_000, elements=50, duration=20.0, title="Ten thousand frames"):
    """A long run of one rod along x in three standing waves, with fields at its Gauss points."""
    order, length = 4, 1.0
    stations = elements * order + 1
    time = np.linspace(0.0, duration, frames)
    s = np.linspace(0.0, length, stations)
    points = np.linspace(0.0, length, 4 * elements + 1)[:-1] + 0.5 * length / (4 * elements)
    reference = np.stack([s, 0 * s, 0 * s], axis=1)
    position = np.tile(reference, (frames, 1, 1))
    velocity = np.zeros_like(position)
    bend = np.zeros((frames, points.size))
    for number, (frequency, size) in enumerate(MODES, 1):
        wave, phase = 2.0 * np.pi * frequency, 0.3 * number
        shape, inner = np.sin(0.5 * np.pi * number * s) ** 2, np.cos(np.pi * number * points)
        position[:, :, 1] += size * np.cos(wave * time + phase)[:, None] * shape
        velocity[:, :, 1] -= size * wave * np.sin(wave * time + phase)[:, None] * shape
        bend += size * 5.0 * number**2 * np.cos(wave * time + phase)[:, None] * inner
    position[:, :, 2] = 0.2 * position[:, :, 1] ** 2
    velocity[:, :, 2] = 0.4 * position[:, :, 1] * velocity[:, :, 1]
    angle = 0.5 * np.arctan(np.gradient(position[:, :, 1], s, axis=1))
    rotation = np.zeros((frames, stations, 4))
    rotation[..., 0], rotation[..., 3] = np.cos(angle), np.sin(angle)
    strain = np.zeros((frames, points.size, 6))
    strain[..., 3], strain[..., 5] = bend, 0.3 * np.roll(bend, 3, axis=1)
    kinetic = np.sum(velocity**2, axis=(1, 2))
    zero = np.zeros(frames)
    return xr.Dataset(
        {
            "reference_position": (("station", "axis"), reference),
            "reference_rotation": (("station", "quaternion"), np.tile([1.0, 0, 0, 0], (stations, 1))),
            "position": (("time", "station", "axis"), position),
            "rotation": (("time", "station", "quaternion"), rotation),
            "velocity": (("time", "station", "axis"), velocity),
            "strain": (("time", "point", "component"), strain),
            "section_force": (("time", "point", "component"), 0.7 * strain),
            "dissipation": (("time", "point"), bend**2),
            "half_width": ("point", np.full(points.size, 0.01)),
            **dict.fromkeys(("viscous", "external", "numerical"), ("time", zero)),
            "kinetic": ("time", kinetic),
            "elastic": ("time", kinetic.max() - kinetic),
        },
        coords={
            "time": time,
            "axis": ["x", "y", "z"],
            "component": synthetic_results.COMPONENTS,
            "station_rod": ("station", np.repeat(["beam"], stations)),
            "station_s": ("station", s),
            "station_order": ("station", np.full(stations, order)),
            "point_rod": ("point", np.repeat(["beam"], points.size)),
            "point_s": ("point", points),
        },
        attrs={"kind": "simulate", "title": title, "outcome": "completed", "warnings": "[]"},
    )


def described(data, section=None, taper=None, **model):
    """The data set with a model in its case, as front.Model writes it."""
    beam = {
        "shape": "straight", "start": [0, 0, 0], "end": [synthetic_results.LENGTH, 0, 0],
        "material": {"youngs_modulus": 1e6, "poissons_ratio": 0.3, "density": 1000.0},
    }  # fmt: skip
    if taper:
        beam["taper"] = taper
    else:
        beam["section"] = section or {"shape": "rectangle", "width": 0.01, "height": 0.02}
    supports = [{"kind": "clamp", "at": "beam.start"}]
    case = {"rods": {"beam": beam}, "supports": supports, **model}
    return data.assign_attrs(case=json.dumps(case))
