"""The damping inputs of other programs, in modules by what the programs take."""

from __future__ import annotations

from viscorod.argument_names import telling
from viscorod.errors import Fault, InputError
from viscorod.model.fields.definition import did_you_mean
from viscorod.programs.inputs.ancf import ANCF
from viscorod.programs.inputs.chrono import ChronoLinear, ChronoRayleigh, ChronoTapered
from viscorod.programs.inputs.damping_matrices import Exudyn, MBDyn
from viscorod.programs.inputs.program_inputs import ProgramInputs, Recovered, SectionData
from viscorod.programs.inputs.pyelastica import PyElastica
from viscorod.programs.inputs.rigid_segments import MuJoCo, Newton
from viscorod.programs.inputs.sorosim import SoRoMoX, SoRoSim
from viscorod.programs.inputs.stiffness_products import BeamDyn, GXBeam

__all__ = [
    "ANCF",
    "PROGRAMS",
    "BeamDyn",
    "ChronoLinear",
    "ChronoRayleigh",
    "ChronoTapered",
    "Exudyn",
    "GXBeam",
    "MBDyn",
    "MuJoCo",
    "Newton",
    "ProgramInputs",
    "PyElastica",
    "Recovered",
    "SectionData",
    "SoRoMoX",
    "SoRoSim",
    "program",
]

PROGRAMS: dict[str, type[ProgramInputs]] = {
    kind.program: kind
    for kind in (
        BeamDyn,
        GXBeam,
        MBDyn,
        ChronoTapered,
        ChronoLinear,
        ChronoRayleigh,
        Exudyn,
        ANCF,
        MuJoCo,
        Newton,
        SoRoSim,
        SoRoMoX,
        PyElastica,
    )
}
"""The programs by their word; a new one is one class and one line here."""


@telling
def program(word: str) -> type[ProgramInputs]:
    """Return the class of inputs of a program by its word.

    Raises:
        InputError: there is no such program; the message names the nearest and all of them.
    """
    if isinstance(word, str) and word in PROGRAMS:
        return PROGRAMS[word]
    advice = did_you_mean(word, PROGRAMS, str)
    raise InputError(
        Fault("program", str(word), "no such program", f"{advice}The programs are {', '.join(PROGRAMS)}")
    )
