"""Draw the figure of docs/explanation/damping_over_frequency.md and print its tables.

python docs/figures/damping_over_frequency.py
"""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import numpy as np
from look import dressed
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

import viscorod as vr

TARGET = Path(__file__).parents[1] / "images" / "damping_over_frequency.png"
BLUE, ORANGE, INK = "#0072B2", "#E69F00", "#222222"
COLOURS = {"Kelvin-Voigt": BLUE, "flat loss": ORANGE, "measured": INK}
WIDTHS = {"Kelvin-Voigt": 3.0, "flat loss": 2.2, "measured": 1.2}
MODES = 4


class Blade(NamedTuple):
    """A clamped strip of three descriptions of the same damping, alike in the first mode.

    Attributes:
        title: what it is; models: by description; band: of the response [Hz].
    """

    title: str
    models: dict[str, vr.Model]
    band: tuple[float, float]


def clamped(
    section: vr.Rectangle | vr.Composite, length: float, material: vr.Material | None = None
) -> vr.Model:
    """Return a clamped strip along x that bends about its thin side."""
    model = vr.Model()
    model.add(
        "blade",
        vr.Rod.straight((0, 0, 0), (length, 0, 0), section=section, material=material, elements=4, order=5),
    )
    model.clamp("blade.start")
    return model


def bending(model: vr.Model, band: tuple[float, float]) -> tuple[np.ndarray, np.ndarray]:
    """Return frequencies [Hz] and damping ratios of the bending modes in a band, by the poles of the response."""
    found = model.frequency_response("blade.end fz", "blade.end uz", frequencies=band)
    mine = [k for k, name in enumerate(found.data["pole_name"].values) if "bend_1" in str(name)]
    s = found.poles[mine][:MODES]
    return np.abs(s) / (2 * np.pi), -s.real / np.abs(s)


def steel() -> Blade:
    """Steel of 2 mm, which loses what heat flows across it: C. Zener (1937), in closed form."""
    E, nu, rho, thickness, length = 2.1e11, 0.3, 7850.0, 0.002, 0.45
    expansion, temperature, heat, conductivity = 1.2e-5, 293.0, 470.0, 45.0
    strength = E * expansion**2 * temperature / (rho * heat)
    tau = thickness**2 * rho * heat / (np.pi**2 * conductivity)
    section, band = vr.Rectangle(0.025, thickness), (4.0, 400.0)
    zener = vr.Prony(extension_moduli=[strength * E], extension_times=[tau])
    measured = clamped(section, length, vr.Material(E, nu, rho, damping=zener))
    return Blade("steel, 450 x 25 x 2 mm", _alike(measured, section, length, (E, nu, rho), band), band)


def silicone() -> Blade:
    """Silicone whose moduli follow a power law of the frequency, as filled ones do: E (i f/1 Hz)^0.08."""
    nu, rho, length, power = 0.49, 1150.0, 0.12, 0.08
    hertz = np.geomspace(0.3, 300.0, 25)
    moduli = 1.5e6 * (1j * hertz) ** power
    table = vr.ComplexModuli(frequency=hertz, storage=moduli.real, loss=moduli.imag)
    section, band = vr.Rectangle(0.03, 0.008), (1.0, 250.0)
    measured = clamped(section, length, vr.Material(poissons_ratio=nu, density=rho, damping=table))
    first = bending(measured, band)[0][0]
    E = 1.5e6 * float(((1j * first) ** power).real)
    return Blade("silicone, 120 x 30 x 8 mm", _alike(measured, section, length, (E, nu, rho), band), band)


def sandwich() -> Blade:
    """Skins of a glass laminate of constant loss on a core of polyurethane that was measured over frequency."""
    skin = (2.5e10, 0.28, 1900.0)
    core_nu, core_density, length, high, thin = 0.4, 600.0, 0.5, 0.006, 0.001
    hertz = np.array([3.0, 10.0, 30.0, 100.0, 300.0, 1000.0])
    storage = 1e8 * np.array([6.0, 7.0, 8.2, 10.0, 11.6, 12.6])
    tan_delta = np.array([0.16, 0.22, 0.26, 0.22, 0.14, 0.09])
    table = vr.ComplexModuli(frequency=hertz, storage=storage, tan_delta=tan_delta)
    band = (5.0, 900.0)

    def layers(skins: vr.Material, core: vr.Material) -> vr.Composite:
        at = 0.5 * (high + thin)
        return vr.Composite(
            [
                vr.CompositeRegion(core, vr.Rectangle(0.04, high)),
                vr.CompositeRegion(skins, vr.Rectangle(0.04, thin), at=(0, at)),
                vr.CompositeRegion(skins, vr.Rectangle(0.04, thin), at=(0, -at)),
            ]
        )

    loss = vr.LossFactor(extension=0.006, band=(1.0, 1000.0))
    own = vr.Material(*skin, damping=loss)
    measured = clamped(
        layers(own, vr.Material(poissons_ratio=core_nu, density=core_density, damping=table)), length
    )
    (first, *_), (ratio, *_) = bending(measured, band)
    E = float(np.interp(np.log(first), np.log(hertz), storage))
    models = {"measured": measured}
    for name, damping in _matched(first, ratio, band).items():
        both = layers(
            vr.Material(*skin, damping=damping), vr.Material(E, core_nu, core_density, damping=damping)
        )
        models[name] = clamped(both, length)
    return Blade("sandwich, 500 x 40 x 8 mm", {name: models[name] for name in COLOURS}, band)


def _matched(first: float, ratio: float, band: tuple[float, float]) -> dict[str, vr.LossFactor]:
    """Return a Kelvin-Voigt and a flat loss factor that damp the first mode alike."""
    return {
        "Kelvin-Voigt": vr.LossFactor(extension=2.0 * ratio, frequency=first),
        "flat loss": vr.LossFactor(extension=2.0 * ratio, band=band),
    }


def _alike(
    measured: vr.Model,
    section: vr.Rectangle | vr.Composite,
    length: float,
    elastic: tuple[float, float, float],
    band: tuple[float, float],
) -> dict[str, vr.Model]:
    """Return all descriptions of a strip of one material with E [Pa], Poisson's ratio and density."""
    (first, *_), (ratio, *_) = bending(measured, band)
    others = {
        name: clamped(section, length, vr.Material(*elastic, damping=damping))
        for name, damping in _matched(first, ratio, band).items()
    }
    return {**others, "measured": measured}


def draw(blades: list[Blade]) -> None:
    figure = Figure(figsize=(10.0, 10.2), layout="constrained")
    panels = figure.subplots(len(blades), 2, width_ratios=(1.5, 1.0), squeeze=False)
    for (curve, ratios), blade in zip(panels, blades, strict=True):
        for name, model in blade.models.items():
            found = model.frequency_response("blade.end fz", "blade.end uz", band=blade.band, tolerance=0.003)
            curve.loglog(
                found.frequencies, found.amplification(), color=COLOURS[name], lw=WIDTHS[name], label=name
            )
            hertz, damping = bending(model, blade.band)
            ratios.loglog(
                hertz, 100.0 * damping, "o-", color=COLOURS[name], lw=1.0, ms=5, label=name, alpha=0.9
            )
        curve.set_title(f"{blade.title}: end over force there [m/N]", loc="left", fontsize=10)
        ratios.set_title("damping ratio of the bending modes [%]", loc="left", fontsize=10)
        low, high = ratios.get_ylim()
        ratios.set_ylim(0.5 * low, 2.0 * high)
        ratios.yaxis.set_major_formatter(FuncFormatter(lambda x, _: f"{x:g}"))
        ratios.yaxis.set_minor_formatter(NullFormatter())
        if high < 100.0 * low:  # less than two powers of ten: numbers between them too
            ratios.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
        for axes in (curve, ratios):
            axes.set_xlim(*blade.band)
            axes.xaxis.set_major_formatter(FuncFormatter(lambda x, _: f"{x:g}"))
            axes.grid(color="0.9", lw=0.6)
    for axes in panels[-1]:
        axes.set_xlabel("frequency [Hz]")
    panels[0][1].legend(fontsize=9)
    dressed(figure).savefig(TARGET, dpi=110)


def print_tables(blades: list[Blade]) -> None:
    for blade in blades:
        print(f"\n| {blade.title} | " + " | ".join(f"mode {k + 1}" for k in range(MODES)) + " |")
        print("|---|" + "---|" * MODES)
        for name, model in blade.models.items():
            found = zip(*bending(model, blade.band), strict=True)
            cells = [f"{100.0 * ratio:.3g} % at {f:.4g} Hz" for f, ratio in found]
            cells += ["-"] * (MODES - len(cells))
            print(f"| {name} | {' | '.join(cells)} |")


if __name__ == "__main__":
    everything = [steel(), silicone(), sandwich()]
    print_tables(everything)
    draw(everything)
