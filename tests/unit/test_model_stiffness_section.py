"""Sections given by matrices: what is accepted, and how indefinite matrices are told."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from viscorod.errors import InputError
from viscorod.model.sections.stiffness_section import StiffnessSection

ONES = (1.0,) * 6


def random_matrix(seed: int, lowest: float) -> np.ndarray:
    """A symmetric matrix with the lowest eigenvalue given, the others between 1 and 3."""
    rng = np.random.default_rng(seed)
    rotation = np.linalg.qr(rng.normal(size=(6, 6)))[0]
    matrix = rotation @ np.diag([lowest, *rng.uniform(1.0, 3.0, 5)]) @ rotation.T
    return (matrix + matrix.T) / 2.0


def test_six_numbers_are_a_diagonal():
    section = StiffnessSection([1, 2, 3, 4, 5, 6], np.arange(1.0, 7.0), (0, 0, 1, 0, 0, 2))
    stiffness, damping, inertia = section.matrices()
    assert stiffness == pytest.approx(np.diag([1, 2, 3, 4, 5, 6]))
    assert inertia == pytest.approx(stiffness)
    assert damping == pytest.approx(np.diag([0, 0, 1, 0, 0, 2]))


def test_without_damping():
    assert not StiffnessSection(ONES, ONES).matrices()[1].any()


@given(st.integers(0, 2**32 - 1), st.floats(-6.0, 6.0))
@settings(max_examples=50)
def test_definite_matrices_of_any_scale_are_accepted(seed, exponent):
    scale = np.diag(10.0 ** np.array([0, 0, 0, exponent, exponent, exponent]))
    matrix = scale @ random_matrix(seed, 0.1) @ scale
    section = StiffnessSection(matrix, matrix, matrix)
    for found in section.matrices():
        assert found == pytest.approx(matrix, rel=1e-12)


@given(st.integers(0, 2**32 - 1), st.sampled_from(["stiffness", "inertia", "damping"]))
@settings(max_examples=50)
def test_indefinite_matrices_are_refused_with_their_eigenvalue(seed, which):
    matrices = {"stiffness": ONES, "inertia": ONES, "damping": ONES, which: random_matrix(seed, -0.3)}
    with pytest.raises(InputError) as caught:
        StiffnessSection(**matrices)
    (problem,) = caught.value.problems
    assert problem.where == f"StiffnessSection.{which}"
    assert "eigenvalue of -" in problem.found or "diagonal entry -" in problem.found


def test_the_direction_of_a_negative_eigenvalue_is_told_in_words():
    stiffness = np.eye(6)
    stiffness[2, 5] = stiffness[5, 2] = 1.5
    with pytest.raises(
        InputError, match=r"eigenvalue of -0\.5.*1 stretch [-+] 1 twist|- 1 stretch \+ 1 twist"
    ):
        StiffnessSection(stiffness, ONES)
    with pytest.raises(InputError, match="diagonal entry -2 for bend_1"):
        StiffnessSection((1, 1, 1, -2, 1, 1), ONES)
    with pytest.raises(InputError, match="diagonal entry 0 for w3"):
        StiffnessSection(ONES, (1, 1, 1, 1, 1, 0))


def test_semi_definite_damping_is_accepted_and_indefinite_is_not():
    damping = np.zeros((6, 6))
    damping[:2, :2] = [[1.0, 1.0], [1.0, 1.0]]
    assert StiffnessSection(ONES, ONES, damping).matrices()[1] == pytest.approx(damping)
    damping[0, 1] = damping[1, 0] = 1.001
    with pytest.raises(InputError, match="damping must never create energy"):
        StiffnessSection(ONES, ONES, damping)
    coupled = np.zeros((6, 6))
    coupled[0, 3] = coupled[3, 0] = 0.1
    with pytest.raises(InputError, match="damping must never create energy"):
        StiffnessSection(ONES, ONES, coupled)


def test_the_motion_that_would_gain_energy_is_told_in_words():
    damping = np.eye(6)
    damping[2, 5] = damping[5, 2] = 1.5
    with pytest.raises(
        InputError, match=r"extension and twist together would create energy: .*1 stretch"
    ) as caught:
        StiffnessSection(ONES, ONES, damping)
    assert "eigenvalue of -0.5" in caught.value.problems[0].found
    damping[2, 0] = damping[0, 2] = 1.5
    with pytest.raises(InputError, match="shear along d1, extension and twist together would create energy"):
        StiffnessSection(ONES, ONES, damping)
    with pytest.raises(InputError, match="bending about d2 alone would create energy"):
        StiffnessSection(ONES, ONES, (1, 1, 1, 1, -1, 1))


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=50)
def test_six_times_give_a_damping_that_never_creates_energy(seed):
    """D = T C T: D_ii/C_ii = tau_i, symmetric, semi-definite for every coupled C; tau C is neither."""
    rng = np.random.default_rng(seed)
    C, times = random_matrix(seed, 0.05), rng.uniform(0.0, 10.0, 6) * (rng.random(6) > 0.2)
    section = StiffnessSection(C, ONES, times=times)
    D = section.matrices()[1]
    assert np.diag(D) == pytest.approx(times * np.diag(C))
    assert (D == D.T).all()
    assert np.linalg.eigvalsh(D).min() > -1e-12
    # the same power from the springs' side: the energy of strains that are scaled by the roots of the times
    rate = rng.normal(size=6)
    assert rate @ D @ rate == pytest.approx((np.sqrt(times) * rate) @ C @ (np.sqrt(times) * rate), rel=1e-12)
    StiffnessSection(C, ONES, damping=D)  # is accepted as a matrix too


def test_equal_times_scale_the_stiffness_and_a_file_gives_them_back():
    C = random_matrix(3, 0.1)
    section = StiffnessSection(C, ONES, times=[0.02] * 6)
    assert section.matrices()[1] == pytest.approx(0.02 * C, rel=1e-14)
    assert StiffnessSection.model_validate(section.to_dict()) == section
    assert not StiffnessSection(C, ONES, times=[0] * 6).matrices()[1].any()


@pytest.mark.parametrize(
    ("given", "path", "text"),
    [
        ({"times": [1] * 5}, "times", "6 numbers are needed here, 5"),
        ({"times": [1, 1, -1, 1, 1, 1]}, "times[2]", r"negative \(stretch\)"),
        ({"times": [1, 1, float("nan"), 1, 1, 1]}, "times[2]", "finite"),
        ({"times": 0.1}, "times", "a list is needed"),
        ({"times": [1] * 6, "damping": ONES}, "times", "given twice"),
    ],
)
def test_wrong_times(given, path, text):
    with pytest.raises(InputError, match=text) as caught:
        StiffnessSection(ONES, ONES, **given)
    assert caught.value.problems[0].where == f"StiffnessSection.{path}"


def test_couplings_of_an_off_centre_mass_are_accepted():
    """Mass 2 kg/m at xi = (0.1, 0.2): M = [[m 1, -m xi~], [m xi~, J]] is positive definite."""
    x, y = 0.1, 0.2
    tilde = np.array([[0, 0, y], [0, 0, -x], [-y, x, 0]])
    inertia = np.block(
        [[2.0 * np.eye(3), -2.0 * tilde], [2.0 * tilde, 0.01 * np.eye(3) - 2.0 * tilde @ tilde]]
    )
    assert StiffnessSection(ONES, inertia).matrices()[2] == pytest.approx(inertia)


@pytest.mark.parametrize(
    ("stiffness", "path", "text"),
    [
        ((1.0,) * 5, "StiffnessSection.stiffness", "5 items were given"),
        (3.0, "StiffnessSection.stiffness", "a list is needed"),
        ([[1.0] * 6] * 5 + [[1.0] * 5], "StiffnessSection.stiffness[5]", "5 were given"),
        ([[1.0] * 6] * 5 + [3.0], "StiffnessSection.stiffness[5]", "a list is needed"),
        ((1, 1, 1, 1, 1, float("nan")), "StiffnessSection.stiffness[5]", "finite"),
        (np.eye(6) + np.eye(6, k=1), "StiffnessSection.stiffness", "symmetric"),
        (np.ones((6, 6)), "StiffnessSection.stiffness", "eigenvalue"),
    ],
)
def test_malformed(stiffness, path, text):
    with pytest.raises(InputError, match=text) as caught:
        StiffnessSection(stiffness, ONES)
    assert caught.value.problems[0].where == path


@pytest.mark.parametrize("key", ["stiffness", "inertia", "damping"])
def test_round_off_beside_the_diagonal_is_no_asymmetry(key):
    """A coupling of no size beside sqrt(C_ii C_jj) may differ in its second digit; half the sum is taken."""
    given = {"stiffness": [1e6] * 6, "inertia": [1.0] * 6, "damping": [1e3] * 6}
    matrix = np.diag(given[key])
    size = matrix[0, 0]
    matrix[0, 1], matrix[1, 0] = 1.0e-10 * size, 1.1e-10 * size
    section = StiffnessSection(**(given | {key: matrix}))
    assert np.array(getattr(section, key))[0, 1] == pytest.approx(1.05e-10 * size, rel=1e-12)
    matrix[0, 1] = 1e-4 * size
    with pytest.raises(
        InputError, match=f"{key}: .* against .*: the matrix must be symmetric; give the same number"
    ):
        StiffnessSection(**(given | {key: matrix}))
