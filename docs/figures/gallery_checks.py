"""What every shipped case is checked against, drawn beside its shapes by `gallery.py`: its right panel."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from matplotlib.axes import Axes
from scipy.interpolate import CubicSpline

import viscorod as vr
from viscorod.casefile.case import load_case
from viscorod.casefile.shipped import shipped_case
from viscorod.pictures.style import BLUE, GREEN, ORANGE, RED, clean, heading, legend_above

__all__ = ["RIGHT", "amplitudes", "critical", "curve", "frequencies", "lines"]

Draw = Callable[[Axes, vr.Run], None]


def history(
    place: str, axis: str, known: list[tuple[float, float]] | None = None, scale: float = 1.0
) -> Draw:
    """Draw a coordinate over time, with known values marked; see `displacement`."""
    return _line("position", place, axis, known, scale)


def displacement(
    place: str, axis: str, known: list[tuple[float, float]] | None = None, scale: float = 1.0
) -> Draw:
    """Draw a displacement over time, with known values (time, value); `scale` 1e6 draws it in um."""
    return _line("displacement", place, axis, known, scale)


def _line(field: str, place: str, axis: str, known: list[tuple[float, float]] | None, scale: float) -> Draw:
    unit = {1.0: "m", 1e3: "mm", 1e6: "µm"}[scale]

    def draw(axes: Axes, run: vr.Run) -> None:
        value = run.history(place, field).sel(axis=axis).values
        clean(axes, "time [s]", f"{axis} of {place} [{unit}]")
        axes.plot(run.time, scale * value, color=BLUE, linewidth=1.4, label="this case")
        if known:
            axes.plot(*np.array(known).T, "o", color=RED, label="independent")

    return draw


def decay(place: str, axis: str, frequency: float, ratio: float, name: str, scale: float = 1.0) -> Draw:
    """Draw a free vibration with the envelope that theory gives the small one, through the last maximum."""

    def draw(axes: Axes, run: vr.Run) -> None:
        displacement(place, axis, scale=scale)(axes, run)
        found = run.decrement(place, axis=axis, rest=None)
        rate = 2 * np.pi * frequency * ratio
        size = found.amplitude[-1] * np.exp(-rate * (run.time - found.time[-1]))
        bottom, top = axes.get_ylim()
        for sign, label in ((1.0, name), (-1.0, "_")):
            axes.plot(
                run.time,
                scale * (found.rest_at(run.time) + sign * size),
                "--",
                color=RED,
                linewidth=1.3,
                label=label,
            )
        room = 0.12 * (top - bottom)
        axes.set_ylim(bottom - room, top + 2 * room)

    return draw


def energy(limit: float, name: str) -> Draw:
    """Draw kinetic and elastic energy over time, with the value that they should reach."""

    def draw(axes: Axes, run: vr.Run) -> None:
        account = run.energy
        clean(axes, "time [s]", "energy [J]")
        axes.plot(account.time, account.total, color=BLUE, linewidth=1.6, label="kinetic + elastic")
        axes.plot(account.time, account.elastic, color=GREEN, linewidth=1.0, label="elastic")
        axes.axhline(limit, color=RED, linestyle="--", linewidth=1.3, label=name)

    return draw


def lag(axes: Axes, run: vr.Run) -> None:
    """Draw the tip of the arm in the frame of its root, with the table of an independent computation."""
    turned = np.array([vr.SpinUp(6.0, 15.0).value(t) for t in run.time])
    x, y, _ = run.history("arm.end").values.T
    clean(axes, "time [s]", "tip across the turning root [m]")
    axes.plot(
        run.time, -np.sin(turned) * x + np.cos(turned) * y, color=BLUE, linewidth=1.6, label="this case"
    )
    known = [(2, -0.102381), (4, -0.342279), (6, -0.543596), (6.76, -0.573835), (8, -0.542841)]
    known += [(10, -0.362814), (12, -0.150900), (15, 0.001303)]
    axes.plot(*np.array(known, dtype=float).T, "o", color=RED, label="independent")


def bend(axes: Axes, result: vr.Equilibrium) -> None:
    """Draw the tip of the 45-degree bend while the load grows, with the converged position at 600."""
    model = load_case(shipped_case("bend_45")).model(vr.Model)
    factors = np.linspace(0.05, 1.0, 20)
    tip = np.array([model.equilibrium(load_factor=factor).position("bend.end") for factor in factors])
    clean(axes, "load [N]", "tip position [m]")
    for values, colour, name in zip(tip.T, (BLUE, GREEN, ORANGE), "xyz", strict=True):
        axes.plot(600 * factors, values, color=colour, linewidth=1.6, label=name)
    final = (15.68480, 47.15044, 53.47486)
    axes.plot([600.0] * 3, final, "o", color=RED, label="independent")


def princeton(axes: Axes, result: vr.Equilibrium) -> None:
    """Draw tip displacements of the Princeton beam over the angle of its load, beside solid elements of Ansys."""
    case = load_case(shipped_case("princeton_beam"))
    angles = np.linspace(0.0, 90.0, 13)
    moved = []
    for angle in np.radians(angles):
        model = case.model(vr.Model)
        model.loads[:] = []
        model.force("beam.end", (0, 13.345 * np.cos(angle), 13.345 * np.sin(angle)))
        moved.append(1000 * model.equilibrium().displacement("beam.end"))
    clean(axes, "angle of the load to the edge [deg]", "tip displacement [mm]")
    axes.plot(angles, np.array(moved)[:, 2], color=BLUE, linewidth=1.6, label="flapwise")
    axes.plot(angles, 5 * np.array(moved)[:, 1], color=GREEN, linewidth=1.6, label="edgewise, times 5")
    solid = np.array([(30, 113.752, 16.404), (45, 153.554, 14.851), (60, 179.979, 11.272), (90, 197.669, 0)])
    axes.plot(solid[:, 0], solid[:, 1], "o", color=RED, label="solids")
    axes.plot(solid[:, 0], 5 * solid[:, 2], "o", color=RED)


def sag(axes: Axes, run: vr.Run) -> None:
    """Draw the end of the helical spring, with the sag of the textbook's spring under its own weight, W/2k."""
    displacement("spring.end", "z")(axes, run)
    axes.axhline(-0.05593, color=RED, linestyle="--", linewidth=1.3, label="sag by $G d^4/(8 D^3 n)$")


def resonator(axes: Axes, run: vr.Run) -> None:
    """Draw the shuttle, with its maxima where Tang's formula has them."""
    displacement("shuttle", "x", scale=1e6)(axes, run)
    top = 1e6 * float(run.history("shuttle", "displacement").sel(axis="x")[0])
    axes.plot(np.arange(7) / 16479.24, [top] * 7, "o", color=RED, label="periods of the formula")


def blade(axes: Axes, result: vr.Steady) -> None:
    """Draw flapping frequencies of the swept blade over its speed, with the measured ones."""
    model = load_case(shipped_case("swept_blade")).model(vr.Model)
    speeds = np.linspace(0.0, 750.0, 16)
    found = [model.modes(5, about="reference").frequencies]
    found += [model.steady(spin=(0, 0, rpm * np.pi / 30), modes=5).frequencies for rpm in speeds[1:]]
    clean(axes, "speed [1/min]", "frequency [Hz]")
    for k, values in enumerate(np.array(found).T[:4]):
        axes.plot(speeds, values, color=BLUE, linewidth=1.4, label="computed, all" if k == 0 else "_")
    measured = {0: (1.6, 10.4, 24.8), 500: (10.2, 21.6, 35.1), 750: (14.7, 26.1, 44.8)}
    for rpm, values in measured.items():
        axes.plot([rpm] * 3, values, "o", color=RED, label="flapping, measured" if rpm == 0 else "_")


def curve(axes: Axes, result: vr.FrequencyResponse) -> None:
    """Draw how far the end moves over the clamp."""
    clean(axes, "frequency [Hz]", "end over clamp")
    axes.loglog(result.frequencies, result.amplification(), color=BLUE, linewidth=1.4)
    heading(axes, "Amplification over frequency")


def shaken(axes: Axes, result: vr.FrequencyResponse) -> None:
    """Draw the amplification around the first resonance, with the exact values."""
    first = result.poles[0].imag / (2.0 * np.pi)
    near = np.abs(result.frequencies / first - 1.0) < 0.06
    clean(axes, "frequency [Hz]", "amplification")
    axes.semilogy(result.frequencies[near], result.amplification()[near], color=BLUE, label="computed")
    axes.plot([0.95 * first, first], [15.39, 156.6], "o", color=RED, label="beam with complex modulus")


def amplitudes(axes: Axes, result: vr.Periodic) -> None:
    """Draw the amplitude over the frequency, motions that are unstable dashed."""
    clean(axes, "frequency [Hz]", "amplitude [mm]")
    height = 1e3 * result.amplitude("beam@0.2 uz")
    for stable, style in ((True, "-"), (False, "--")):
        # every motion beside one of the kind, so that lines meet
        beside = np.convolve(result.stable == stable, [1, 1, 1], "same") > 0
        axes.plot(
            result.frequencies, np.where(beside, height, np.nan), style, color=BLUE if stable else ORANGE
        )
    heading(axes, "Amplitude over frequency (dashed: unstable)")


def hardening(axes: Axes, result: vr.Periodic) -> None:
    """Draw the same about the backbone of one mode, w^2 = w1^2 + 3/4 alpha q^2."""
    height = 1e3 * result.amplitude("beam@0.2 uz")
    clean(axes, "amplitude [mm]", "frequency [Hz]")
    axes.plot(height, result.frequencies, color=BLUE, label="computed")
    q = np.linspace(0.0, 2.2, 50)
    axes.plot(
        q,
        np.sqrt(98.136**2 + (109.670**2 - 98.136**2) * (q / 2.0376) ** 2),
        "--",
        color=RED,
        label="one mode",
    )


def whirl(axes: Axes, result: vr.Campbell) -> None:
    """Draw damping ratios of the shaft over its speed, with the limit of the closed form."""
    clean(axes, "speed [rad/s]", "damping ratio [%]")
    for k, colour in enumerate((RED, BLUE)):
        way = "forward" if result.whirl[-1, k] > 0.0 else "backward"
        axes.plot(result.speeds, 100.0 * result.damping_ratios[:, k], color=colour, label=way)
    axes.axhline(0.0, color="#222222", linewidth=0.8)
    axes.plot(252.904, 0.0, "o", color=GREEN, label="closed form")


def lines(axes: Axes, result: vr.Campbell) -> None:
    """Draw frequencies over the speed, with the critical speeds."""
    clean(axes, "speed [rad/s]", "frequency [Hz]")
    for k in range(3):
        axes.plot(result.speeds, result.frequencies[:, k], color=(RED, BLUE, ORANGE)[k])
    axes.plot(result.speeds, result.speeds / (2.0 * np.pi), "--", color="#8a8a8a")
    found = result.critical_speeds
    axes.plot([one.speed for one in found], [one.frequency for one in found], "o", color="#222222")
    axes.set_ylim(0.0, 45.0)
    heading(axes, "Frequencies from space, once per turn (dashed)")


def frequencies(axes: Axes, result: vr.Stability) -> None:
    """Draw frequencies of the column over its load."""
    clean(axes, "load [EI/L²]", "frequency [Hz]")
    for k in range(len(result.modes)):
        axes.plot(result.load_factors, result.frequencies[:, k], color=(RED, BLUE, ORANGE)[k])
    heading(axes, "Frequencies over the load")


def growth(axes: Axes, result: vr.Stability) -> None:
    """Draw rates of growth of the column over its load, with the limit of the boundary value problem."""
    clean(axes, "load [EI/L²]", "growth rate Re s [1/s]")
    for k in range(len(result.modes)):
        axes.plot(result.load_factors, result.eigenvalues[:, k].real, color=(RED, BLUE, ORANGE)[k])
    axes.axhline(0.0, color="#222222", linewidth=0.8)
    axes.plot(10.96611, 0.0, "o", color=GREEN, label="boundary value problem")
    axes.plot(20.05095, 0.0, "x", color="#8a8a8a", label="without damping")
    axes.set_ylim(-2.5, 1.5)


def critical(number: int, known: float) -> Callable[[Axes, vr.Buckling], None]:
    """Return what draws a shape of the tall rod in its plane, with the factor of the closed form."""

    def draw(axes: Axes, result: vr.Buckling) -> None:
        clean(axes, "displacement, largest 1", "height [m]")
        moved = result.shapes[number, :, :2]
        across = moved[:, int(np.argmax(np.abs(moved).max(axis=0)))]
        name = f"{result.load_factors[number]:.5f} times its weight (Greenhill {known:.5f})"
        height = result.positions[number][:, 2]
        fine = np.linspace(height[0], height[-1], 200)
        axes.plot(CubicSpline(height, across)(fine), fine, color=BLUE, linewidth=2.0, label=name)
        axes.axvline(0.0, color="#8a8a8a", linestyle="--", linewidth=1.0)
        legend_above(axes, 1)

    return draw


def path(place: str, axis: str, known: list[tuple[float, float]], name: str) -> Callable[..., None]:
    """Draw the load factor over a displacement, with known points."""

    def along(axes: Axes, result: vr.Equilibrium) -> None:
        moved = result.history(place, "displacement").sel(axis=axis).values
        clean(axes, f"displacement {axis} of {place.partition('@')[0]} [m]", "load factor")
        axes.plot(moved, result.load_factor, color=BLUE, linewidth=1.6, label="equilibria")
        if len(known[0]) == 2 and np.isnan(known[0][0]):
            for _, level in known:
                axes.axhline(level, color=RED, linestyle="--", linewidth=1.3, label=name)
        else:
            axes.plot(*np.array(known).T, "o", color=RED, label=name)

    return along


NAN = float("nan")
RIGHT: dict[str, Callable[..., None]] = {
    "bend_45": bend,
    "cantilever_swing": decay("beam.end", "y", 0.56795, 0.035684, "ratio of the small vibration"),
    "comb_resonator": resonator,
    "damped_strip": decay("strip.end", "z", 3.8814, 0.02758, "Oberst's ratio", 1e3),
    "deep_arch": path("arch@187.6228945893904", "y", [(NAN, 0.897)], "published limit load"),
    "elastica_column": path(
        "column.end", "x", [(0.42222, 1.06366), (0.71950, 1.29389), (0.80317, 1.88480)], "elliptic integrals"
    ),
    "flying_rod": energy(724.41, "independent"),
    "four_bar": history("crank.end", "x", [(2.4, 0.109024)]),
    "helix_spring": sag,
    "hinged_beam": energy(0.44375, "independent"),
    "prestressed_bridge": displacement("beam@15.0", "z", [(1.25, -3.0472), (1.5, 1.7979)]),
    "princeton_beam": princeton,
    "right_angle_frame": energy(114.88, "independent"),
    "rubber_strip": decay("strip.end", "z", 2.40078, 0.0504, "ratio of the small vibration"),
    "shaken_strip": shaken,
    "soft_arm": decay("end_plate.rim", "y", 2.05687, 0.12589, "ratio of the small vibration"),
    "spinning_up_arm": lag,
    "swept_blade": blade,
    "whirling_shaft": whirl,
    "tall_rod": critical(2, 7.26894),
    "becks_column": growth,
    "clamped_strip": hardening,
}
