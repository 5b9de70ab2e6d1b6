"""Motions of a rigid straight rod in closed form, stored at the nodes and Gauss points of its elements."""

from __future__ import annotations

import numpy as np
import xarray as xr

from helpers.synthetic_results import COMPONENTS
from viscorod.mechanics.elements.basis import gauss, lobatto

LENGTH = 0.8


def along(s):
    """Two section-force-like functions of arc length, of degree 1 and 3."""
    return 1.0 + 2.0 * s, s**3 - 0.5 * s


def tumbling(t):
    """Unit quaternions, body and global angular velocities of a turn about z by a(t), then about its own d1 by b(t)."""
    a, a1 = 1.3 * t + 0.4 * np.sin(2.0 * t), 1.3 + 0.8 * np.cos(2.0 * t)
    b, b1 = 0.9 * np.sin(1.7 * t), 1.53 * np.cos(1.7 * t)
    half = 0.5 * a, 0.5 * b
    q = np.stack(
        [
            np.cos(half[0]) * np.cos(half[1]),
            np.cos(half[0]) * np.sin(half[1]),
            np.sin(half[0]) * np.sin(half[1]),
            np.sin(half[0]) * np.cos(half[1]),
        ],
        axis=-1,
    )
    body = np.stack([b1, a1 * np.sin(b), a1 * np.cos(b)], axis=-1)
    spin = np.stack([b1 * np.cos(a), b1 * np.sin(a), a1], axis=-1)
    return q, body, spin


def director(t):
    """d3 of :func:`tumbling` and the velocity of a point one metre along it."""
    q, _, spin = tumbling(t)
    w, x, y, z = np.moveaxis(q, -1, 0)
    d3 = np.stack([2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)], axis=-1)
    return d3, np.cross(spin, d3)


def rigid(step, duration=2.0, order=3, elements=2):
    """A run of a rod along its d3 that tumbles about its start; section forces are functions of s and t."""
    time = np.arange(round(duration / step) + 1) * step
    ends = LENGTH * np.linspace(0.0, 1.0, elements + 1) ** 1.3
    half, middle = 0.5 * np.diff(ends), 0.5 * (ends[1:] + ends[:-1])
    s = np.append((middle[:, None] + half[:, None] * lobatto(order)[0][:-1]).ravel(), LENGTH)
    points = (middle[:, None] + half[:, None] * gauss(order)[0]).ravel()
    weight = (half[:, None] * gauss(order)[1]).ravel()
    q, body, _ = tumbling(time)
    d3, rate = director(time)
    states, stations = time.size, s.size
    force = np.zeros((states, points.size, 6))
    linear, cubic = along(points)
    force[:, :, 2] = np.cos(3.0 * time)[:, None] * linear
    force[:, :, 3] = np.sin(2.0 * time)[:, None] * cubic
    zero = np.zeros(states)
    start = np.tile([1.0, 0.0, 0.0, 0.0], (stations, 1))
    return xr.Dataset(
        {
            "reference_position": (("station", "axis"), s[:, None] * np.array([0.0, 0.0, 1.0])),
            "reference_rotation": (("station", "quaternion"), start),
            "position": (("time", "station", "axis"), d3[:, None] * s[:, None]),
            "rotation": (("time", "station", "quaternion"), np.repeat(q[:, None], stations, axis=1)),
            "velocity": (("time", "station", "axis"), rate[:, None] * s[:, None]),
            "angular_velocity": (("time", "station", "axis"), np.repeat(body[:, None], stations, axis=1)),
            "strain": (("time", "point", "component"), np.zeros_like(force)),
            "section_force": (("time", "point", "component"), force),
            "dissipation": (("time", "point"), 1e-3 * force[:, :, 2] ** 2),
            "half_width": ("point", 0.01 + 0.005 * points),
            "kinetic": ("time", zero),
            "elastic": ("time", zero),
            "viscous": ("time", zero),
            "external": ("time", zero),
            "numerical": ("time", zero),
        },
        coords={
            "time": time,
            "axis": ["x", "y", "z"],
            "quaternion": ["w", "x", "y", "z"],
            "component": COMPONENTS,
            "station_rod": ("station", np.repeat(["rod"], stations)),
            "station_s": ("station", s),
            "station_order": ("station", np.full(stations, order)),
            "point_rod": ("point", np.repeat(["rod"], points.size)),
            "point_s": ("point", points),
            "point_weight": ("point", weight),
        },
        attrs={"kind": "simulate", "title": "A tumbling rod", "case": "{}"},
    )


def with_body():
    """The tumbling rod with a mass centre at twice its length."""
    data = rigid(0.02)
    last = data.isel(station=[-1]).assign_coords(
        station_rod=("station", ["plate"]), station_s=("station", [0.0]), station_order=("station", [0])
    )
    for name in ("position", "reference_position", "velocity"):
        last[name] = 2.0 * last[name]
    states = [name for name in data if "station" in data[name].dims]
    joined = xr.concat(
        [data[states], last[states]], "station", coords="minimal", compat="override", join="outer"
    )
    return joined.merge(data.drop_dims("station")).assign_attrs(data.attrs)
