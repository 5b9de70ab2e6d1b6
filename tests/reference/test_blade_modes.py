"""Blades of BeamDyn in viscorod's modes: frequencies of the beam that the file describes, and the damping of its mu."""

from dataclasses import replace

import numpy as np
import pytest

import viscorod as vr
from helpers.blade_files import PRIMARY, blade_text
from viscorod import programs as vd
from viscorod.analyses.check import check
from viscorod.analyses.discrete import DiscreteModel
from viscorod.casefile.case import parse_case
from viscorod.solve.settings.statics import EquilibriumSettings

MU = 2e-4
PRIMARY_LINE = [[float(word) for word in line.split()] for line in PRIMARY.splitlines()[10:14]]


def modes(rod):
    model = vr.Model()
    model.add("blade", rod)
    model.clamp("blade.start")
    report = check(DiscreteModel.of(model), EquilibriumSettings())
    return np.array(report.frequencies), np.array(report.damping_ratios)


@pytest.fixture(scope="module")
def blade(tmp_path_factory):
    folder = tmp_path_factory.mktemp("blade")
    (folder / "blade.dat").write_text(blade_text())
    (folder / "primary.dat").write_text(PRIMARY)
    read = vd.read_beamdyn_blade(folder / "blade.dat")
    return vd.rod_from_blade(replace(read, mu=np.full(6, MU)), folder / "primary.dat")


def test_equal_mu_damp_every_mode_by_mu_omega_over_two(blade):
    """D = mu C then, couplings, taper, twist and curvature included: zeta = mu omega/2 for every mode."""
    frequencies, ratios = modes(blade)
    assert ratios == pytest.approx(np.pi * MU * frequencies, rel=1e-8)


def test_a_slender_uniform_blade_bends_as_euler_and_bernoulli_say():
    """Bending about x moves the blade along y; f = 1.8751^2/(2 pi L^2) sqrt(EI/m), and mu4 and mu5 damp the two."""
    stiffness = np.diag([1e8, 1e8, 1e8, 1e4, 4e4, 1e5])
    inertia = np.diag([10.0, 10.0, 10.0, 1e-4, 1e-4, 2e-4])
    mu = np.array([0.0, 0.0, 0.0, 0.02, 0.01, 0.0])
    read = vd.BeamDynBlade(np.array([0.0, 1.0]), np.array([stiffness] * 2), np.array([inertia] * 2), mu)
    frequencies, ratios = modes(vd.rod_from_blade(read, [[0, 0, 0], [0, 0, 5.0]]))
    for k, (bending, time) in enumerate(((1e4, 0.02), (4e4, 0.01))):
        expected = 1.8751040687**2 / (2.0 * np.pi * 25.0) * np.sqrt(bending / 10.0)
        assert frequencies[k] == pytest.approx(expected, rel=1e-3)
        assert ratios[k] == pytest.approx(np.pi * time * frequencies[k], rel=1e-3)


def test_the_case_file_of_a_blade_has_its_modes(blade):
    """Sections of pieces instead of linear ones: frequencies err by the square of the pieces' length, 0.1 % for 16."""
    exact = modes(vd.rod_from_blade(blade.section.blade, PRIMARY_LINE, elements=5, order=5))[0][:2]
    errors = []
    for pieces in (8, 16):
        rod = parse_case(vd.case_text(blade, pieces)).description.rods["blade"]
        errors.append(np.abs(modes(rod)[0][:2] / exact - 1.0).max())
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.1)
    assert errors[1] == pytest.approx(1.1e-3, rel=0.1)
