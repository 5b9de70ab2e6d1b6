"""Measure the tables of docs/howto/choose_mesh.md: error against elements, order and tolerance in three cases.

python docs/figures/choose_mesh.py
"""

from __future__ import annotations

import numpy as np
from scipy.integrate import quad
from scipy.optimize import brentq

import viscorod as vr

ORDERS = (1, 2, 3, 5, 8)
ELEMENTS = (1, 2, 4, 8, 16)
TOLERANCES = (1e-2, 1e-3, 1e-4, 1e-5, 1e-6)


def elastica(load: float) -> tuple[float, float]:
    """Return the tip of Euler's elastica of length and stiffness 1 under a dead force across it: along and across.

    With the slope p at the tip, theta' = sqrt(2 load (sin p - sin theta)); theta = arcsin(sin p - u^2) removes the
    singular end of the integrals for length, height and reach.
    """

    def over(p: float, of: str) -> float:
        def integrand(u: float) -> float:
            sine = np.sin(p) - u * u
            return 2.0 / np.sqrt(2.0 * load) * {"length": 1.0, "up": sine}[of] / np.sqrt(1.0 - sine * sine)

        return float(quad(integrand, 0.0, np.sqrt(np.sin(p)), epsabs=1e-13, epsrel=1e-13)[0])

    slope = brentq(lambda p: over(p, "length") - 1.0, 1e-3, 1.57, xtol=1e-15)
    return float(np.sqrt(2.0 * np.sin(slope) / load)), over(slope, "up")


def bent(elements: int, order: int) -> float:
    """Return the error of a clamped strip, bent by ten times EI/L^2: distance of the tip over the length."""
    section = vr.StiffnessSection([1.0] * 6, [1.0] * 6)
    model = vr.Model()
    rod = vr.Rod.straight(
        (0, 0, 0), (1, 0, 0), section=section, constraints="kirchhoff", elements=elements, order=order
    )
    model.add("strip", rod)
    model.clamp("strip.start")
    model.force("strip.end", (0, 10.0, 0))
    tip = model.equilibrium().position("strip.end")
    return float(np.linalg.norm(tip[:2] - elastica(10.0)))


def coil(elements: int, order: int) -> float:
    """Return the largest error of a straight wire, wound into a helix of two turns by an end couple."""
    a, c, radius = 4.0 * np.pi, 50.0 / (40.0 * np.pi), 10.0
    length = np.hypot(1.0, c) * radius * a
    start = radius * np.array([0.0, -1.0, 0.0])
    end = start + length * np.array([1.0, 0.0, c]) / np.hypot(1.0, c)
    section = vr.StiffnessSection([1e6, 1e6, 2e6, 1.0, 1.0, 1.0], [1.0] * 6)  # G J = E I
    model = vr.Model()
    model.add(
        "wire", vr.Rod.straight(start, end, section=section, d1=(0, 1, 0), elements=elements, order=order)
    )
    model.clamp("wire.start")
    couple = radius * a**2 / length**2
    model.moment("wire.end", (0.0, couple, c * couple), following=True)
    found = model.equilibrium()
    x = found.data["station_s"].values / length
    exact = radius * np.array([np.sin(a * x), -np.cos(a * x), c * a * x]).T
    return float(np.abs(found.data["position"].values[-1] - exact).max() / length)


def swing(elements: int, order: int, tolerance: float) -> np.ndarray:
    """Return the tip of the tutorial's cantilever over the length, every 0.02 s of five seconds."""
    rubber = vr.Material(1e6, poissons_ratio=0.3, density=1000.0, damping=vr.KelvinVoigt(0.02, 0.02))
    section = vr.Rectangle(0.01, 0.01)
    model = vr.Model()
    rod = vr.Rod.straight(
        (0, 0, 0), (0.3, 0, 0), section=section, material=rubber, elements=elements, order=order
    )
    model.add("beam", rod)
    model.clamp("beam.start")
    model.force("beam.end", (0, 0.035, 0), until=0.0)
    run = model.simulate(5.0, tolerance=tolerance, output_interval=0.02)
    return np.asarray(run.history("beam.end").values / 0.3)


def table(title: str, rows: list[tuple[str, list[float | None]]], heads: list[str]) -> None:
    print(f"\n{title}\n| | {' | '.join(heads)} |\n|---|{'---|' * len(heads)}")
    for name, values in rows:
        print(f"| {name} | {' | '.join('-' if value is None else f'{value:.1e}' for value in values)} |")


def main() -> None:
    exact = swing(4, 10, 1e-9)

    def swung(elements: int, order: int, tolerance: float = 1e-7) -> float:
        return float(np.abs(swing(elements, order, tolerance) - exact).max())

    for title, error in (("Bent strip", bent), ("Wound wire", coil), ("Swinging cantilever", swung)):
        rows = []
        for order in ORDERS:
            values: list[float | None] = []
            for elements in ELEMENTS:
                try:
                    values.append(error(elements, order) if elements * order <= 48 else None)
                except vr.SolveError as failure:
                    print(title, elements, order, str(failure).splitlines()[0])
                    values.append(None)
            rows.append((f"order {order}", values))
        table(title, rows, [f"{n} elements" if n > 1 else "1 element" for n in ELEMENTS])
    rows = [
        (f"{n} of order {p}", [swung(n, p, tolerance) for tolerance in TOLERANCES])
        for n, p in ((2, 3), (2, 5), (4, 5))
    ]
    table("Swinging cantilever, mesh and tolerance", rows, [f"{tolerance:g}" for tolerance in TOLERANCES])


if __name__ == "__main__":
    main()
