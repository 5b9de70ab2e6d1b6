"""Draw the house: its wings by rung, from the import contract and the imports themselves; print its figures.

python docs/figures/architecture.py
"""

from __future__ import annotations

import re
import tomllib
from collections import Counter
from pathlib import Path

import grimp
from matplotlib.patches import FancyArrowPatch, FancyBboxPatch

from viscorod.pictures.style import BLUE, GREY, INK, LIGHT, SMALL, TEXT, figure

ROOT = Path(__file__).parents[2]
TARGET = ROOT / "docs" / "images" / "architecture.png"
WORDS = {
    "cli": "commands",
    "analyses": "discretised model, settings -> result",
    "pictures": "plots, films, the page",
    "records": "measurements: read, compared, taken apart",
    "results": "one data set, reports, files",
    "casefile": "TOML, units, schema",
    "programs": "damping in other programs",
    "solve": "mesh, formulations, statics, motion, modes, steady rotations",
    "mechanics": "kernels: arrays in, arrays out",
    "model": "what the user says, validated",
    "checks": "what a value may be",
    "whole_files": "write, then replace",
    "errors": "faults in words",
    "given_as": "types of what is given",
    "alike": "equal contents",
    "limits": "largest sizes",
    "typing": "array types",
    "shown": "one line, cards",
    "small_drawing": "SVG of cards",
    "wording": "nearest names",
    "quantity_text": "2.5 mm, 210 GPa",
    "units": "quantities in SI",
    "unit_text": "units as they are typed",
    "attributes": "missing names",
    "argument_names": "missing arguments",
    "one_thread": "of linear algebra",
}
WIDTH, HEIGHT = 10.0, 12.55
BOX, GAP, STEP = 0.7, 0.25, 1.1
MOST = 4
"""Wings in one row; a rung with more has several."""


def contract() -> list[list[str]]:
    """The rungs of the import contract, from above."""
    with (ROOT / "pyproject.toml").open("rb") as file:
        layers = tomllib.load(file)["tool"]["importlinter"]["contracts"][0]["layers"]
    return [[wing.strip() for wing in re.split("[|:]", rung)] for rung in layers]


def imports() -> tuple[Counter[tuple[str, str]], Counter[tuple[str, str]], set[str]]:
    """Numbers of imports between wings and between folders, and all modules."""
    graph = grimp.build_graph("viscorod", exclude_type_checking_imports=True, cache_dir=None)
    packages = {str(path.parent.relative_to(ROOT / "src")).replace("/", ".") for path in files()}
    wings: Counter[tuple[str, str]] = Counter()
    folders: Counter[tuple[str, str]] = Counter()
    for module in graph.modules:
        for other in graph.find_modules_directly_imported_by(module):
            pair = tuple([*name.split("."), ""][1] for name in (module, other))
            if pair[0] != pair[1]:
                wings[pair] += 1
            rooms = tuple(
                name if name in packages else name.rpartition(".")[0] if name.count(".") > 1 else name
                for name in (module, other)
            )
            if rooms[0] != rooms[1]:
                folders[rooms] += 1
    return wings, folders, graph.modules


def files() -> list[Path]:
    return sorted((ROOT / "src" / "viscorod").rglob("*.py"))


def lines(wing: str) -> int:
    """Lines of a wing."""
    return sum(
        len(path.read_text(encoding="utf-8").splitlines())
        for path in files()
        if path.relative_to(ROOT / "src" / "viscorod").parts[0] in (wing, f"{wing}.py")
    )


def draw(rungs: list[list[str]], wings: Counter[tuple[str, str]]) -> None:
    picture = figure(WIDTH, HEIGHT)
    axes = picture.add_axes((0, 0, 1, 1))
    axes.set(xlim=(0, WIDTH), ylim=(0, HEIGHT))
    axes.axis("off")
    places: dict[str, tuple[float, float, float]] = {}
    left, right = 0.95, WIDTH - 0.25
    for k, rung in enumerate(rungs):
        y = HEIGHT - 1.8 - STEP * k
        beside = min(len(rung), MOST)
        width = (right - left - GAP * (beside - 1)) / beside
        for number in range(-(-len(rung) // beside)):
            for j, wing in enumerate(rung[beside * number : beside * (number + 1)]):
                places[wing] = (left + j * (width + GAP), y - number * (BOX + GAP), width)
        axes.text(0.55, y + BOX / 2, str(k + 1), color=GREY, fontsize=TEXT + 4, va="center", ha="center")
    for (above, below), count in sorted(wings.items()):
        if {above, below} <= set(places) - set(rungs[-1]) and places[above][1] > places[below][1]:
            (xa, ya, wa), (xb, yb, wb) = places[above], places[below]
            axes.add_patch(
                FancyArrowPatch(
                    (xa + wa / 2, ya),
                    (xb + wb / 2, yb + BOX),
                    arrowstyle="-|>",
                    mutation_scale=9,
                    color=BLUE,
                    alpha=0.3,
                    linewidth=0.5 + 0.18 * count**0.5,
                    zorder=1,
                )
            )
    for wing, (x, y, width) in places.items():
        box = FancyBboxPatch(
            (x, y),
            width,
            BOX,
            boxstyle="round,pad=0,rounding_size=0.08",
            facecolor="white",
            edgecolor=INK,
            zorder=2,
        )
        axes.add_patch(box)
        axes.text(
            x + 0.12,
            y + 0.46,
            wing,
            fontsize=TEXT + 1 if width > 2.5 else SMALL + 0.5,
            color=INK,
            weight="bold",
            va="center",
            zorder=3,
        )
        axes.text(
            x + width - 0.12, y + 0.46, f"{lines(wing):,}{' lines' if width > 2.5 else ''}".replace(",", " "),
            fontsize=SMALL - 1, color=GREY, va="center", ha="right", zorder=3,
        )  # fmt: skip
        axes.text(x + 0.12, y + 0.19, WORDS[wing], fontsize=SMALL - 0.5, color=INK, va="center", zorder=3)
    heading = "The house: imports go down, never up"
    legend = "An arrow: a wing imports from another, through what lies between; wider for more. All may use the lowest."
    axes.text(0.2, HEIGHT - 0.36, heading, fontsize=TEXT + 3, color=INK, va="center")
    axes.text(0.2, HEIGHT - 0.68, legend, fontsize=SMALL, color=GREY, va="center")
    axes.plot([0.2, WIDTH - 0.2], [HEIGHT - 0.9] * 2, color=LIGHT, linewidth=1.0)
    picture.savefig(TARGET)


def main() -> None:
    rungs = contract()
    wings, folders, modules = imports()
    draw(rungs, wings)
    stems = Counter(path.stem for path in files() if path.stem != "__init__")
    rooms = {room for pair in folders for room in pair}
    total = sum(len(path.read_text(encoding="utf-8").splitlines()) for path in files())
    print(f"rungs {len(rungs)}, wings {sum(map(len, rungs))}, arrows between wings {len(wings)}")
    print(
        f"folders {len(rooms)}, arrows between folders {len(folders)}, modules {len(modules)}, lines {total}"
    )
    print(f"file names that stand twice: {[name for name, count in stems.items() if count > 1]}")


if __name__ == "__main__":
    main()
