"""Sweeps of Campbell diagrams, stability along a load, critical loads and periodic motions, against scaling laws."""

import copy
import math

import pytest

import viscorod as vr
from helpers.plain_text import flat
from viscorod.casefile.case import case_from_dict, load_case
from viscorod.casefile.shipped import shipped_case


def shipped(name, **analysis):
    """Return the content of a shipped case with one analysis changed."""
    content = copy.deepcopy(dict(load_case(shipped_case(name)).content))
    kind = load_case(shipped_case(name)).kind
    content[kind] = content[kind] | analysis
    return content


def swept(content, values, tmp_path):
    """Sweep in this process; return the members, and assert that the file and its report are the same."""
    done = []
    sweep = vr.sweep(case_from_dict(content), values, workers=1, progress=done.append)
    assert [member.outcome for member in sweep.members] == ["completed"] * len(sweep.members)
    assert done == sorted(done)
    assert done[-1] == pytest.approx(len(sweep.members), abs=1.0)
    again = vr.load(sweep.save(tmp_path / "sweep.nc"))
    assert again.report() == sweep.report()
    for member, other in zip(sweep.members, again.members, strict=True):
        assert other.result.report() == member.result.report()
    return sweep


def test_flutter_load_is_that_of_the_force(tmp_path):
    """Half the factor of twice the force: the load at which Beck's column flutters is one load."""
    content = shipped("becks_column", band=[4.0, 13.0], count=4, modes=2)
    content["rods"]["column"]["elements"] = 2
    forces = {"loads[0].value": [[0.0, 0.0, -1.0], [0.0, 0.0, -2.0]]}
    whole = swept(content, forces, tmp_path)
    first, second = (member.figures()["first_limit"] for member in whole.members)
    assert first == pytest.approx(2.0 * second, rel=1e-6)
    assert "grows from" in flat(whole.report())


def test_critical_speed_of_a_disc_on_a_light_shaft(tmp_path):
    """Jeffcott's rotor: sqrt(k/m) with the deflection L^3/(48 EI) + L/(4 kappa G A) under a unit force."""
    content = shipped("whirling_shaft", band=[20.0, 120.0], count=2, modes=2)
    content["materials"]["steel"] |= {"density": 1e-3}
    del content["springs"]
    masses = [2.0, 8.0]
    whole = swept(content, {"bodies.disc.mass": masses}, tmp_path)
    modulus, radius, length, poisson = 200e9, 0.005, 0.6, 0.3
    bending = modulus * math.pi * radius**4 / 4.0
    shear = modulus / (2.0 * (1.0 + poisson)) * math.pi * radius**2
    factor = vr.Circle(radius).shear_factors(poisson)[0]
    softness = length**3 / (48.0 * bending) + length / (4.0 * factor * shear)
    for member, mass in zip(whole.members, masses, strict=True):
        speed = member.figures()["first_critical_speed"]
        assert speed == pytest.approx(math.sqrt(1.0 / (softness * mass)), rel=1e-5)


def test_height_at_which_a_rod_buckles_under_its_weight(tmp_path):
    """7.8373 EI/(rho A g L^3), Greenhill 1881; the factor of twice the gravity is half."""
    content = shipped("tall_rod", count=1)
    content["rods"]["rod"]["elements"] = 2
    gravity = {"loads[0].acceleration": [[0.0, 0.0, -9.81], [0.0, 0.0, -19.62]]}
    whole = swept(content, gravity, tmp_path)
    bending, weight = 200e9 * 0.005**2 / 4.0, 7850.0 * 9.81 * 5.0**3
    for member, g in zip(whole.members, (1.0, 2.0), strict=True):
        assert member.figures()["first_critical_load"] == pytest.approx(
            7.8373 * bending / weight / g, rel=1e-4
        )
        assert member.result.errors.max() < 1e-4  # the error of the mesh is estimated in sweeps too


def test_small_forced_motions_grow_with_the_force(tmp_path):
    """Linear vibration: twice the force, twice the amplitude."""
    content = shipped("clamped_strip", frequencies=[60.0, 70.0], harmonics=2, stability=False)
    content["rods"]["beam"]["elements"] = 1
    whole = swept(content, {"periodic.amplitudes": [[1e-3], [2e-3]]}, tmp_path)
    small, large = (member.figures()["peak"] for member in whole.members)
    assert large == pytest.approx(2.0 * small, rel=1e-6)
    assert [member.figures()["peak_frequency"] for member in whole.members] == pytest.approx([70.0, 70.0])
