"""Case contents turned and moved as a whole: what is said in global axes turns along."""

import copy

import numpy as np

from viscorod.cases.case import case_from_dict
from viscorod.model.motion_words import MOTIONS


def turned(content, Q, shift=(0.0, 0.0, 0.0)):
    """The case turned by the rotation ``Q (3, 3)`` about the origin, then moved by ``shift`` [m].

    Rods that leave their first axis to the program, and helices, whose start depends on global axes, get them told.
    """
    known = case_from_dict(copy.deepcopy(content)).description.rods
    content = copy.deepcopy(content)
    shift = np.asarray(shift)

    def direction(v):
        return (Q @ np.asarray(v, dtype=float)).tolist()

    def point(v):
        return (Q @ np.asarray(v, dtype=float) + shift).tolist()

    for name, rod in content["rods"].items():
        for key in ("tangent", "normal", "axis"):
            if key in rod:
                rod[key] = direction(rod[key])
        for key in ("start", "end"):
            if key in rod:
                rod[key] = point(rod[key])
        if "points" in rod:
            rod["points"] = [point(p) for p in rod["points"]]
        frame = known[name].frames([0.0])[1][0]
        twist = known[name].centreline.twisted(np.zeros(1), known[name].twist)[0]
        first = np.cos(twist) * frame[:, 0] - np.sin(twist) * frame[:, 1]  # as d1 is given, before the twist
        rod["d1"] = direction(first)
        if rod["shape"] == "helix":
            rod["centre"] = point(rod.get("centre", (0.0, 0.0, 0.0)))
            rod.setdefault("axis", direction((0.0, 0.0, 1.0)))
            rod["phase"] = _phase(known[name].centreline, rod, Q)
    for body in content.get("bodies", {}).values():
        body["centre"] = point(body.get("centre", (0.0, 0.0, 0.0)))
        if body.get("shape") == "cylinder":
            body["axis"] = direction(body.get("axis", (0.0, 0.0, 1.0)))
        else:
            body["axes"] = [direction(v) for v in body.get("axes", ((1, 0, 0), (0, 1, 0)))[:2]]
        body["points"] = {name: point(p) for name, p in body.get("points", {}).items()}
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
            spring["to"] = point(spring["to"])
        if spring.get("kind", "bushing") == "bushing":
            spring["axes"] = [direction(v) for v in spring.get("axes", ((1, 0, 0), (0, 1, 0)))[:2]]
    steady = content.get("steady", {})
    for key in ("spin", "axis"):
        if isinstance(steady.get(key), list):
            steady[key] = direction(steady[key])
    if isinstance(steady.get("spin"), list):
        steady["about"] = point(steady.get("about", (0.0, 0.0, 0.0)))
    return content


def _phase(helix, rod, Q):
    """The angle at which the turned helix begins, from the direction of its turned start."""
    from viscorod.model.line_shapes import Helix

    keys = ("radius", "pitch", "turns", "centre", "axis", "handedness")
    plain = Helix(**{key: rod[key] for key in keys if key in rod}, phase=0.0)
    e1, side = plain._polar(np.zeros(1))[:2]
    sign = 1.0 if helix.handedness == "right" else -1.0
    outward = Q @ helix._polar(np.zeros(1))[0][0]
    return float(np.arctan2(sign * outward @ side[0], outward @ e1[0]))
