"""Draw the figure of docs/explanation/llt_cantilever.md and print its table.

python docs/figures/llt_cantilever.py
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from look import dressed
from matplotlib.figure import Figure

import viscorod as vr
from viscorod.results.decrement import Decrement

LENGTH, FORCE = 0.3, 0.035
TOLERANCE = 1e-8
DURATIONS = {0.01: 90.0, 0.02: 45.0, 0.04: 30.0}
"""By the time of damping, s: until the amplitude is small."""
COLOURS = {0.01: "#0072B2", 0.02: "#D55E00", 0.04: "#009E73"}
TARGET = Path(__file__).parents[1] / "images" / "llt_cantilever.png"


def cantilever(tau: float, modulus: float = 1e6) -> vr.Model:
    """Return the rod of Linn, Lang and Tuganov, section 3, with the force scaled to its stiffness."""
    damping = vr.KelvinVoigt(shear_time=tau, bulk_time=tau)
    rubber = vr.Material(modulus, poissons_ratio=0.3, density=1000.0, damping=damping)
    section = vr.Rectangle(0.01, 0.01)
    model = vr.Model()
    rod = vr.Rod.straight((0, 0, 0), (LENGTH, 0, 0), section=section, material=rubber, elements=2, order=5)
    model.add("beam", rod)
    model.clamp("beam.start")
    model.force("beam.end", (0, FORCE * modulus / 1e6, 0), until=0.0)
    return model


def decay_of(run: vr.Run) -> Decrement:
    return run.decrement("beam.end", axis="y")


def envelope(decay: Decrement, time: np.ndarray) -> np.ndarray:
    """Return the exponential of the first cycle that begins below 0.05 L, followed back."""
    k = int(np.argmax(decay.amplitude[:-1] < 0.05 * LENGTH))
    rate = decay.log_decrement[k] / decay.period[k]
    return np.asarray(decay.amplitude[k] * np.exp(-rate * (time - decay.time[k])))


def main() -> None:
    given = {"tolerance": TOLERANCE}
    runs = {tau: cantilever(tau).simulate(DURATIONS[tau], output_interval=0.01, **given) for tau in COLOURS}
    stiff = cantilever(0.01, 4e6).simulate(DURATIONS[0.02] / 2, output_interval=0.005, **given)
    omega = 2 * np.pi * cantilever(0.02).modes(1, about="reference").frequencies[0]

    figure = Figure(figsize=(9.6, 8.2), layout="constrained")
    top, bottom = figure.subfigures(2, 1, height_ratios=(1.25, 1.0))
    axes = top.subplots()
    for tau, run in runs.items():
        tip = run.history("beam.end").values[:, 1] / LENGTH
        shown = run.time <= 10.0
        axes.plot(run.time[shown], tip[shown], color=COLOURS[tau], label=f"E = 1 MPa, τ = {tau:g} s")
        bound = envelope(decay_of(run), run.time[shown]) / LENGTH
        for sign in (1.0, -1.0):
            axes.plot(run.time[shown], sign * bound, color=COLOURS[tau], ls="--", lw=1.0)
    axes.plot([], [], color="0.4", ls="--", lw=1.0, label="exponential of the linear regime")
    axes.plot(
        2 * stiff.time[::4],
        stiff.history("beam.end").values[::4, 1] / LENGTH,
        ls="none",
        marker=".",
        ms=4,
        color="black",
        label="E = 4 MPa, τ = 0.01 s, time stretched by 2",
    )
    axes.axhline(0.0, color="0.7", lw=0.8)
    axes.set(xlabel="time [s]", ylabel="tip deflection / length", xlim=(0, 10), ylim=(-0.8, 1.05))
    axes.legend(ncols=2, fontsize=9, loc="upper right")

    shape, ratio, by_amplitude = bottom.subplots(1, 3, width_ratios=(1.15, 1.0, 1.0))
    first = runs[0.02]
    times = np.linspace(0.0, 0.88, 8)
    places = [first.sites.at(f"beam@{s:.6f}") for s in np.linspace(0.0, LENGTH, 41)]
    for k, time in enumerate(times):
        stations = first.positions_at(float(time)) / LENGTH
        points = np.array([place.of(stations) for place in places])
        shape.plot(points[:, 0], points[:, 1], color=str(0.05 + 0.09 * k), lw=1.5)
        shape.annotate(f"{time:.2f}", points[-1, :2], fontsize=7, xytext=(3, 0), textcoords="offset points")
    shape.set(
        xlabel="x / length", ylabel="y / length", xlim=(-0.05, 1.18), title="first half period, τ = 0.02 s"
    )
    shape.set_aspect("equal")
    shape.title.set_fontsize(10)

    for tau, run in runs.items():
        steps, remainder = run.data.attrs["steps"], run.energy.numerical_fraction
        print(f"tau = {tau}: {steps} steps, numerical remainder {remainder:.1e}")
    print(f"omega_1 = {omega:.6f} rad/s")
    for tau, run in runs.items():
        decay = decay_of(run)
        count = len(decay.damping_ratio)
        amplitude = np.abs(decay.amplitude[:count]) / LENGTH
        for panel, place in ((ratio, np.arange(1, count + 1)), (by_amplitude, amplitude)):
            panel.plot(place, decay.damping_ratio, "o-", ms=4, color=COLOURS[tau], label=f"τ = {tau:g} s")
            panel.axhline(omega * tau / 2, color=COLOURS[tau], ls="--", lw=1.0)
        print(f"tau = {tau}: omega tau/2 = {omega * tau / 2:.6f}")
        for k in range(count):
            relative = decay.damping_ratio[k] / (omega * tau / 2)
            line = f"  cycle {k + 1:2d}  amplitude/L {amplitude[k]:.4f}  period {decay.period[k]:.5f}"
            print(f"{line}  zeta {decay.damping_ratio[k]:.6f}  zeta/(omega tau/2) {relative:.4f}")
    ratio.plot([], [], color="0.4", ls="--", label="ωτ/2")
    ratio.set(xlabel="cycle", ylabel="damping ratio of the cycle", xlim=(0.5, 10.5), ylim=(0, 0.095))
    ratio.set_xticks(range(1, 11))
    by_amplitude.set(
        xlabel="amplitude at its start / length", xscale="log", xlim=(0.9, 0.006), ylim=(0, 0.095)
    )
    by_amplitude.set_xticks([0.5, 0.1, 0.02], ["0.5", "0.1", "0.02"])
    by_amplitude.minorticks_off()
    ratio.legend(fontsize=8, loc="upper right", ncols=2)
    slow = runs[0.02].history("beam.end").values[: len(stiff.time)]
    gap = np.abs(stiff.history("beam.end").values - slow).max() / LENGTH
    print(f"E x 4 with tau / 2: largest deviation / L = {gap:.2e}")
    print(f"largest |z| / L = {np.abs(first.data['position'].values[..., 2]).max() / LENGTH:.1e}")
    dressed(figure).savefig(TARGET, dpi=110)


if __name__ == "__main__":
    main()
