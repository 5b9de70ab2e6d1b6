"""The description of a model: rods and bodies by name, their connections, supports and loads."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, Self

from viscorod.attributes import ByName
from viscorod.errors import Fault, InputError
from viscorod.given_as import Amount
from viscorod.model.actions.initial_strain import InitialStrain
from viscorod.model.actions.initial_velocity import InitialVelocity
from viscorod.model.actions.load import AnyLoad
from viscorod.model.actions.rest_strain import RestStrain
from viscorod.model.bodies.body_base import AnyBody
from viscorod.model.connections import resolved_places as connections
from viscorod.model.connections.joint_base import AnyJoint, ResolvedJoint
from viscorod.model.connections.place import GROUND, AnyPlace
from viscorod.model.connections.rigid_attachment import Attachment
from viscorod.model.connections.spring import AnySpring, ResolvedSpring
from viscorod.model.connections.support_base import AnySupport, ResolvedSupport
from viscorod.model.description import consistency as checks
from viscorod.model.description.connection_methods import Joined
from viscorod.model.description.given_places import known_rod
from viscorod.model.description.load_methods import Loaded
from viscorod.model.description.own_parts import OwnParts
from viscorod.model.description.support_methods import Held
from viscorod.model.fields.arguments import Time, Vector, given
from viscorod.model.fields.definition import RefusedError, plain_value, show
from viscorod.model.fields.values import name_of_part
from viscorod.model.materials.material import Material
from viscorod.model.rod import Rod
from viscorod.model.sections.section_base import AnySection
from viscorod.typing import Floats

__all__ = ["ModelDescription"]


class ModelDescription(OwnParts, Held, Loaded, Joined):
    """Rods and rigid bodies, supports, loads, joints and springs; the same words as in a case file.

    Places are written ``"beam.start"``, ``"beam.end"``, ``"beam@0.15"`` (arc length in m), ``"plate"`` (a body's
    mass centre) and ``"plate.corner"`` (one of its named points). Methods check their arguments at once; `validate`
    checks that the parts fit together.

    Attributes:
        rods, bodies: by name, in the order in which they were added.
        supports: in order.
        loads: in order.
        attachments: pairs of places that are one rigid node.
        joints, springs: in order.
        velocities, strains: at t = 0.
        rest_strains: at which rods are free of stress.
        materials, sections: names of those that rods have, as in a case file; only derivatives look at them.
    """

    def __init__(self) -> None:
        self.rods: dict[str, Rod] = ByName("rods")
        self.bodies: dict[str, AnyBody] = ByName("bodies")
        self.supports: list[AnySupport] = []
        self.loads: list[AnyLoad] = []
        self.attachments: list[Attachment] = []
        self.joints: list[AnyJoint] = []
        self.springs: list[AnySpring] = []
        self.velocities: list[InitialVelocity] = []
        self.strains: list[InitialStrain] = []
        self.rest_strains: list[RestStrain] = []
        self.materials: dict[str, Material] = ByName("materials")
        self.sections: dict[str, AnySection] = ByName("sections")

    def add(self, name: str, part: Rod | AnyBody) -> None:
        """Add a rod or a rigid body under a new name (letters, digits, _ and -).

        Raises:
            InputError: the name is taken or not allowed, or `part` is neither rod nor body.
        """
        kind = "bodies" if isinstance(part, AnyBody) else "rods"
        try:
            name_of_part(name)
        except RefusedError as error:
            raise InputError(Fault(kind, show(name), error.why, error.instead)) from None
        path = f"{kind}.{name}"
        if name == GROUND:
            raise InputError(
                Fault(path, show(name), "this word stands for what does not move", "give another name")
            )
        if not isinstance(part, Rod | AnyBody):
            raise InputError(
                Fault(
                    path,
                    show(part),
                    "this is not a rod and not a rigid body",
                    "give a Rod, such as Rod.straight(...), or a Body",
                )
            )
        for noun, taken in (("rod", self.rods), ("rigid body", self.bodies)):
            if name in taken:
                raise InputError(
                    Fault(path, show(name), f"there is already a {noun} of this name", "give another name")
                )
        if isinstance(part, Rod):
            self.rods[name] = part
        else:
            self.bodies[name] = part

    def velocity(
        self,
        rod: str,
        linear: Vector = (0.0, 0.0, 0.0),
        angular: Vector = (0.0, 0.0, 0.0),
        point: Vector = (0.0, 0.0, 0.0),
        *,
        field: Callable[[float], tuple[Vector, Vector]] | None = None,
        **former: Vector,
    ) -> None:
        """Give a rod, or a body by its name, an initial velocity; see `InitialVelocity`."""
        fields = given(rod=rod, field=field) | former
        if field is None or any(any(vector) for vector in (linear, angular, point)):
            fields |= {"linear": linear, "angular": angular} | ({} if "about" in former else {"point": point})
        made = InitialVelocity(**fields)
        known_rod(self, made.rod, "InitialVelocity", or_body=True)
        self.velocities.append(made)

    def strain(self, rod: str, value: Sequence[float] | Callable[[float], Sequence[float]]) -> None:
        """Give a rod an initial strain; see `InitialStrain`."""
        fields: dict[str, Any] = {"value": value}
        made = InitialStrain(rod, **fields)
        known_rod(self, made.rod, "InitialStrain")
        self.strains.append(made)

    def rest_strain(
        self,
        rod: str,
        value: Sequence[float]
        | Callable[[float], Sequence[float]]
        | Callable[[float, float], Sequence[float]]
        | None = None,
        time: Time = None,
        *,
        stations: Sequence[float] | None = None,
        values: Sequence[Sequence[float]] | None = None,
        temperature: Amount | None = None,
        gradient: Sequence[float] | None = None,
    ) -> None:
        """Give a rod the strain at which it is free of stress, in time; see `RestStrain`."""
        fields = given(value=value, time=time, stations=stations, values=values)
        fields |= given(temperature=temperature, gradient=gradient)
        made = RestStrain(rod, **fields)
        known_rod(self, made.rod, "RestStrain")
        self.rest_strains.append(made)

    def validate(self) -> None:
        """Check that the parts fit together.

        Raises:
            InputError: with all faults, each with its key path and what to give instead.
        """
        problems = list(checks.problems(self))
        if problems:
            raise InputError(problems)

    def place(self, text: str) -> AnyPlace:
        """Return the station of a rod, or the point of a body, that `text` names.

        Raises:
            InputError: there is no such place.
        """
        return connections.find(self, text)

    def position_of(self, place: str) -> Floats:
        """Return the position (3,) of a place in the reference shape, m, global axes.

        Raises:
            InputError: there is no such place.
        """
        return connections.position_of(self, connections.find(self, place))[0]

    def resolved_supports(self) -> list[ResolvedSupport]:
        """Return the supports with their places and axes, in order."""
        return connections.resolved_supports(self)

    def resolved_joints(self) -> list[ResolvedJoint]:
        """Return the joints with their places and axes, in order."""
        return connections.resolved_joints(self)

    def resolved_springs(self) -> list[ResolvedSpring]:
        """Return the springs with their places and axes, in order."""
        return connections.resolved_springs(self)

    def nodes(self) -> list[tuple[AnyPlace, ...]]:
        """Return the groups of places that attachments join into one node each."""
        return connections.joined_places(self)

    def stations(self, rod: str) -> tuple[float, ...]:
        """Return arc lengths at which an element must end (supports, loads, joints, section jumps), m."""
        return connections.required_stations(self, rod)

    def to_dict(self) -> dict[str, Any]:
        """Return the model as a table of the case file; Python functions appear as a note."""
        plain: dict[str, Any] = {"rods": {name: rod.to_dict() for name, rod in self.rods.items()}}
        return plain | {
            key: plain_value(part) for key, part in self.parts().items() if part and key != "rods"
        }

    def parts(self) -> dict[str, Any]:
        """Return the parts from which :meth:`of` makes another model, such as one of a derived class."""
        return {
            "rods": self.rods,
            "bodies": self.bodies,
            "supports": self.supports,
            "loads": self.loads,
            "attachments": self.attachments,
            "joints": self.joints,
            "springs": self.springs,
            "velocities": self.velocities,
            "strains": self.strains,
            "rest_strains": self.rest_strains,
        }

    @classmethod
    def of(
        cls,
        rods: Mapping[str, Rod],
        supports: Iterable[AnySupport] = (),
        loads: Iterable[AnyLoad] = (),
        attachments: Iterable[Attachment] = (),
        velocities: Iterable[InitialVelocity] = (),
        strains: Iterable[InitialStrain] = (),
        *,
        bodies: Mapping[str, AnyBody] | None = None,
        joints: Iterable[AnyJoint] = (),
        springs: Iterable[AnySpring] = (),
        rest_strains: Iterable[RestStrain] = (),
    ) -> Self:
        """Make a model from its parts."""
        model = cls()
        for name, rod in rods.items():
            model.add(name, rod)
        for name, body in (bodies or {}).items():
            model.add(name, body)
        model.supports.extend(supports)
        model.loads.extend(loads)
        model.attachments.extend(attachments)
        model.joints.extend(joints)
        model.springs.extend(springs)
        model.velocities.extend(velocities)
        model.strains.extend(strains)
        model.rest_strains.extend(rest_strains)
        return model
