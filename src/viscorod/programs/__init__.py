"""Convert damping: one number into another, and a rod's damping into the inputs of other programs and back.

* `conversions` and `rayleigh`: times, viscosities, loss factors, damping ratios, decrements, Q, Rayleigh constants.
* `times` and `energy_creation`: six times of a section, the symmetric damping matrix, the two times of a material,
  and where products of times with a stiffness create energy.
* ``inputs``: the damping inputs of other programs, from a section and back.
* `blades`: blades and beams of BeamDyn and GXBeam as rods, and back.
"""

from __future__ import annotations

from viscorod.programs.blades.beamdyn_blade import BeamDynBlade, read_beamdyn_blade, write_beamdyn_blade_file
from viscorod.programs.blades.beamdyn_line import ReferenceLine, key_points
from viscorod.programs.blades.blade_rod import (
    blade_from_rod,
    product_damping,
    rod_from_blade,
    write_beamdyn_blade,
)
from viscorod.programs.blades.gxbeam_assembly import gxbeam_from_rod, rod_from_gxbeam
from viscorod.programs.case_text import case_text
from viscorod.programs.conversions import (
    bulk_time,
    critical_frequency,
    damped_frequency,
    damping_ratio,
    half_power_points,
    log_decrement,
    loss_factor,
    quality_factor,
    ratio_from_log_decrement,
    ratio_from_quality_factor,
    time_from_damping_ratio,
    time_from_loss_factor,
    viscosity,
)
from viscorod.programs.energy_creation import (
    CouplingLimit,
    EnergyCheck,
    check_product,
    creates_energy,
    least_power,
)
from viscorod.programs.inputs import (
    ANCF,
    PROGRAMS,
    BeamDyn,
    ChronoLinear,
    ChronoRayleigh,
    ChronoTapered,
    Exudyn,
    GXBeam,
    MBDyn,
    MuJoCo,
    Newton,
    ProgramInputs,
    PyElastica,
    Recovered,
    SectionData,
    SoRoMoX,
    SoRoSim,
    program,
)
from viscorod.programs.rayleigh import (
    Rayleigh,
    rayleigh_for_constant_ratio,
    rayleigh_from_time,
    time_from_rayleigh,
)
from viscorod.programs.times import MaterialFit, component_times, fit_material, symmetric_damping

__all__ = [
    "ANCF",
    "PROGRAMS",
    "BeamDyn",
    "BeamDynBlade",
    "ChronoLinear",
    "ChronoRayleigh",
    "ChronoTapered",
    "CouplingLimit",
    "EnergyCheck",
    "Exudyn",
    "GXBeam",
    "MBDyn",
    "MaterialFit",
    "MuJoCo",
    "Newton",
    "ProgramInputs",
    "PyElastica",
    "Rayleigh",
    "Recovered",
    "ReferenceLine",
    "SectionData",
    "SoRoMoX",
    "SoRoSim",
    "blade_from_rod",
    "bulk_time",
    "case_text",
    "check_product",
    "component_times",
    "creates_energy",
    "critical_frequency",
    "damped_frequency",
    "damping_ratio",
    "fit_material",
    "gxbeam_from_rod",
    "half_power_points",
    "key_points",
    "least_power",
    "log_decrement",
    "loss_factor",
    "product_damping",
    "program",
    "quality_factor",
    "ratio_from_log_decrement",
    "ratio_from_quality_factor",
    "rayleigh_for_constant_ratio",
    "rayleigh_from_time",
    "read_beamdyn_blade",
    "rod_from_blade",
    "rod_from_gxbeam",
    "symmetric_damping",
    "time_from_damping_ratio",
    "time_from_loss_factor",
    "time_from_rayleigh",
    "viscosity",
    "write_beamdyn_blade",
    "write_beamdyn_blade_file",
]
