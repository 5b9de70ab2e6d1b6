"""The picture of a model in its reference shape: what it is made of, what holds and loads it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from viscorod.model.connections.joint_base import ResolvedJoint
from viscorod.model.connections.motion_words import MOTIONS
from viscorod.model.connections.place import BodyPlace
from viscorod.model.connections.resolved_places import position_of
from viscorod.model.connections.spring import ResolvedSpring
from viscorod.model.connections.support_base import ResolvedSupport
from viscorod.model.description.model_description import ModelDescription
from viscorod.model.description.pending_times import without_pending_times
from viscorod.pictures.drawing.bodies_on_paper import draw_bodies
from viscorod.pictures.drawing.labels import Labels
from viscorod.pictures.drawing.load_arrows import arrows, gravity
from viscorod.pictures.drawing.loads_on_paper import draw_gravity, draw_loads
from viscorod.pictures.drawing.paper import ARROW, MOST_NAMES, SIDEWAYS, Paper
from viscorod.pictures.picture import within
from viscorod.pictures.plots.assemblies import zigzag
from viscorod.pictures.plots.projection_view import View
from viscorod.pictures.style import BLUE, INK, LIGHT, ORANGE, PURPLE, RED, SMALL, figure, headline, label_once
from viscorod.results.text_numbers import quantity
from viscorod.solve.problem.discretise import discretise
from viscorod.typing import Floats

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MOST_SHADOWS = 24


def draw_assembly(model: ModelDescription, title: str = "", ax: Axes | None = None) -> Figure:
    """Return the picture of a model in its reference shape, drawn into ``ax`` if it is given.

    Raises:
        InputError: the model is inconsistent.
    """
    return _Picture(model, title, ax).figure


class _Picture(Paper):
    def __init__(self, model: ModelDescription, title: str, ax: Axes | None = None) -> None:
        self.model, self.labels = model, Labels()
        self.problem = discretise(without_pending_times(model))
        self.joints, self.springs = model.resolved_joints(), model.resolved_springs()
        self.loads, self.gravity = list(arrows(model)), gravity(model)
        self.curves = {name: self._curve(name) for name in model.rods}
        points = np.concatenate([*self.curves.values(), *self._seats()])
        self.size = float(np.ptp(points, axis=0).max())
        lines = np.concatenate(list(self.curves.values())) if self.curves else None
        self.view = View.of(np.concatenate([points, *self._reaches(points)]), lines=lines)
        if ax is None:
            self.figure = figure(10.0, 6.6)
            self.figure.subplots_adjust(right=0.79)
            if title:
                headline(self.figure, title)
            self.axes = self.figure.add_subplot()
        else:
            self.figure, self.axes = within(ax), ax
        self.view.prepare(self.axes, f"Reference shape {self.view.name}")
        self._rods()
        draw_bodies(self, model, [*self.joints, *self.springs])
        self._springs()
        self._attachments()
        self._supports()
        self._joints()
        draw_loads(self, self.loads)
        self.axes.margins(0.1 if self.view.plane else 0.04)
        self.view.finish(self.axes)
        self._legend()
        self.labels.place(self.axes)
        draw_gravity(self, self.gravity)

    # --- what there is

    def _curve(self, name: str) -> Floats:
        rod, stations = self.model.rods[name], self.problem.stations
        count = int(np.count_nonzero(stations.rod == self.problem.rods.index(name)))
        return rod.frames(np.linspace(0.0, rod.length, min(12 * count, 600)))[0]

    def _seats(self) -> list[Floats]:
        """Return points beside the rods that must be in the picture."""
        bodies = [
            body.position(point) for body in self.model.bodies.values() for point in (None, *body.points)
        ]
        parts: list[ResolvedJoint | ResolvedSpring] = [*self.joints, *self.springs]
        return [
            np.array([p]) for p in (*bodies, *(part.at_a for part in parts), *(part.at_b for part in parts))
        ]

    def _reaches(self, points: Floats) -> list[Floats]:
        """Return tips of arrows: loads across a plane are not seen in it."""
        length = ARROW * self.size
        tips = [load.points + length * load.values for load in self.loads if not load.turning]
        weight = np.linalg.norm(self.gravity)
        if weight:
            tips.append(points[:1] + length * self.gravity / weight)
        return tips

    # --- drawing

    def _rods(self) -> None:
        named = len(self.curves) + len(self.model.bodies) <= MOST_NAMES
        for name, curve in self.curves.items():
            if self.view.plane is None and len(self.curves) <= MOST_SHADOWS:
                shadow = curve.copy()
                shadow[:, 2] = self.view.floor
                self.axes.plot(*self.view.on_paper(shadow), color=LIGHT, linewidth=1.0, zorder=1)
            style = {"color": BLUE, "linewidth": 2.0 if named else 1.3, "zorder": 2}
            label = label_once(self.axes, "rod")
            self.line(curve, label=label, **style)
            if named:
                first, middle, last = self.view.on_paper(curve[[0, len(curve) // 2, -1]]).T
                self.labels.add(middle, name, BLUE, last - first)
        nodes = self.problem.positions[np.unique(self.problem.stations.nodes)]
        paper = self.view.on_paper(nodes)
        size = 3.2 if len(nodes) <= 60 else 1.6
        dots: dict[str, Any] = {
            "markerfacecolor": "white",
            "markeredgecolor": BLUE,
            "markeredgewidth": 0.7,
            "zorder": 3,
        }
        self.axes.plot(*paper, "o", markersize=size, linestyle="none", label="node", **dots)

    def _springs(self) -> None:
        extent = self.view.scale * self.size
        for spring, given in zip(self.springs, self.model.springs, strict=True):
            name = label_once(self.axes, "spring")
            ends = self.view.on_paper(np.array([spring.at_a, spring.at_b]))
            if float(np.linalg.norm(ends[:, 1] - ends[:, 0])) > 0.02 * extent:
                line = zigzag(ends, 0.02 * extent)
                self.axes.plot(*line, color=PURPLE, linewidth=1.2, zorder=3, label=name)
                self.labels.avoid(0.5 * (line[:, :-1] + line[:, 1:]))
                self.labels.avoid(line)
                if spring.b is None:
                    self.symbols(spring.at_b[None], "+", 8.0, "fixed point", color=INK, zorder=4)
            else:
                style = {"color": PURPLE, "markeredgewidth": 1.4, "zorder": 6}
                self.symbols(spring.at_a[None], "1", 13.0, "spring at a place", **style)
            if given.name and len(self.springs) <= MOST_NAMES:
                self.labels.add(ends.mean(axis=1), given.name, PURPLE)

    def _attachments(self) -> None:
        places = (place for group in self.model.nodes() for place in group)
        points = [position_of(self.model, at)[0] for at in places if not isinstance(at, BodyPlace)]
        if points:
            self.symbols(np.array(points), "o", 4.5, "rigidly attached", color=INK, zorder=4)

    def _supports(self) -> None:
        supports = self.model.resolved_supports()
        kinds: dict[tuple[str, float, str], list[Floats]] = {}
        for support in supports:
            point = position_of(self.model, support.place)[0]
            all_held, pinned = len(support.held) == len(MOTIONS), support.held == MOTIONS[:3]
            kind = ("s", 9.0, "held in part")
            if support.frame != "body" and (all_held or pinned):
                kind = ("s", 9.0, "clamp") if all_held else ("^", 10.0, "pin")
            kinds.setdefault(kind, []).append(point)
            text = _held_text(support)
            if text and len(supports) <= MOST_NAMES:
                self.labels.add(self.view.on_paper(point[None])[:, 0], text)
        for kind, points in kinds.items():
            style: dict[str, Any] = {"color": INK, "zorder": 5}
            if kind[2] == "held in part":
                style |= {"fillstyle": "bottom", "markerfacecoloralt": "white"}
            self.symbols(np.array(points), *kind, **style)

    def _joints(self) -> None:
        centres = [body.position() for body in self.model.bodies.values()]  # not to be covered
        for joint, given in zip(self.joints, self.model.joints, strict=True):
            point = joint.at_a
            self._axes_of(joint)
            gap = float(np.linalg.norm(joint.gap))
            open_ = gap > 1e-6 * self.size
            if open_:
                ends = np.array([joint.at_a, joint.at_b])
                name = label_once(self.axes, "gap of a joint")
                self.line(ends, color=RED, linestyle="--", linewidth=1.2, zorder=6, label=name)
            rigid = not joint.free
            centred = any(np.allclose(point, centre, atol=1e-3 * self.size) for centre in centres)
            style = {
                "markerfacecolor": ORANGE if rigid else "none" if centred else "white",
                "markeredgecolor": INK if rigid else ORANGE,
                "markeredgewidth": 0.8 if rigid else 2.0,
                "zorder": 7,
            }
            self.symbols(
                point[None], "o", 14.0 if centred else 8.0, "rigid joint" if rigid else "joint", **style
            )
            if len(self.joints) <= MOST_NAMES:
                text = given.name or joint.kind
                if joint.motion:
                    text += f": {', '.join(f'{word}(t)' for word in joint.motion)}"
                if open_:
                    text += f", gap {quantity(gap, 'm', 3)}"
                self.labels.add(self.view.on_paper(point[None])[:, 0], text, _DARK_ORANGE)

    def _axes_of(self, joint: ResolvedJoint) -> None:
        """Draw the directions that a joint leaves free, unless it turns in all."""
        turns = [k for k, word in enumerate(MOTIONS[3:]) if word in joint.free]
        slides = [k for k, word in enumerate(MOTIONS[:3]) if word in joint.free]
        if len(turns) == 3:
            turns = []
        many = len(self.joints) > MOST_NAMES
        reach = (0.3 if many else 0.55) * ARROW * self.size
        for k in turns:
            direction = joint.frame[:, k]
            if float(np.linalg.norm(self.view.projection @ direction)) < SIDEWAYS:
                name = label_once(self.axes, "axis across the paper")
                style: dict[str, Any] = {
                    "color": _DARK_ORANGE,
                    "zorder": 8,
                    "linestyle": "none",
                    "label": name,
                }
                self.axes.plot(*self.view.on_paper(joint.at_a[None]), ".", markersize=4.0, **style)
                continue
            ends = joint.at_a + reach * np.outer((-1.0, 1.0), direction)
            name = label_once(self.axes, "axis of rotation")
            self.line(ends, color=ORANGE, linestyle="-.", linewidth=1.3, zorder=6, label=name)
        for k in slides:
            ends = self.view.on_paper(joint.at_a + 1.3 * reach * np.outer((-1.0, 1.0), joint.frame[:, k]))
            self.arrow(ends[:, 0], ends[:, 1], ORANGE, style="<->")
            name = label_once(self.axes, "direction of sliding")
            self.axes.plot([], [], color=ORANGE, linewidth=1.4, label=name)

    def _legend(self) -> None:
        self.axes.legend(
            loc="upper left",
            bbox_to_anchor=(1.01, 1.0),
            frameon=False,
            fontsize=SMALL,
            handlelength=1.8,
            borderaxespad=0.0,
        )


_DARK_ORANGE = "#9a6700"


def _held_text(support: ResolvedSupport) -> str:
    """Return what a support holds, where its symbol does not show it."""
    moving = [f"{word}(t)" for word in support.motion]
    if support.frame == "body":
        return f"holds velocities {', '.join(support.held)}"
    if len(support.held) == len(MOTIONS) or support.held == MOTIONS[:3]:
        return ", ".join(moving)
    words = [f"{word}(t)" if word in support.motion else word for word in support.held]
    own = "" if support.frame == "global" else " (own axes)"
    return ", ".join(words) + own
