"""Centre lines: lengths and frames against closed forms, orthonormality, no twist by differences."""

import math

import numpy as np
import pytest

from viscorod.errors import InputError
from viscorod.model.centrelines.line_shapes import Arc, Helix, Straight
from viscorod.model.centrelines.parametric_lines import ParametricCurve, ThroughPoints

HELIX = Helix(0.1, 0.05, 3.3, centre=(1.0, 2.0, 3.0), axis=(1.0, 2.0, 2.0), phase=0.4)
LEFT = Helix(0.1, 0.05, 3.3, handedness="left")


def knot(u):
    """A part of the trefoil."""
    return math.sin(7 * u) + 2 * math.sin(14 * u), math.cos(7 * u) - 2 * math.cos(14 * u), -math.sin(21 * u)


CENTRELINES = {
    "straight": Straight((0, 0, 0), (1, 2, 3)),
    "vertical": Straight((0, 0, 1), (0, 0, -2)),
    "arc": Arc((1, 0, 0), (0, 1, 0), (1, 0, 0), 2.0, 2.5),
    "skew_arc": Arc((1, 0, 0), (1, 1, 0), (-1, 1, 1), 0.3, 7.0),
    "helix": HELIX,
    "left": LEFT,
    "ring": Helix(0.2, 0.0, 0.9, axis=(1, 0, 0)),
    "points": ThroughPoints([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 1), (0, 0, 2)]),
    "two_points": ThroughPoints([(0, 0, 0), (1, 2, 2)]),
    "curve": ParametricCurve(knot),
}
STENCIL = np.array([-1.0, 9.0, -45.0, 0.0, 45.0, -9.0, 1.0]) / 60.0
"""Sixth-order central difference."""


@pytest.fixture(params=CENTRELINES, name="line")
def _line(request):
    return CENTRELINES[request.param]


def differences(line, s, h, **options):
    """Derivatives of positions and frames by central differences."""
    samples = [line.frames(s + k * h, **options) for k in range(-3, 4)]
    position = sum(c * sample[0] for c, sample in zip(STENCIL, samples, strict=True)) / h
    frame = sum(c * sample[1] for c, sample in zip(STENCIL, samples, strict=True)) / h
    return position, frame


def stations(line, count=40):
    return np.linspace(0.0, 1.0, count) ** 1.3 * line.length


def test_frames_are_rotations(line):
    _, frames = line.frames(stations(line))
    gram = np.einsum("nji,njk->nik", frames, frames)
    assert np.abs(gram - np.eye(3)).max() < 1e-13
    assert np.abs(np.linalg.det(frames) - 1.0).max() < 1e-13


def test_third_axis_is_the_tangent_and_s_the_arc_length(line):
    s = np.linspace(0.1, 0.9, 9) * line.length
    position, _ = differences(line, s, 1e-4 * line.length)
    tangent = line.frames(s)[1][:, :, 2]
    assert np.abs(position - tangent).max() < 1e-9


def test_no_twist_and_the_right_curvature(line):
    s = np.linspace(0.1, 0.9, 9) * line.length
    _, rate = differences(line, s, 1e-4 * line.length)
    frames = line.frames(s)[1]
    twist = (rate[:, :, 0] * frames[:, :, 1]).sum(axis=1)
    assert np.abs(twist).max() * line.length < 1e-9
    assert np.abs(rate[:, :, 2] - line.curvature(s)).max() * line.length < 1e-8


def test_total_twist_grows_evenly(line):
    s = np.linspace(0.1, 0.9, 9) * line.length
    _, rate = differences(line, s, 1e-4 * line.length, twist=2.5)
    frames = line.frames(s, twist=2.5)[1]
    twist = (rate[:, :, 0] * frames[:, :, 1]).sum(axis=1)
    assert twist * line.length == pytest.approx(np.full(9, 2.5), abs=1e-9)


def test_twist_as_a_function_turns_about_the_tangent(line):
    s = stations(line, 7)
    plain, turned = line.frames(s)[1], line.frames(s, twist=lambda x: 0.3 + x * x)[1]
    angle = 0.3 + s**2
    expected = np.cos(angle)[:, None] * plain[:, :, 0] + np.sin(angle)[:, None] * plain[:, :, 1]
    assert turned[:, :, 0] == pytest.approx(expected, abs=1e-12)
    assert turned[:, :, 2] == pytest.approx(plain[:, :, 2], abs=1e-15)


def test_given_first_axis_is_projected(line):
    wanted = np.array([0.3, -0.5, 0.8])
    frame = line.frames([0.0], d1=wanted)[1][0]
    normal = wanted - (wanted @ frame[:, 2]) * frame[:, 2]
    assert frame[:, 0] == pytest.approx(normal / np.linalg.norm(normal), abs=1e-13)


def test_default_second_axis_points_up(line):
    frame = line.frames([0.0])[1][0]
    tangent = frame[:, 2]
    up = np.array([0.0, 1.0, 0.0] if abs(tangent[2]) > 0.999999 else [0.0, 0.0, 1.0])
    normal = up - (up @ tangent) * tangent
    assert frame[:, 1] == pytest.approx(normal / np.linalg.norm(normal), abs=1e-13)


def test_a_rod_along_x_has_its_width_along_y():
    frame = Straight((0, 0, 0), (2, 0, 0)).frames([1.0])[1][0]
    assert frame == pytest.approx(np.array([[0, 0, 1], [1, 0, 0], [0, 1, 0]]), abs=1e-15)


def test_straight_positions():
    line = CENTRELINES["straight"]
    assert line.length == pytest.approx(math.sqrt(14.0), rel=1e-15)
    assert line.frames([0.0, line.length])[0] == pytest.approx(np.array([[0, 0, 0], [1, 2, 3]]), abs=1e-15)


def test_arc_positions():
    line = Arc((0, 0, 0), (0, 1, 0), (1, 0, 0), 100.0, math.pi / 4)
    assert line.length == pytest.approx(25.0 * math.pi, rel=1e-15)
    end = line.frames([line.length])[0][0]
    half = math.sqrt(0.5)
    assert end == pytest.approx([100.0 * (1 - half), 100.0 * half, 0.0], rel=1e-14)
    assert np.linalg.norm(line.curvature(stations(line)), axis=1) == pytest.approx(0.01, rel=1e-14)


def test_helix_positions_and_length():
    line = Helix(0.3, 0.2, 2.5, phase=0.7)
    assert line.length == pytest.approx(2.5 * math.hypot(2 * math.pi * 0.3, 0.2), rel=1e-15)
    s = stations(line)
    angle = 0.7 + 5.0 * math.pi * s / line.length
    expected = np.column_stack([0.3 * np.cos(angle), 0.3 * np.sin(angle), 0.2 * 2.5 * s / line.length])
    assert line.frames(s)[0] == pytest.approx(expected, abs=1e-15)
    left = Helix(0.3, 0.2, 2.5, phase=0.7, handedness="left").frames(s)[0]
    angle = 0.7 - 5.0 * math.pi * s / line.length
    expected = np.column_stack([0.3 * np.cos(angle), 0.3 * np.sin(angle), 0.2 * 2.5 * s / line.length])
    assert left == pytest.approx(expected, abs=1e-15)


def test_helix_turns_about_its_axis_with_the_frenet_curvature():
    s = stations(HELIX)
    axis = np.array([1.0, 2.0, 2.0]) / 3.0
    arm = HELIX.frames(s)[0] - np.array([1.0, 2.0, 3.0])
    arm -= (arm @ axis)[:, None] * axis
    assert np.linalg.norm(arm, axis=1) == pytest.approx(0.1, rel=1e-13)
    c = 0.05 / (2 * math.pi)
    assert np.linalg.norm(HELIX.curvature(s), axis=1) == pytest.approx(0.1 / (0.01 + c**2), rel=1e-13)


def test_a_function_gives_the_same_as_the_closed_form_whatever_its_parametrisation():
    closed = Helix(0.1, 0.05, 3.3, phase=0.4)
    line = ParametricCurve(lambda u: closed.bishop(np.array([(u + u * u) / 2 * closed.length]))[0][0])
    assert line.length == pytest.approx(closed.length, rel=1e-13)
    s = stations(closed)
    for mine, exact in zip(line.frames(s, d1=(0, 0, 1)), closed.frames(s, d1=(0, 0, 1)), strict=True):
        assert np.abs(mine - exact).max() < 2e-12


def test_points_are_met_in_order_and_a_parabola_is_exact():
    points = np.array(CENTRELINES["points"].points)
    line = CENTRELINES["points"]
    coarse = np.linspace(0, line.length, 801)
    gaps = np.linalg.norm(line.frames(coarse)[0][None] - points[:, None], axis=2)
    nearest = gaps.argmin(axis=1)
    assert (np.diff(nearest) > 0).all()
    for point, k in zip(points, nearest, strict=True):
        there = np.linspace(coarse[max(k - 1, 0)], coarse[min(k + 1, 800)], 101)
        assert np.linalg.norm(line.frames(there)[0] - point, axis=1).min() < 2e-4
    # Three points with equal chords: the spline is the parabola y = x^2, of known length.
    line = ThroughPoints([(-1, 1, 0), (0, 0, 0), (1, 1, 0)])
    assert line.length == pytest.approx(math.sqrt(5.0) + math.asinh(2.0) / 2.0, rel=1e-13)


def test_two_points_are_a_straight_line():
    line, straight = CENTRELINES["two_points"], Straight((0, 0, 0), (1, 2, 2))
    s = stations(straight)
    for mine, exact in zip(line.frames(s), straight.frames(s), strict=True):
        assert mine == pytest.approx(exact, abs=1e-13)


def test_closed_curve_turns_by_its_writhe():
    """The rotation-minimising frame of a closed curve on a cone of directions turns by the solid angle.

    The tangents of one turn of a helix run round a circle at the polar angle b, so the frame comes back turned by
    2 pi (1 - cos b) about the tangent.
    """
    line = Helix(0.1, 0.3, 1.0)
    slope = 0.3 / math.hypot(2 * math.pi * 0.1, 0.3)
    start, end = line.frames([0.0, line.length])[1]
    cosine = start[:, 0] @ end[:, 0]
    assert cosine == pytest.approx(math.cos(2 * math.pi * (1 - slope)), abs=1e-13)


@pytest.mark.parametrize(
    ("build", "path", "text"),
    [
        (lambda: Straight((1, 1, 1), (1, 1, 1)), "Straight", "length 0"),
        (lambda: Straight((1e308, 0, 0), (-1, 0, 0)), "Straight.start[0]", "larger than any"),
        (lambda: Straight((1, 1), (1, 1, 1)), "Straight.start", "3 numbers"),
        (lambda: Arc((0, 0, 0), (1, 0, 0), (1, 1, 0), 1.0, 1.0), "Arc.normal", "perpendicular"),
        (lambda: Arc((0, 0, 0), (1, 0, 0), (1, 0, 0), 1.0, 1.0), "Arc.normal", "perpendicular"),
        (lambda: Arc((0, 0, 0), (0, 0, 0), (1, 0, 0), 1.0, 1.0), "Arc.tangent", "no direction"),
        (lambda: Arc((0, 0, 0), (0, 1, 0), (1, 0, 0), 1.0, 0.0), "Arc.angle", "> 0"),
        (lambda: Helix(0.1, -0.1, 1.0), "Helix.pitch", ">= 0"),
        (lambda: Helix(0.1, 0.1, 1.0, handedness="lefty"), "Helix.handedness", "did you mean 'left'"),
        (lambda: ThroughPoints([(0, 0, 0)]), "ThroughPoints.points", "at least two"),
        (lambda: ThroughPoints([(0, 0, 0), (0, 0, 0)]), "ThroughPoints.points[1]", "same point twice"),
        (lambda: ThroughPoints([(0, 0, 0), (1, 0)]), "ThroughPoints.points[1]", "3 numbers"),
        (lambda: ThroughPoints([(0, 0, 0), (1, 0, float("nan"))]), "ThroughPoints.points[1][2]", "finite"),
        (lambda: ThroughPoints([(0, 0, 0), (1, 0, 0), (0, 0, 0)]), "ThroughPoints", "turns back"),
        (lambda: ParametricCurve(lambda u: (abs(u - 0.3), u, 0.0)), "ParametricCurve", "corner"),
        (lambda: ParametricCurve(lambda u: (1.0, 2.0, 3.0)), "ParametricCurve", "stops"),
        (lambda: ParametricCurve(lambda u: (abs(u - 0.25), u, 0.0)), "ParametricCurve", "corner"),
        (lambda: ParametricCurve(lambda u: (u, 0.0 if u < 0.5 else 1.0, 0.0)), "ParametricCurve", "jumps"),
        (
            lambda: ParametricCurve(lambda u: ((u - 0.5) ** 3, (u - 0.5) ** 2, 0.0)),
            "ParametricCurve",
            "stops",
        ),
        (lambda: ParametricCurve(lambda u: ((u - 0.5) ** 2, 0.0, 0.0)), "ParametricCurve", "stops"),
        (lambda: ParametricCurve(lambda u: ((u - 0.3) ** 2, 0.0, 0.0)), "ParametricCurve", "stops"),
        (lambda: ParametricCurve(lambda u: (u, float("nan"), 0.0)), "ParametricCurve.function", "finite"),
        (lambda: ParametricCurve(lambda u: (u, 0.0)), "ParametricCurve.function", "3 numbers"),
        (lambda: ParametricCurve("r(s)"), "ParametricCurve.function", "Python function"),
    ],
)
def test_refused(build, path, text):
    with pytest.raises(InputError, match=text) as caught:
        build()
    (problem,) = caught.value.problems
    assert problem.where == path
    assert problem.instead


def test_first_axis_along_the_rod_is_refused():
    with pytest.raises(InputError, match="d1 must not point along the rod"):
        Straight((0, 0, 0), (1, 0, 0)).frames([0.0], d1=(-1.0, 0.0, 0.0))


def test_points_of_a_file_are_those_of_a_list(tmp_path):
    """Names or numbers of columns in any order, with the unit of the head or a given one."""
    points = [[0.0, 0.0, 0.01], [0.04, 0.0, 0.012], [0.08, 0.03, 0.01]]
    listed = ThroughPoints(points)
    (tmp_path / "head.csv").write_text("z [mm];x [cm];y [m]\n10;0;0\n12;4;0\n10;8;0,03\n")
    (tmp_path / "plain.txt").write_text("0 0 10\n40 0 12\n80 30 10\n")
    for read in (
        ThroughPoints(file=str(tmp_path / "head.csv"), columns=["x", "y", "z"]),
        ThroughPoints(file=str(tmp_path / "plain.txt"), unit="mm"),
    ):
        np.testing.assert_allclose(read.given_points, points, rtol=1e-15)
        assert read.length == pytest.approx(listed.length, rel=1e-14)


def test_files_of_points_that_cannot_be_read(tmp_path):
    (tmp_path / "twice.csv").write_text("0,0,0\n1,0,0\n1,0,0\n")
    (tmp_path / "time.csv").write_text("x [s],y,z\n0,0,0\n1,0,0\n")
    for given, words in (
        ({"file": str(tmp_path / "none.csv")}, "no such file"),
        ({"file": str(tmp_path / "twice.csv")}, r"the same point twice in a row \(row 3\)"),
        ({"file": str(tmp_path / "twice.csv"), "columns": [1, 2, 4]}, "the table has 3 columns"),
        ({"file": str(tmp_path / "time.csv")}, "the unit 's' of the column is no length"),
        ({"file": "a.csv", "points": [[0, 0, 0], [1, 0, 0]]}, "points that are listed, or read from a file"),
        ({}, "give points, or file"),
    ):
        with pytest.raises(InputError, match=words):
            ThroughPoints(**given)
