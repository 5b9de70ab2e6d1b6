"""The damping inputs of other programs, each in a module of its own."""

from __future__ import annotations

from viscorod.damping.programs.base import ProgramInputs, Recovered, SectionData
from viscorod.damping.programs.beamdyn import BeamDyn
from viscorod.damping.programs.chrono import ChronoLinear, ChronoRayleigh, ChronoTapered
from viscorod.damping.programs.exudyn import Exudyn
from viscorod.damping.programs.gxbeam import GXBeam
from viscorod.damping.programs.mbdyn import MBDyn
from viscorod.damping.programs.mujoco import MuJoCo
from viscorod.damping.programs.newton import Newton
from viscorod.damping.programs.pyelastica import PyElastica
from viscorod.damping.programs.sorosim import SoRoMoX, SoRoSim
from viscorod.errors import InputError, Problem
from viscorod.model.described import did_you_mean

__all__ = [
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
        MuJoCo,
        Newton,
        SoRoSim,
        SoRoMoX,
        PyElastica,
    )
}
"""The programs by their word; a new one is one module and one line here."""


def program(word: str) -> type[ProgramInputs]:
    """The inputs of a program by its word.

    Raises:
        InputError: there is no such program; the message names the nearest and all of them.
    """
    if word in PROGRAMS:
        return PROGRAMS[word]
    advice = did_you_mean(word, PROGRAMS, str)
    raise InputError(
        Problem("program", word, "no such program", f"{advice}The programs are {', '.join(PROGRAMS)}")
    )
