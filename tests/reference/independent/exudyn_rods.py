"""Two dynamic cases in Exudyn (J. Gerstmayr): geometrically exact two-node beams, Lagrange multipliers, index 3.

Exudyn is not needed to read the tables, only to write them. Newton's tolerances are as tight as its numerically
differentiated tangents allow; the errors of mesh and step are measured by other meshes and steps.
"""

from __future__ import annotations

from importlib import import_module
from itertools import pairwise
from typing import Any

import numpy as np

from .four_bar import POINTS, THICK, THIN, TILT, crank_angle
from .galerkin import Array

FRAME = {"EA": 1e6, "GA": 1e6, "GJ": 1e3, "EI": 1e3}


class Structure:
    """Straight legs of beam elements, joined at their ends."""

    def __init__(self) -> None:
        self.exu = import_module("exudyn")
        self.items = import_module("exudyn.itemInterface")
        self.exu.SuppressWarnings(True)
        self.container = self.exu.SystemContainer()
        self.system = self.container.AddSystem()
        self.ground = self.system.AddObject(self.items.ObjectGround())

    def leg(
        self, start: Any, end: Any, section: dict[str, float], mass: float, inertia: Any, elements: int
    ) -> tuple[list[int], Array]:
        """Give the nodes and the frame (columns: along, across, z); ``inertia`` about these axes."""
        data = self.exu.BeamSection()
        data.stiffnessMatrix = np.diag([section[k] for k in ("EA", "GA", "GA", "GJ", "EI", "EI")])
        data.massPerLength, data.inertia = mass, np.diag(inertia)
        a, b = np.array(start, dtype=float), np.array(end, dtype=float)
        x, z = (b - a) / np.linalg.norm(b - a), np.array([0.0, 0.0, 1.0])
        frame = np.column_stack([x, np.cross(z, x), z])
        turn = list(import_module("exudyn.rigidBodyUtilities").RotationMatrix2EulerParameters(frame))
        nodes = [
            self.system.AddNode(self.items.NodeRigidBodyEP(referenceCoordinates=[*p, *turn]))
            for p in np.linspace(a, b, elements + 1)
        ]
        for pair in pairwise(nodes):
            self.system.AddObject(
                self.items.ObjectBeamGeometricallyExact(
                    nodeNumbers=list(pair), length=float(np.linalg.norm(b - a)) / elements, sectionData=data
                )
            )
        return nodes, frame

    def node(self, number: int) -> int:
        """Marker of a node."""
        return int(self.system.AddMarker(self.items.MarkerNodeRigid(nodeNumber=number)))

    def place(self, point: Any) -> int:
        """Marker of a point of the ground."""
        return int(
            self.system.AddMarker(
                self.items.MarkerBodyRigid(bodyNumber=self.ground, localPosition=list(point))
            )
        )

    def joint(self, kind: str, markers: list[int], first: Array, second: Array, **given: Any) -> int:
        """Join two markers; the axes of the joint in their frames are the columns of ``first`` and ``second``."""
        item = getattr(self.items, f"ObjectJoint{kind}")
        return int(
            self.system.AddObject(
                item(markerNumbers=markers, rotationMarker0=first, rotationMarker1=second, **given)
            )
        )

    def sensor(self, node: int | None = None, joint: int | None = None) -> int:
        """Record a node's place or a joint's force."""
        kinds = self.exu.OutputVariableType
        keep = {"storeInternal": True, "writeToFile": False}
        if node is not None:
            item = self.items.SensorNode(nodeNumber=node, outputVariableType=kinds.Position, **keep)
        else:
            item = self.items.SensorObject(objectNumber=joint, outputVariableType=kinds.ForceLocal, **keep)
        return int(self.system.AddSensor(item))

    def run(
        self, times: Array, step: float, radius: float, relative: float, absolute: float, sensors: Any
    ) -> Any:
        """Integrate by generalised-alpha; the sensors' rows at the times, which are multiples of the step."""
        self.system.Assemble()
        settings = self.exu.SimulationSettings()
        settings.solutionSettings.writeSolutionToFile = False
        settings.solutionSettings.sensorsWritePeriod = float(times[1] - times[0])
        settings.linearSolver.solverType = self.exu.LinearSolverType.EigenSparse
        given = settings.timeIntegration
        given.endTime, given.numberOfSteps, given.verboseMode = float(times[-1]), round(times[-1] / step), 0
        given.newton.useModifiedNewton = True
        given.newton.relativeTolerance, given.newton.absoluteTolerance = relative, absolute
        given.generalizedAlpha.spectralRadius = radius
        self.system.SolveDynamic(settings)
        rows = [np.array(self.system.GetSensorStoredData(sensor)) for sensor in sensors]
        found = [np.array([r[np.argmin(np.abs(r[:, 0] - t))] for t in times]) for r in rows]
        if max(float(np.abs(r[:, 0] - times).max()) for r in found) > 1e-6:
            raise ArithmeticError("the recorded times are not those asked for")
        return [r[:, 1:] for r in found]


def right_angle(times: Array, elements: int, step: float) -> Array:
    """Right-angle frame of Simo and Vu-Quoc (1988): places of elbow and tip, six columns.

    Legs of 10 and 10, EA = GA = 1e6, GJ = EI = 1e3, unit mass, rotary inertia (20, 10, 10), 20 about the leg;
    root clamped; a force along z at the elbow: 0, 50, 0 at t = 0, 1, 2.
    """
    s = Structure()
    first, R = s.leg((0, 0, 0), (10, 0, 0), FRAME, 1.0, [20.0, 10, 10], elements)
    second, Q = s.leg((10, 0, 0), (10, 10, 0), FRAME, 1.0, [20.0, 10, 10], elements)
    s.joint("Generic", [s.place((0, 0, 0)), s.node(first[0])], np.eye(3), R.T)
    s.joint("Generic", [s.node(first[-1]), s.node(second[0])], R.T, Q.T)

    def pulse(_system: Any, t: float, _vector: Any) -> list[float]:
        return [0.0, 0.0, 50 * max(0.0, 1 - abs(t - 1))]

    marker = s.system.AddMarker(s.items.MarkerNodePosition(nodeNumber=first[-1]))
    s.system.AddLoad(s.items.LoadForceVector(markerNumber=marker, loadVectorUserFunction=pulse))
    return np.hstack(s.run(times, step, 0.95, 1e-6, 1e-7, [s.sensor(first[-1]), s.sensor(second[-1])]))


def right_angle_extrapolated(times: Array) -> tuple[Array, Array]:
    """Limit of mesh and step by Richardson's rule, both of second order; and an estimate of the error, growing in time.

    The error: a quarter of the change from the extrapolation of the meshes before, and of the correction for the step.
    """
    coarse, middle, fine = (right_angle(times, n, 0.005) for n in (40, 80, 160))
    halved = right_angle(times, 80, 0.0025)
    step = (halved - middle) * 4 / 3
    last, before = fine + (fine - middle) / 3, middle + (middle - coarse) / 3
    errors = np.abs(last - before).max(axis=1) / 4 + np.abs(step).max(axis=1) / 4
    return last + step, np.maximum.accumulate(errors)


def four_bar(times: Array, elements: int, step: float, radius: float = 0.7) -> Array:
    """Four-bar mechanism with inertia: places of B and C and the force in the joint at A, nine columns.

    The crank's angle is `four_bar.crank_angle`. ``elements`` in AB and in CD, twice as many in BC.
    """
    s = Structure()
    utilities = import_module("exudyn.rigidBodyUtilities")
    legs = []
    for a, b, section, count in (
        ("A", "B", THICK, elements),
        ("B", "C", THICK, 2 * elements),
        ("C", "D", THIN, elements),
    ):
        J = section["rotary"]
        legs.append(s.leg(POINTS[a], POINTS[b], section, section["mass"], [2 * J, J, J], count))
    (AB, P), (BC, Q), (CD, R) = legs

    def driven(_system: Any, t: float, _item: int, _given: Any) -> list[float]:
        return [0.0, 0.0, 0.0, 0.0, 0.0, crank_angle(t)]

    tilt = utilities.RotationMatrixY(TILT)
    start, end = s.place(POINTS["A"]), s.place(POINTS["D"])
    motor = s.joint("Generic", [start, s.node(AB[0])], np.eye(3), P.T, offsetUserFunction=driven)
    s.joint("RevoluteZ", [s.node(AB[-1]), s.node(BC[0])], P.T, Q.T)
    s.joint("RevoluteZ", [s.node(BC[-1]), s.node(CD[0])], Q.T @ tilt, R.T @ tilt)
    s.joint("RevoluteZ", [end, s.node(CD[-1])], np.eye(3), R.T)
    sensors = [s.sensor(AB[-1]), s.sensor(BC[-1]), s.sensor(joint=motor)]
    return np.hstack(s.run(times, step, radius, 1e-5, 1e-5, sensors))
