"""The cases in Exudyn: planar and spatial geometrically exact beams, ANCF beams.

Exudyn is loaded as its `fast` module, the one without range checks.
"""

from __future__ import annotations

import sys
import time
import warnings
from importlib import import_module
from importlib.metadata import version
from itertools import pairwise
from typing import Any

import numpy as np

from .cases import Case, Floats, PeerRun, Vector

sys.exudynFast = True  # type: ignore[attr-defined]  # read by Exudyn when it is imported
warnings.filterwarnings("ignore", category=DeprecationWarning, module=r"exudyn.*")

import exudyn as exu  # noqa: E402

items = import_module("exudyn.itemInterface")
exu.SuppressWarnings(True)

PROGRAM = "Exudyn"


def run(
    case: Case,
    elements: int,
    *,
    kind: str = "beam2d",
    steps: int = 1000,
    solver: str = "GeneralizedAlpha",
    spectral_radius: float = 0.9,
    modified_newton: bool = True,
    jacobian_every_step: bool = False,
    relative_tolerance: float = 1e-5,
    absolute_tolerance: float = 1e-7,
    linear_solver: str | None = None,
    repeats: int = 3,
) -> PeerRun:
    """Compute `case` with `elements` per leg and `steps` in all.

    How it is modelled:
        kind "beam2d": `ObjectBeamGeometricallyExact2D`, two nodes with two displacements and an angle,
            linear, reduced integration; same stiffness, inertia and damping of all three planar strains as
            the reference. Only for planar cases.
        kind "beam3d": `ObjectBeamGeometricallyExact` between `NodeRigidBodyEP`, that is two nodes with
            Euler parameters and their constraint; stiffness and inertia as 6x6 and 3x3 diagonal matrices.
            Clamp and corner are `GenericJoint`s, held by Lagrange multipliers. In 1.13.6 the damping matrix has
            no effect on this element (the motion is the undamped one), so damped cases are refused.
        kind "ancf": `ObjectANCFBeam` between `NodePointSlope23`: shear deformable, with the slopes in the
            section as unknowns and the default penalties on the section's own deformation, which the
            reference does not have; they let its error stall near 6e-3 L. Exudyn finds the initial accelerations
            singular and starts from zero ones. Single legs only.

    The preloaded equilibrium is Exudyn's own (`SolveStatic`), on the same mesh; the load is then set to zero.
    The pulse is a Python function, called once for each evaluation of the loads (a few microseconds
    each). No files are written; one sensor in memory records the tip.

    Settings tried: generalised-alpha against the index 2 trapezoidal rule (the same accuracy, but Newton
    converges slowly at steps that resolve the motion well enough); full Newton, a Jacobian for every step, and
    a kept one (half the time, the default here); tolerances from 1e-8 to 1e-4 (below 1e-5 only the time changes);
    dense and sparse solvers (dense is faster for 16 planar elements, sparse from 32 on). `steps` is for the caller to
    choose so that the error of the step is below that of the mesh.

    Args:
        case: the motion.
        elements: of each leg.
        kind: "beam2d", "beam3d" or "ancf".
        steps: equal steps over the whole duration.
        solver: "GeneralizedAlpha" (index 3), "TrapezoidalIndex2", or an explicit one.
        spectral_radius: of generalised-alpha.
        modified_newton: keep the Jacobian as long as Newton converges.
        jacobian_every_step: a new Jacobian at the beginning of every step, kept within it.
        relative_tolerance: of Newton's residual.
        absolute_tolerance: of Newton's residual.
        linear_solver: of Exudyn's; None: dense (Eigen) below 100 coordinates, sparse above.
        repeats: the best time of so many runs counts.
    """
    best = np.inf
    for _ in range(repeats):
        model = _Model(case, elements, kind, linear_solver)
        model.hold()
        settings = model.settings
        integration = settings.timeIntegration
        integration.startTime, integration.endTime = 0.0, case.duration
        integration.numberOfSteps = steps
        integration.newton.useModifiedNewton = modified_newton
        integration.newton.modifiedNewtonJacUpdatePerStep = jacobian_every_step
        integration.newton.relativeTolerance = relative_tolerance
        integration.newton.absoluteTolerance = absolute_tolerance
        integration.generalizedAlpha.spectralRadius = spectral_radius
        kind_of_solver = getattr(exu.DynamicSolverType, solver)
        start = time.perf_counter()
        if not model.system.SolveDynamic(settings, solverType=kind_of_solver):
            raise RuntimeError(
                f"Exudyn did not finish: {case.name}, {kind}, {elements} elements, {steps} steps"
            )
        best = min(best, time.perf_counter() - start)
    recorded = np.array(model.system.GetSensorStoredData(model.sensor))
    label = f"{kind} {elements}, h {case.duration / steps:.3g} s"
    return PeerRun(PROGRAM, version("exudyn"), label, best, recorded[:, 0], recorded[:, 1:4])


class _Model:
    """A case as Exudyn's system."""

    def __init__(self, case: Case, elements: int, kind: str, linear_solver: str | None) -> None:
        self.case, self.kind, self.elements = case, kind, elements
        container = exu.SystemContainer()
        self.container, self.system = container, container.AddSystem()
        self.ground = self.system.AddNode(items.NodePointGround())
        if kind != "beam3d" and len(case.legs) > 1:
            raise ValueError(f"{kind} is for a single leg")
        if kind == "beam3d" and any(case.damping):
            raise ValueError("the spatial beam has no damping; give case.undamped()")
        legs = [self._leg(*leg) for leg in case.legs]
        self._clamp(legs[0][0])
        for k in range(1, len(legs)):
            self._join(legs[k - 1][-1], legs[k][0], k)
        self._loads(legs)
        self.sensor = self.system.AddSensor(
            items.SensorNode(
                nodeNumber=legs[-1][-1],
                storeInternal=True,
                writeToFile=False,
                outputVariableType=exu.OutputVariableType.Position,
            )
        )
        self.system.Assemble()
        self.settings = self._settings(linear_solver)

    def hold(self) -> None:
        """Find the preloaded equilibrium and let go."""
        if self.case.preload is None:
            return
        if not self.system.SolveStatic(self.settings, updateInitialValues=True):
            raise RuntimeError("Exudyn found no equilibrium")
        self.system.SetLoadParameter(self.preload, "loadVector", [0.0, 0.0, 0.0])

    def _settings(self, linear_solver: str | None) -> Any:
        settings = exu.SimulationSettings()
        settings.solutionSettings.writeSolutionToFile = False
        settings.solutionSettings.sensorsWritePeriod = self.case.duration / 1000.0
        small = (self.elements + 1) * len(self.case.legs) * {"beam2d": 3, "beam3d": 7, "ancf": 9}[
            self.kind
        ] < 100
        name = linear_solver or ("EigenDense" if small else "EigenSparse")
        settings.linearSolver.solverType = getattr(exu.LinearSolverType, name)
        settings.staticSolver.numberOfLoadSteps = 20
        settings.staticSolver.newton.relativeTolerance = 1e-9
        settings.staticSolver.newton.absoluteTolerance = 1e-11
        settings.staticSolver.verboseMode = 0
        settings.timeIntegration.verboseMode = 0
        return settings

    def _leg(self, start: Vector, end: Vector) -> list[int]:
        """Nodes of a straight leg with its elements."""
        a, b = np.array(start), np.array(end)
        points = [a + (b - a) * k / self.elements for k in range(self.elements + 1)]
        length = float(np.linalg.norm(b - a)) / self.elements
        frame = _frame(b - a)
        nodes = [self.system.AddNode(self._node(point, frame)) for point in points]
        element = {"beam2d": self._beam2d, "beam3d": self._beam3d, "ancf": self._ancf}[self.kind]
        self.bodies = [
            self.system.AddObject(element([first, second], length)) for first, second in pairwise(nodes)
        ]
        return nodes

    def _node(self, point: Floats, frame: Floats) -> Any:
        if self.kind == "beam2d":
            return items.NodeRigidBody2D(referenceCoordinates=[*point[:2].tolist(), 0.0])
        if self.kind == "ancf":
            slopes = [*frame[:, 1].tolist(), *frame[:, 2].tolist()]
            return items.NodePointSlope23(referenceCoordinates=[*point.tolist(), *slopes])
        from exudyn.rigidBodyUtilities import RotationMatrix2EulerParameters

        parameters = list(RotationMatrix2EulerParameters(frame))
        return items.NodeRigidBodyEP(referenceCoordinates=[*point.tolist(), *parameters])

    def _beam2d(self, nodes: list[int], length: float) -> Any:
        shear, _, stretch, _, bend, _ = self.case.stiffness
        shear_damping, _, stretch_damping, _, bend_damping, _ = self.case.damping
        return items.ObjectBeamGeometricallyExact2D(
            nodeNumbers=nodes,
            length=length,
            massPerLength=self.case.inertia[0],
            crossSectionInertia=self.case.inertia[2],
            bendingStiffness=bend,
            axialStiffness=stretch,
            shearStiffness=shear,
            bendingDamping=bend_damping,
            axialDamping=stretch_damping,
            shearDamping=shear_damping,
        )

    def _section(self) -> Any:
        """Exudyn's order is axial, shear y, shear z, torsion, bending y, bending z."""
        order = [2, 0, 1, 5, 3, 4]
        section = exu.BeamSection()
        section.stiffnessMatrix = np.diag(np.array(self.case.stiffness)[order])
        section.dampingMatrix = np.diag(np.array(self.case.damping)[order])
        section.massPerLength = self.case.inertia[0]
        section.inertia = np.diag(np.array(self.case.inertia)[[3, 1, 2]])
        return section

    def _beam3d(self, nodes: list[int], length: float) -> Any:
        return items.ObjectBeamGeometricallyExact(
            nodeNumbers=nodes, length=length, sectionData=self._section()
        )

    def _ancf(self, nodes: list[int], length: float) -> Any:
        return items.ObjectANCFBeam(nodeNumbers=nodes, length=length, sectionData=self._section())

    def _clamp(self, node: int) -> None:
        add = self.system
        if self.kind == "beam3d":
            frame = _frame(np.subtract(self.case.corners[1], self.case.corners[0]))
            ground = add.AddMarker(items.MarkerNodeRigid(nodeNumber=self.ground))
            marker = add.AddMarker(items.MarkerNodeRigid(nodeNumber=node))
            add.AddObject(items.ObjectJointGeneric(markerNumbers=[ground, marker], rotationMarker1=frame.T))
            return
        ground = add.AddMarker(items.MarkerNodeCoordinate(nodeNumber=self.ground, coordinate=0))
        for coordinate in range(3 if self.kind == "beam2d" else 9):
            marker = add.AddMarker(items.MarkerNodeCoordinate(nodeNumber=node, coordinate=coordinate))
            add.AddObject(items.ObjectConnectorCoordinate(markerNumbers=[ground, marker]))

    def _join(self, first: int, second: int, corner: int) -> None:
        """Make the end of one leg and the start of the next one rigid at corner number `corner`."""
        points = np.array(self.case.corners)
        markers = [self.system.AddMarker(items.MarkerNodeRigid(nodeNumber=node)) for node in (first, second)]
        before, after = (
            _frame(points[corner] - points[corner - 1]),
            _frame(points[corner + 1] - points[corner]),
        )
        self.system.AddObject(
            items.ObjectJointGeneric(markerNumbers=markers, rotationMarker0=before.T, rotationMarker1=after.T)
        )

    def _loads(self, legs: list[list[int]]) -> None:
        case, add = self.case, self.system
        if case.preload:
            marker = add.AddMarker(items.MarkerNodePosition(nodeNumber=legs[-1][-1]))
            load = items.LoadForceVector(markerNumber=marker, loadVector=list(case.preload))
            self.preload = add.AddLoad(load)
        if case.pulse:
            x, y, z = case.pulse

            def triangle(_mbs: Any, t: float, _vector: Any) -> list[float]:
                size = max(0.0, 1.0 - abs(t - 1.0))
                return [x * size, y * size, z * size]

            marker = add.AddMarker(items.MarkerNodePosition(nodeNumber=legs[0][-1]))
            pulse = items.LoadForceVector(markerNumber=marker, loadVectorUserFunction=triangle)
            add.AddLoad(pulse)
        if case.gravity:
            for body in self.bodies:
                marker = add.AddMarker(items.MarkerBodyMass(bodyNumber=body))
                weight = items.LoadMassProportional(markerNumber=marker, loadVector=list(case.gravity))
                add.AddLoad(weight)


def _frame(direction: Floats) -> Floats:
    """Rotation with the first column along `direction`, which is not along z, the third one along z."""
    x = np.asarray(direction) / np.linalg.norm(direction)
    z = np.array([0.0, 0.0, 1.0])
    return np.column_stack([x, np.cross(z, x), z])
