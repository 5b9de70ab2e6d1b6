"""What an entry of each list of a case file becomes, such as one of ``[[loads]]``."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from viscorod.model.actions.initial_strain import InitialStrain
from viscorod.model.actions.initial_velocity import InitialVelocity
from viscorod.model.actions.load import load
from viscorod.model.actions.rest_strain import RestStrain
from viscorod.model.connections.joint import joint
from viscorod.model.connections.rigid_attachment import Attachment
from viscorod.model.connections.spring import spring
from viscorod.model.connections.support import support

__all__ = ["ENTRIES"]

ENTRIES: dict[str, Callable[[Any], Any]] = {
    "supports": support,
    "loads": load,
    "attachments": Attachment.model_validate,
    "joints": joint,
    "springs": spring,
    "velocities": InitialVelocity.model_validate,
    "strains": InitialStrain.model_validate,
    "rest_strains": RestStrain.model_validate,
}
"""How the entries of each list are read."""
