"""Methods of a model that add supports."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from viscorod.argument_names import known_arguments
from viscorod.model.connections.support import Clamp, Guide, Pin, Roller, Support
from viscorod.model.connections.support_base import AnySupport
from viscorod.model.connections.velocity_support import VelocitySupport
from viscorod.model.description.given_places import placed
from viscorod.model.fields.arguments import Motion, Vector

__all__ = ["Held"]


@known_arguments
class Held:
    """Methods that add supports; a part of `ModelDescription`."""

    supports: list[AnySupport]

    def support(
        self,
        at: str,
        fixed: Sequence[str] = (),
        *,
        frame: str = "global",
        axes: Sequence[Vector] | None = None,
        motion: Motion | None = None,
    ) -> None:
        """Fix any of the six motions, or prescribe them in time; see `Support`."""
        given: dict[str, Any] = {"fixed": fixed, "frame": frame, "axes": axes, "motion": motion or {}}
        self.supports.append(placed(self, Support(at, **given)))

    def clamp(self, at: str, motion: Motion | None = None) -> None:
        """Hold all six motions; see `Clamp`."""
        self.supports.append(placed(self, Clamp(at, **_moving(motion))))

    def pin(self, at: str, motion: Motion | None = None) -> None:
        """Hold the three displacements; see `Pin`."""
        self.supports.append(placed(self, Pin(at, **_moving(motion))))

    def guide(self, at: str, along: Vector | None = None, motion: Motion | None = None) -> None:
        """Allow sliding along one direction only; see `Guide`."""
        given: dict[str, Any] = {"along": along}
        self.supports.append(placed(self, Guide(at, **given, **_moving(motion))))

    def roller(self, at: str, normal: Vector, motion: Motion | None = None) -> None:
        """Hold the displacement along one direction; see `Roller`."""
        given: dict[str, Any] = {"normal": normal}
        self.supports.append(placed(self, Roller(at, **given, **_moving(motion))))

    def body_velocity(self, at: str, fixed: Sequence[str] = (), velocity: Motion | None = None) -> None:
        """Hold velocities along the axes of the moving section; see `VelocitySupport`."""
        given: dict[str, Any] = {"fixed": fixed, "velocity": velocity or {}}
        self.supports.append(placed(self, VelocitySupport(at, **given)))


def _moving(motion: Motion | None) -> dict[str, Any]:
    return {"motion": motion} if motion else {}
