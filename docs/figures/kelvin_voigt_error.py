"""Draw the figure of docs/explanation/kelvin_voigt_limits.md and print its table.

python docs/figures/kelvin_voigt_error.py
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from look import dressed
from matplotlib.figure import Figure

import viscorod as vr

TARGET = Path(__file__).parents[1] / "images" / "kelvin_voigt_error.png"
INK, BLUE, ORANGE, GREEN = "#222222", "#0072B2", "#E69F00", "#009E73"
DAMPING = vr.Prony(
    shear_ratios=[0.20, 0.15, 0.10],
    shear_times=[0.001, 0.03, 1.0],
    constant="bulk_modulus",
    moduli="instantaneous",
)
RUBBER = vr.Material(9e6, poissons_ratio=0.5, density=1100.0, damping=DAMPING)
SHOWN = (1e-3, 1e4)
BANDS = {"fit from 0.5 to 5 Hz": ((0.5, 5.0), ORANGE), "fit from 10 to 1000 Hz": ((10.0, 1000.0), GREEN)}


def fits() -> dict[str, tuple[vr.KelvinVoigtFit, str]]:
    """Return Kelvin-Voigt solids by name: that of slow motion, and the best over the bands, with their colours."""
    found = {"low-frequency fit": (vr.kelvin_voigt_fit(RUBBER, SHOWN, fit="low_frequency"), BLUE)}
    for name, (band, colour) in BANDS.items():
        found[name] = vr.kelvin_voigt_fit(RUBBER, band), colour
    return found


def draw() -> None:
    relaxation = RUBBER.relaxation("extension")
    assert relaxation is not None
    hertz = np.geomspace(*SHOWN, 600)
    exact = relaxation.complex_modulus(2 * np.pi * hertz)
    figure = Figure(figsize=(9.6, 7.0), layout="constrained")
    (storage, loss), (storage_error, loss_error) = figure.subplots(
        2, 2, sharex=True, height_ratios=(1.2, 1.0)
    )
    storage.plot(hertz, exact.real / 1e6, color=INK, lw=2.2, label="Maxwell branches")
    loss.plot(hertz, exact.imag / 1e6, color=INK, lw=2.2)
    for name, (fit, colour) in fits().items():
        fitted = fit.modulus + 2j * np.pi * hertz * fit.viscosity
        low, high = BANDS[name][0] if name in BANDS else SHOWN
        inside = (hertz >= low) & (hertz <= high)
        for axes, part, sign in ((storage, fitted.real, exact.real), (loss, fitted.imag, exact.imag)):
            axes.plot(hertz, part / 1e6, color=colour, lw=1.0, ls=":")
            axes.plot(hertz[inside], part[inside] / 1e6, color=colour, lw=2.0, label=name)
            error = storage_error if axes is storage else loss_error
            error.plot(hertz, 100 * np.abs(part / sign - 1), color=colour, lw=1.0, ls=":")
            error.plot(hertz[inside], 100 * np.abs(part / sign - 1)[inside], color=colour, lw=2.0)
    storage.set(title="storage modulus [MPa]", xscale="log", ylim=(4, 10))
    loss.set(title="loss modulus [MPa]", yscale="log", ylim=(1e-3, 1e2))
    storage_error.set(
        title="error of the storage modulus [%]", yscale="log", ylim=(0.01, 1e3), xlabel="frequency [Hz]"
    )
    loss_error.set(
        title="error of the loss modulus [%]", yscale="log", ylim=(0.01, 1e3), xlabel="frequency [Hz]"
    )
    for axes in figure.axes:
        axes.set_xlim(*SHOWN)
    storage.legend(fontsize=8.5, loc="upper left")
    dressed(figure).savefig(TARGET, dpi=110)


def print_table() -> None:
    print("| Kelvin-Voigt solid | modulus [MPa] | time [s] | storage wrong by | loss wrong by |")
    print("|---|---|---|---|---|")
    for name, (fit, _) in fits().items():
        if name not in BANDS:
            ends = [fit.frequency[np.argmax(abs(e) > 0.01)] for e in (fit.storage_error, fit.loss_error)]
            cells = " | ".join(f"1 % up to {end:.2g} Hz" for end in ends)
            print(f"| {name} | {fit.modulus / 1e6:.3f} | {fit.time:.4g} | {cells} |")
            continue
        storage, loss = (100 * np.abs(error).max() for error in (fit.storage_error, fit.loss_error))
        print(f"| {name} | {fit.modulus / 1e6:.3f} | {fit.time:.4g} | {storage:.2g} % | {loss:.2g} % |")


if __name__ == "__main__":
    print_table()
    draw()
