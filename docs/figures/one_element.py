"""Draw the figure of docs/explanation/one_element.md and print its tables.

python docs/figures/one_element.py
"""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from look import dressed
from matplotlib.figure import Figure

import viscorod as vr
from viscorod.analyses.case_run import as_model
from viscorod.casefile.case import load_case
from viscorod.casefile.shipped import shipped_cases

TARGET = Path(__file__).parents[1] / "images" / "one_element.png"
COLOURS = {1: "#222222", 2: "#E69F00", 3: "#009E73", 5: "#0072B2", 8: "#D55E00"}
MESHES = {
    1: (4, 8, 16, 32, 64, 128),
    2: (1, 2, 4, 8, 16),
    3: (1, 2, 4, 8),
    5: (1, 2, 4),
    8: (1, 2),
}
SLENDERNESS = 20.0  # length over diameter, circular section, nu = 0.3
EA = 16.0 * 4.0 * SLENDERNESS**2 / 4.0  # EI = L = 1
GA = 0.9 * EA / 2.6
LOAD = 10.0
KINDS = {"shearable": (), "kirchhoff": ("kirchhoff",)}
MEMBERS = [(1, 1), (1, 4), (1, 16), (1, 64), (2, 1), (3, 1), (5, 1), (8, 1)]  # order, elements of each member
PULL = 4.0e-5  # N, eight times that of the shipped comb
CRANK = -1.14  # rad, where the shipped mechanism is at 2.4 s


def cantilever(
    elements: int, order: int, constraints: tuple[str, ...], stiff: float = 1.0, tau: float = 0.0
) -> vr.Model:
    stiffness = np.array([stiff * GA, stiff * GA, stiff * EA, 1.0, 1.0, 1 / 1.3])
    rotary = 1.0 / EA
    damping = {"damping": list(tau * stiffness)} if tau else {}
    section = vr.StiffnessSection(list(stiffness), [1, 1, 1, rotary, rotary, 2 * rotary], **damping)
    model = vr.Model()
    rod = vr.Rod.straight(
        (0, 0, 0), (1, 0, 0), section=section, elements=elements, order=order, constraints=constraints
    )
    model.add("beam", rod)
    model.clamp("beam.start")
    return model


def bent(elements: int, order: int, constraints: tuple[str, ...]) -> np.ndarray:
    """Return the tip under a force of ten times EI/L^2 across the rod."""
    model = cantilever(elements, order, constraints)
    model.force("beam.end", (0, LOAD, 0))
    return model.equilibrium().position("beam.end")


def wound(elements: int, order: int, constraints: tuple[str, ...]) -> np.ndarray:
    """Return the end of the rod wound by a moment to one turn of a helix whose pitch angle is 45 degrees."""
    model = cantilever(elements, order, constraints)
    bend = twist = np.sqrt(2.0) * np.pi  # curvature and torsion: their root of squares is 2 pi
    model.moment("beam.end", (0, bend, twist / 1.3), following=True)
    return model.equilibrium().position("beam.end")


def frequency(elements: int, order: int, constraints: tuple[str, ...]) -> np.ndarray:
    model = cantilever(elements, order, constraints)
    return 2 * np.pi * model.modes(1).frequencies[:1]


def swung(elements: int, order: int, constraints: tuple[str, ...]) -> np.ndarray:
    """Return the tip over two periods after the release from a force of EI/L^2 across the rod."""
    model = cantilever(elements, order, constraints, tau=0.01)
    model.force("beam.end", (0, 1.0, 0), until=0.0)
    return model.simulate(3.6, tolerance=1e-8, output_interval=0.05).history("beam.end").values


CASES: dict[str, tuple[Callable[..., np.ndarray], str]] = {
    "bent": (bent, "bent by 10 EI/L²: tip / L"),
    "wound": (wound, "wound to a turn of a helix: end / L"),
    "frequency": (frequency, "first frequency, relative"),
    "swung": (swung, "swing, two periods: tip / L"),
}


def error(name: str, elements: int, order: int, kind: str, exact: np.ndarray) -> float:
    found = CASES[name][0](elements, order, KINDS[kind])
    scale = np.abs(exact).max() if name == "frequency" else 1.0
    return float(np.abs(found - exact).max()) / scale


def errors() -> dict[tuple[str, str, int], list[float]]:
    table = {}
    for name, (compute, _) in CASES.items():
        for kind, constraints in KINDS.items():
            exact = compute(4, 10, constraints)
            for order, meshes in MESHES.items():
                table[name, kind, order] = [error(name, n, order, kind, exact) for n in meshes]
    return table


def draw(table: dict[tuple[str, str, int], list[float]]) -> None:
    figure = Figure(figsize=(9.6, 7.4), layout="constrained")
    for axes, (name, (_, title)) in zip(figure.subplots(2, 2).ravel(), CASES.items(), strict=True):
        for order, meshes in MESHES.items():
            nodes = [n * order + 1 for n in meshes]
            floor = 1e-12
            for kind, style, face in (("shearable", "-", None), ("kirchhoff", "--", "white")):
                shown = np.maximum(table[name, kind, order], floor)
                marker = {"marker": "o", "ms": 5, "color": COLOURS[order], "ls": style}
                label = f"order {order}" if kind == "shearable" else None
                axes.plot(nodes, shown, lw=1.3, markerfacecolor=face or COLOURS[order], label=label, **marker)
        axes.axhline(1e-3, color="0.75", lw=0.8, zorder=0)
        axes.set(xscale="log", yscale="log", xlabel="nodes", ylabel="error", title=title, xlim=(1.8, 150))
        axes.title.set_fontsize(10)
        axes.set_xticks([2, 5, 10, 20, 50, 100], ["2", "5", "10", "20", "50", "100"])
        axes.minorticks_off()
        axes.grid(color="0.9", lw=0.6)
    first = figure.axes[0]
    first.plot([], [], color="0.4", ls="--", marker="o", markerfacecolor="white", label="Kirchhoff")
    first.legend(fontsize=8, loc="lower left")
    dressed(figure).savefig(TARGET, dpi=110)


def print_errors(table: dict[tuple[str, str, int], list[float]]) -> None:
    rows = [(order, k) for order, meshes in MESHES.items() for k in range(len(meshes))]
    for kind in KINDS:
        print(f"\n{kind}\n")
        print("| order | elements | nodes | " + " | ".join(CASES) + " |")
        print("|---|---|---|" + "---|" * len(CASES))
        for order, k in rows:
            n = MESHES[order][k]
            cells = " | ".join(f"{table[name, kind, order][k]:.1e}" for name in CASES)
            print(f"| {order} | {n} | {n * order + 1} | {cells} |")


def equal_accuracy(table: dict[tuple[str, str, int], list[float]]) -> None:
    """Return how many two-node elements are as accurate as one element, from their order: error ~ elements^-2."""
    print("\n| one element of order | " + " | ".join(CASES) + " |\n|---|" + "---|" * len(CASES))
    for order in (5, 8):
        cells = []
        for name in CASES:
            finest, known = MESHES[1][-1], table[name, "shearable", 1][-1]
            alone = table[name, "shearable", order][0]
            cells.append(f"{finest * np.sqrt(known / alone):.0f}")
        print(f"| {order} | " + " | ".join(cells) + " |")


def costs() -> None:
    """Compare the effort for Kirchhoff and for stiff shearable rods, with medians of times."""
    print("\n| rod | statics: iterations | ms | motion: steps | evaluations | factorisations | s |")
    print("|---|---|---|---|---|---|---|")
    kinds = [
        ("shearable, L/d = 20", (), 1.0),
        ("shearable, L/d = 2000", (), 1e4),
        ("shearable, L/d = 200000", (), 1e8),
        ("unshearable", ("unshearable",), 1.0),
        ("Kirchhoff", ("kirchhoff",), 1.0),
    ]
    models = []
    for _, constraints, stiff in kinds:
        at_rest = cantilever(4, 5, constraints, stiff)
        at_rest.force("beam.end", (0, LOAD, 0))
        moving = cantilever(4, 5, constraints, stiff, tau=0.01)
        moving.force("beam.end", (0, LOAD, 0), until=0.0)
        models.append((at_rest, moving))
    times = np.zeros((2, len(kinds), 7))
    results = {}
    for repeat in range(times.shape[2]):  # in turns: a busy machine is busy for all of them
        for k, (at_rest, moving) in enumerate(models):
            began = time.perf_counter()
            static = at_rest.equilibrium()
            times[0, k, repeat] = time.perf_counter() - began
            began = time.perf_counter()
            run = moving.simulate(1.0, tolerance=1e-6)
            times[1, k, repeat] = time.perf_counter() - began
            results[k] = static.data.attrs, run.data.attrs
    statics, motions = np.median(times, axis=2)
    for k, (name, _, _) in enumerate(kinds):
        still, moved = results[k]
        counts = " | ".join(str(moved[key]) for key in ("steps", "evaluations", "factorisations"))
        print(f"| {name} | {still['iterations']} | {1e3 * statics[k]:.1f} | {counts} | {motions[k]:.2f} |")


def divided(case: str, order: int, elements: int) -> vr.Model:
    """Return a shipped case whose rods shear, and have elements of one order and number."""
    model = as_model(load_case(shipped_cases()[case]).description)
    for name, rod in model.rods.items():
        model.rods[name] = vr.Rod.model_validate(
            dict(rod) | {"order": order, "elements": elements, "constraints": ()}
        )
    return model


def comb(order: int, elements: int) -> np.ndarray:
    """Return the first frequency of the comb resonator [Hz], and how far the combs pull its shuttle [m]."""
    model = divided("comb_resonator", order, elements)
    frequency = model.modes(1, about="reference").frequencies[0]
    model.loads.clear()
    model.force("shuttle", (PULL, 0, 0))
    return np.array([frequency, model.equilibrium().displacement("shuttle")[0]])


def mechanism(order: int, elements: int) -> np.ndarray:
    """Return where the elbow of the four-bar mechanism is [m] and the moment of its motor [N m], the crank turned."""
    model = divided("four_bar", order, elements)
    motor = model.joints[0]
    model.joints[0] = type(motor).model_validate(dict(motor) | {"motion": {"rz": CRANK}})
    found = model.equilibrium()
    held = found.data["joint_force"].values[-1]
    at = list(zip(found.data["joint"].values, found.data["joint_motion"].values, strict=True)).index(
        ("motor", "rz")
    )
    return np.array([*found.position("coupler.start"), held[at]])


def members() -> None:
    """Print errors of structures of many members, by elements per member; parts of the largest value."""
    print("\n| order | elements | comb: frequency | comb: pull | mechanism: elbow | mechanism: moment |")
    print("|---|---|---|---|---|---|")
    exact_comb, exact = comb(10, 4), mechanism(10, 4)
    for order, elements in MEMBERS:
        by_comb = np.abs(comb(order, elements) / exact_comb - 1.0)
        found = mechanism(order, elements)
        place = np.linalg.norm(found[:3] - exact[:3]) / 0.24
        errors = [*by_comb, place, abs(found[3] / exact[3] - 1.0)]
        print(f"| {order} | {elements} | " + " | ".join(f"{e:.1e}" for e in errors) + " |")
    print(f"exact: {exact_comb[0]:.2f} Hz, {exact_comb[1]:.4e} m; {exact[:3]} m, {exact[3]:.4f} N m")


def describe() -> None:
    for name, load in (("bent", LOAD), ("swung: let go", 1.0)):
        model = cantilever(4, 10, ())
        model.force("beam.end", (0, load, 0))
        found = model.equilibrium()
        turned = np.degrees(found.rotation("beam.end")[2])
        moved = np.linalg.norm(found.displacement("beam.end"))
        print(
            f"{name} from the force {load:g} EI/L2: end turned by {turned:.0f} degrees, moved by {moved:.2f} L"
        )


def main() -> None:
    describe()
    table = errors()
    print_errors(table)
    equal_accuracy(table)
    costs()
    members()
    draw(table)


if __name__ == "__main__":
    main()
