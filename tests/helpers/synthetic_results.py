"""Data sets of results in closed form, to test what is derived from them."""

from __future__ import annotations

import json

import numpy as np
import xarray as xr

LENGTH = 0.3
STATIONS = 11
ORDER = 5
COMPONENTS = ["shear_1", "shear_2", "stretch", "bend_1", "bend_2", "twist"]
MOTIONS = ["fx", "fy", "fz", "mx", "my", "mz"]


def oscillator(time, zeta, omega, amplitude=1.0, rest=0.0):
    """Displacement and velocity of a damped oscillator released from rest at ``rest + amplitude``."""
    a, b = zeta * omega, omega * np.sqrt(1.0 - zeta**2)
    decay = amplitude * np.exp(-a * time)
    x = decay * (np.cos(b * time) + a / b * np.sin(b * time))
    v = -decay * (a * a / b + b) * np.sin(b * time)
    return rest + x, v


def swing(zeta=0.05, omega=3.6, duration=10.0, step=0.02, amplitude=0.2, rest=0.0, leak=0.0, rods=("beam",)):
    """A run of straight rods along x whose points move as ``y = (s/L)^2 q(t)``, q a damped oscillator.

    ``leak`` is the part of the viscous loss that the account misses (the numerical remainder at the end).
    """
    time = np.arange(round(duration / step) + 1) * step
    q, rate = oscillator(time, zeta, omega, amplitude, rest)
    s = np.tile(LENGTH * 0.5 * (1.0 - np.cos(np.pi * np.arange(STATIONS) / (STATIONS - 1))), len(rods))
    shape = (s / LENGTH) ** 2
    stations = s.size
    reference = np.zeros((stations, 3))
    reference[:, 0] = s
    reference[:, 2] = 0.1 * np.repeat(np.arange(len(rods)), STATIONS)
    position = np.tile(reference, (time.size, 1, 1))
    position[:, :, 1] += shape * q[:, None]
    velocity = np.zeros_like(position)
    velocity[:, :, 1] = shape * rate[:, None]
    reference_rotation = np.tile([0.5, 0.5, 0.5, 0.5], (stations, 1))
    mass = 0.03
    kinetic, elastic = 0.5 * mass * rate**2, 0.5 * mass * omega**2 * (q - rest) ** 2
    loss = elastic[0] + kinetic[0] - elastic - kinetic
    points = 10 * len(rods)
    point_s = np.tile((np.arange(10) + 0.5) * LENGTH / 10, len(rods))
    strain = np.zeros((time.size, points, 6))
    strain[:, :, 3] = -2.0 / LENGTH**2 * q[:, None]
    reaction = np.zeros((time.size, len(rods), 6))
    reaction[:, :, 1] = mass * omega**2 * q[:, None]
    return xr.Dataset(
        {
            "reference_position": (("station", "axis"), reference),
            "reference_rotation": (("station", "quaternion"), reference_rotation),
            "position": (("time", "station", "axis"), position),
            "rotation": (("time", "station", "quaternion"), np.tile(reference_rotation, (time.size, 1, 1))),
            "velocity": (("time", "station", "axis"), velocity),
            "angular_velocity": (("time", "station", "axis"), np.zeros_like(velocity)),
            "strain": (("time", "point", "component"), strain),
            "section_force": (("time", "point", "component"), strain * 8.3e-4),
            "dissipation": (("time", "point"), np.zeros((time.size, points))),
            "kinetic": ("time", kinetic),
            "elastic": ("time", elastic),
            "viscous": ("time", (1.0 - leak) * loss),
            "external": ("time", np.zeros_like(time)),
            "numerical": ("time", -leak * loss),
            "reaction": (("time", "support", "motion"), reaction),
            "step_size": ("time", np.full(time.size, step)),
            "iterations": ("time", np.full(time.size, 3)),
        },
        coords={
            "time": time,
            "axis": ["x", "y", "z"],
            "quaternion": ["w", "x", "y", "z"],
            "component": COMPONENTS,
            "motion": MOTIONS,
            "support": [f"{rod}.start" for rod in rods],
            "station_rod": ("station", np.repeat(rods, STATIONS)),
            "station_s": ("station", s),
            "station_order": ("station", np.full(s.size, ORDER)),
            "point_rod": ("point", np.repeat(rods, 10)),
            "point_s": ("point", point_s),
            "point_weight": ("point", np.full(points, LENGTH / 10)),
        },
        attrs={
            "kind": "simulate",
            "title": "A swing in closed form",
            "case": json.dumps({"title": "A swing in closed form"}),
            "version": "0.1.0",
            "outcome": "completed",
            "message": "",
            "wall_time_s": 0.5,
            "compile_time_s": 0.0,
            "integrator": "generalized_alpha",
            "time_step": step,
            "steps": time.size - 1,
            "iterations": 3 * (time.size - 1),
            "factorisations": 3 * (time.size - 1),
            "rejected": 0,
            "scale_length": LENGTH,
        },
    )


def rolled_up(angle=0.5 * np.pi, factors=(0.25, 0.5, 0.75, 1.0)):
    """An equilibrium: a straight rod along x bent about z into an arc of this end angle, in load steps."""
    factors = np.asarray(factors)
    s = np.linspace(0.0, LENGTH, STATIONS)
    turn = factors[:, None] * angle * s / LENGTH
    curvature = factors[:, None] * angle / LENGTH
    position = np.zeros((factors.size, STATIONS, 3))
    position[:, :, 0] = np.sin(turn) / curvature
    position[:, :, 1] = (1.0 - np.cos(turn)) / curvature
    reference = np.zeros((STATIONS, 3))
    reference[:, 0] = s
    start = np.tile([0.5, 0.5, 0.5, 0.5], (STATIONS, 1))
    about_z = np.stack([np.cos(turn / 2), 0 * turn, 0 * turn, np.sin(turn / 2)], axis=-1)
    rotation = np.empty_like(about_z)
    w, z = about_z[..., 0], about_z[..., 3]
    rotation[..., 0], rotation[..., 1] = 0.5 * (w - z), 0.5 * (w - z)
    rotation[..., 2], rotation[..., 3] = 0.5 * (w + z), 0.5 * (w + z)
    bending = 8.3e-4
    elastic = 0.5 * bending * curvature[:, 0] ** 2 * LENGTH
    reaction = np.zeros((factors.size, 1, 6))
    reaction[:, 0, 5] = -bending * curvature[:, 0]
    return xr.Dataset(
        {
            "reference_position": (("station", "axis"), reference),
            "reference_rotation": (("station", "quaternion"), start),
            "position": (("load_factor", "station", "axis"), position),
            "rotation": (("load_factor", "station", "quaternion"), rotation),
            "elastic": ("load_factor", elastic),
            "external": ("load_factor", elastic),
            "reaction": (("load_factor", "support", "motion"), reaction),
            "iterations": ("load_factor", np.full(factors.size, 5)),
        },
        coords={
            "load_factor": factors,
            "axis": ["x", "y", "z"],
            "quaternion": ["w", "x", "y", "z"],
            "motion": MOTIONS,
            "support": ["beam.start"],
            "station_rod": ("station", np.repeat(["beam"], STATIONS)),
            "station_s": ("station", s),
            "station_order": ("station", np.full(s.size, ORDER)),
        },
        attrs={
            "kind": "equilibrium",
            "title": "A roll-up in closed form",
            "outcome": "completed",
            "message": "",
            "wall_time_s": 0.01,
            "steps": factors.size,
            "iterations": 5 * factors.size,
            "negative_eigenvalues": 0,
        },
    )
