"""Case contents turned in space, or measured in other units: the results are known then, from those of the cases."""

import copy

import numpy as np
import pint

from viscorod.casefile.case import case_from_dict
from viscorod.casefile.json_schema import forms
from viscorod.model.connections.motion_words import MOTIONS
from viscorod.model.fields.quantities import SIWalk


def turned(content, Q):
    """The case turned by the rotation ``Q (3, 3)`` about the origin.

    Rods that leave their first axis to the program, and helices, whose start depends on global axes, get them told.
    """
    known = case_from_dict(copy.deepcopy(content)).description.rods
    content = copy.deepcopy(content)

    def direction(v):
        return (Q @ np.asarray(v, dtype=float)).tolist()

    for name, rod in content["rods"].items():
        for key in ("tangent", "normal", "axis"):
            if key in rod:
                rod[key] = direction(rod[key])
        for key in ("start", "end"):
            if key in rod:
                rod[key] = direction(rod[key])
        if "points" in rod:
            rod["points"] = [direction(p) for p in rod["points"]]
        frame = known[name].frames([0.0])[1][0]
        twist = known[name].centreline.twisted(np.zeros(1), known[name].twist)[0]
        first = np.cos(twist) * frame[:, 0] - np.sin(twist) * frame[:, 1]  # as d1 is given, before the twist
        rod["d1"] = direction(first)
        if rod["shape"] == "helix":
            rod["centre"] = direction(rod.get("centre", (0.0, 0.0, 0.0)))
            rod.setdefault("axis", direction((0.0, 0.0, 1.0)))
            rod["phase"] = _phase(known[name].centreline, rod, Q)
    for body in content.get("bodies", {}).values():
        body["centre"] = direction(body.get("centre", (0.0, 0.0, 0.0)))
        if body.get("shape") == "cylinder":
            body["axis"] = direction(body.get("axis", (0.0, 0.0, 1.0)))
        else:
            body["axes"] = [direction(v) for v in body.get("axes", ((1, 0, 0), (0, 1, 0)))[:2]]
        body["points"] = {name: direction(p) for name, p in body.get("points", {}).items()}
    for support in content.get("supports", []):
        if support.get("frame") == "node" or support.get("kind") == "body_velocity":
            continue
        for key in ("normal", "along"):
            if key in support:
                support[key] = direction(support[key])
        kind = support.get("kind", "support")
        if kind in ("clamp", "pin"):
            held = [*MOTIONS[:3], *(MOTIONS[3:] if kind == "clamp" else ())]
            fixed = [word for word in held if word not in support.get("motion", {})]
            support |= {"kind": "support", "fixed": fixed}
        if kind not in ("roller", "guide"):
            support["axes"] = [direction(v) for v in support.get("axes", ((1, 0, 0), (0, 1, 0)))[:2]]
    for load in content.get("loads", []):
        if load["kind"] == "gravity":
            load["acceleration"] = direction(load.get("acceleration", (0.0, 0.0, -9.81)))
        elif not load.get("following"):
            load["value"] = direction(load["value"])
    for joint in content.get("joints", []):
        for key in ("axis", "normal"):
            if key in joint:
                joint[key] = direction(joint[key])
        if "axes" in joint:
            joint["axes"] = [direction(v) for v in joint["axes"][:2]]
    for spring in content.get("springs", []):
        if isinstance(spring.get("to"), list):
            spring["to"] = direction(spring["to"])
        if spring.get("kind", "bushing") == "bushing":
            spring["axes"] = [direction(v) for v in spring.get("axes", ((1, 0, 0), (0, 1, 0)))[:2]]
    campbell = content.get("campbell", {})
    for key in {"axis", "centre"} & campbell.keys():
        campbell[key] = direction(campbell[key])
    steady = content.get("steady", {})
    for key in ("spin", "axis"):
        if isinstance(steady.get(key), list):
            steady[key] = direction(steady[key])
    if isinstance(steady.get("spin"), list):
        steady["centre"] = direction(steady.get("centre", (0.0, 0.0, 0.0)))
    return content


def _phase(helix, rod, Q):
    """The angle at which the turned helix begins, from the direction of its turned start."""
    from viscorod.model.centrelines.line_shapes import Helix

    keys = ("radius", "pitch", "turns", "centre", "axis", "handedness")
    plain = Helix(**{key: rod[key] for key in keys if key in rod}, phase=0.0)
    e1, side = plain._polar(np.zeros(1))[:2]
    sign = 1.0 if helix.handedness == "right" else -1.0
    outward = Q @ helix._polar(np.zeros(1))[0][0]
    return float(np.arctan2(sign * outward @ side[0], outward @ e1[0]))


def scaled(content, length, mass, time):
    """The case in units of which ``length`` make a metre, ``mass`` a kilogram and ``time`` a second.

    The schema tells the unit of every number; places in words ("rod@0.5") are lengths too.
    """
    content = copy.deepcopy(content)
    for load in content.get("loads", []):
        if load["kind"] == "gravity":
            load.setdefault("acceleration", [0.0, 0.0, -9.81])
    walk = _Scaling(forms()["definitions"], reported=True)
    walk.factors = {"[length]": length, "[mass]": mass, "[time]": time}
    return _numbers(walk.table(forms(), _texts(content), (), ""), length)


UNITS = pint.UnitRegistry()


class _Scaling(SIWalk):
    """Meets every number as a text, with its unit."""

    def number(self, text, unit, path):
        value = float(text.removesuffix(" q"))
        dimensions = UNITS.parse_units(unit.replace("^", "**")).dimensionality if unit != "1" else {}
        factor = 1.0
        for name, power in dimensions.items():
            factor *= self.factors[name] ** float(power)
        return value * factor if factor != 1.0 else text


def _texts(node):
    if isinstance(node, dict):
        return {key: _texts(item) for key, item in node.items()}
    if isinstance(node, list):
        return [_texts(item) for item in node]
    return f"{node!r} q" if isinstance(node, int | float) and not isinstance(node, bool) else node


def _numbers(node, length):
    if isinstance(node, dict):
        return {key: _numbers(item, length) for key, item in node.items()}
    if isinstance(node, list):
        return [_numbers(item, length) for item in node]
    if isinstance(node, str) and node.endswith(" q"):
        text = node.removesuffix(" q")
        return int(text) if text.lstrip("-").isdigit() else float(text)
    if isinstance(node, str) and "@" in node:
        rod, s = node.split("@")
        place, *rest = s.split(" ", 1)
        return " ".join([f"{rod}@{float(place) * length!r}", *rest])
    return node
