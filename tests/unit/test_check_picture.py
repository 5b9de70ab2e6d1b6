"""The picture of a model before it is solved, and the tables of what joins its rods."""

import numpy as np
import pytest

import viscorod as vr
from helpers.pictures import written
from viscorod.analyses.check import check
from viscorod.analyses.discrete import DiscreteModel
from viscorod.pictures.drawing.model_drawing import draw_assembly

STEEL = {"material": vr.Material(2e11, 0.3, 7850.0), "section": vr.Circle(0.01)}


def machine():
    """Everything that has a symbol, in space."""
    model = vr.Model()
    model.add("crank", vr.Rod.straight((0, 0, 0), (0, 0.3, 0.2), **STEEL, constraints="kirchhoff"))
    model.add("arch", vr.Rod.arc((0, 0.3, 0.2), (1, 0, 0), (0, 0, 1), 0.4, 1.2, **STEEL))
    model.add("coil", vr.Rod.helix(0.05, 0.05, 2, centre=(1, 0, 0), axis=(0, 0, 1), **STEEL))
    end = model.position_of("arch.end")
    points = {"left": tuple(np.add(end, [0, 0.1, 0])), "right": tuple(np.add(end, [0, -0.1, 0]))}
    model.add(
        "plate", vr.Body.box(tuple(np.add(end, [0.1, 0, 0])), (0.2, 0.2, 0.02), mass=1.0, points=points)
    )
    model.clamp("coil.start")
    model.attach("arch.end", "plate")
    model.revolute("crank.start", "ground", (1, 0, 0), motion={"rz": vr.Ramp(0, 1)}, name="motor")
    model.ball("crank.end", "arch.start", name="ball")
    model.prismatic("plate", "ground", (0, 0, 1), name="slide")
    model.support("coil.end", ["ux", "uy"])
    model.gravity()
    model.force("coil.end", (0, 0, -5))
    model.moment("arch@0.2", (0, 2, 0), time=vr.Sine(1.0))
    model.distributed_force("crank", (0, 0, -30), until=1.0)
    model.spring("plate.left", stiffness={"ux": 1e3}, damping={"ux": 2.0}, name="mount")
    model.line_spring("plate.right", (0.4, 0.8, 0.9), stiffness=100.0, name="rope")
    return model


def texts(figure):
    return [text.get_text() for text in figure.axes[0].texts]


def legend(figure):
    return [text.get_text() for text in figure.axes[0].get_legend().get_texts()]


def test_everything_is_drawn_and_named(tmp_path):
    figure = draw_assembly(machine(), "A machine")
    found = texts(figure)
    for name in ("crank", "arch", "coil", "plate, 1 kg", "left", "right", "ball", "slide", "mount", "rope"):
        assert name in found
    for text in (
        "motor: rz(t)",
        "ux, uy",
        "5 N",
        "2 N m, varies in time",
        "30 N/m, until 1 s",
        "gravity\n9.81 m/s²",
    ):
        assert text in found
    assert {"rod", "node", "body", "clamp", "held in part", "joint", "spring", "force", "moment"} < set(
        legend(figure)
    )
    assert figure.axes[0].get_title(loc="left") == "Reference shape in space"
    assert written(machine().draw, tmp_path / "assembly.png", "A machine").stat().st_size > 10_000


def test_labels_keep_off_each_other():
    figure = draw_assembly(machine())
    figure.draw_without_rendering()
    axes, renderer = figure.axes[0], figure.canvas.get_renderer()
    names = ("crank", "arch", "coil", "plate, 1 kg", "left", "right", "ball", "slide", "mount", "rope", "5 N")
    boxes = [text.get_window_extent(renderer) for text in axes.texts if text.get_text() in names]
    assert len(boxes) == len(names)
    overlaps = [(a, b) for k, a in enumerate(boxes) for b in boxes[:k] if a.overlaps(b)]
    assert not overlaps


def test_plane_model_is_drawn_in_its_plane():
    model = vr.Model()
    model.add("beam", vr.Rod.straight((0, 0, 0), (1, 0, 0), **STEEL))
    model.pin("beam.start")
    model.moment("beam.end", (0, 0, 2))
    model.force("beam.end", (0, 1, 0), following=False)
    model.joint("general", "beam@0.5", "ground", free=["ux", "uy", "rz"])
    figure = draw_assembly(model)
    assert figure.axes[0].get_title(loc="left") == "Reference shape in the xy plane"
    assert {"pin", "axis across the paper"} < set(legend(figure))


def test_following_load_is_turned_with_its_section():
    model = vr.Model()
    model.add("beam", vr.Rod.straight((0, 0, 0), (1, 0, 0), **STEEL))
    model.clamp("beam.start")
    model.force("beam.end", (0, 0, 1), following=True)
    assert "1 N, follows" in texts(draw_assembly(model))
    from viscorod.pictures.drawing.load_arrows import arrows

    (load,) = arrows(model)
    assert load.values[0] == pytest.approx([1, 0, 0])  # d3 is the tangent


def test_gap_of_a_joint_is_shown():
    model = vr.Model()
    model.add("a", vr.Rod.straight((0, 0, 0), (1, 0, 0), **STEEL))
    model.add("b", vr.Rod.straight((1.01, 0, 0), (2, 0, 0), **STEEL))
    model.clamp("a.start")
    model.clamp("b.end")
    model.revolute("b.start", "a.end", (0, 0, 1), name="pivot")
    figure = draw_assembly(model)
    assert "pivot, gap 0.01 m" in texts(figure)
    assert "gap of a joint" in legend(figure)


def test_a_hundred_rods_are_drawn_without_names(tmp_path):
    model = vr.Model()
    for i in range(10):
        for j in range(10):
            end = (i + 1, j, 0) if (i + j) % 2 else (i, j + 1, 0)
            model.add(f"r{i}_{j}", vr.Rod.straight((i, j, 0), end, **STEEL, elements=1, order=2))
            model.force(f"r{i}_{j}.end", (0, 0, -1))
            model.clamp(f"r{i}_{j}.start")
    figure = draw_assembly(model)
    assert not any(text.startswith("r") for text in texts(figure))
    assert not any("N" in text for text in texts(figure))


def test_nothing_global_and_no_wrong_model(tmp_path):
    import matplotlib.pyplot as plt

    machine().draw(tmp_path / "new" / "assembly.svg")
    assert plt.get_fignums() == []
    model = machine()
    with pytest.raises(vr.InputError, match="crunk"):
        model.clamp("crunk.start")


def test_check_lists_bodies_joints_springs_and_held_strains():
    report = check(DiscreteModel.of(machine()))
    assert report.bodies == [
        {
            "body": "plate",
            "mass [kg]": 1.0,
            "inertia 1 [kg m2]": pytest.approx((0.04 + 0.0004) / 12),
            "inertia 2 [kg m2]": pytest.approx((0.04 + 0.0004) / 12),
            "inertia 3 [kg m2]": pytest.approx(0.08 / 12),
            "points": "left, right",
        }
    ]
    motor, ball, slide = report.joints
    assert (motor["kind"], motor["free or driven"], motor["gap [m]"]) == ("revolute", "rz(t)", 0.0)
    assert (ball["a - b"], ball["free or driven"], ball["where [m]"]) == (
        "crank.end - arch.start",
        "rx, ry, rz",
        pytest.approx((0.0, 0.3, 0.2), abs=1e-12),
    )
    assert slide["kind"] == "prismatic"
    mount, rope = report.springs
    assert (mount["stiffness [N/m, N m/rad]"], mount["damping [N s/m, N m s/rad]"]) == ("ux 1000", "ux 2")
    assert rope["stiffness [N/m, N m/rad]"] == "100"
    crank = next(row for row in report.sections if row["section"] == "crank@0")
    assert crank["stretch stiffness [N]"] == "held"
    assert crank["stretch time [s]"] == ""
    assert isinstance(crank["twist stiffness [N m2]"], float)
    assert report.conditions > 15
    assert np.all(report.frequencies > 0.0)


def test_check_shows_the_couplings_of_a_section_and_its_mass_centre():
    """A strip whose centre line lies on its face: A, B = A h/2, and nothing where there is no coupling."""
    damping = vr.KelvinVoigt(shear_time=0.01, bulk_time=0.01)
    rubber = vr.Material(1e6, 0.3, 1000.0, damping=damping)
    strip = vr.PolygonSection([(-0.01, 0.0), (0.01, 0.0), (0.01, 0.004), (-0.01, 0.004)], origin="given")
    model = vr.Model()
    model.add("strip", vr.Rod.straight((0, 0, 0), (0.3, 0, 0), section=strip, material=rubber))
    model.add("wire", vr.Rod.straight((0, 1, 0), (0.3, 1, 0), **STEEL))
    model.clamp("strip.start")
    model.clamp("wire.start")
    coupled, plain = check(DiscreteModel.of(model)).sections
    assert coupled["stretch & bend 1 coupling [N m]"] == pytest.approx(1e6 * 8e-5 * 0.002)
    assert coupled["stretch & bend 1 viscous coupling [N m s]"] == pytest.approx(1e4 * 8e-5 * 0.002)
    assert coupled["shear 1 & twist coupling [N m]"] < 0.0
    assert coupled["mass centre [m]"] == "(0, 0.002)"
    assert not [key for key in plain if "coupling" in key or "centre" in key]
    held = vr.Model()
    held.add(
        "strip",
        vr.Rod.straight((0, 0, 0), (0.3, 0, 0), section=strip, material=rubber, constraints="kirchhoff"),
    )
    held.clamp("strip.start")
    assert not [key for key in check(DiscreteModel.of(held)).sections[0] if "coupling" in key]


def test_sections_are_listed_at_the_end_of_a_rod_towards_which_they_change():
    material = STEEL["material"]
    tapered = vr.Taper(vr.Circle(0.02), vr.Circle(0.01))
    model = vr.Model()
    model.add("tapered", vr.Rod.straight((0, 0, 0), (2, 0, 0), section=tapered, material=material))
    model.add("even", vr.Rod.straight((0, 1, 0), (2, 1, 0), section=vr.Circle(0.02), material=material))
    rows = check(DiscreteModel.of(model)).sections
    assert [row["section"] for row in rows] == ["tapered@0", "tapered@2", "even@0"]
    stretch = [row["stretch stiffness [N]"] for row in rows]
    assert stretch[1] == pytest.approx(2e11 * np.pi * 0.01**2)
    assert stretch[0] == pytest.approx(4.0 * stretch[1]) == pytest.approx(stretch[2])


def test_axes_of_the_section_are_listed_at_the_start_of_a_rod():
    # d1 of a rod along x is y without a twist; with one it turns about x
    rod = vr.Rod.straight((0, 0, 0), (1, 0, 0), **STEEL, twist=lambda s: np.pi / 6 + 0.1 * s)
    model = vr.Model()
    model.add("blade", rod)
    (row,) = check(DiscreteModel.of(model)).rods
    assert row["d1 at its start"] == pytest.approx((0.0, np.cos(np.pi / 6), 0.5), abs=1e-9)
    assert row["d2 at its start"] == pytest.approx((0.0, -0.5, np.cos(np.pi / 6)), abs=1e-9)


def test_only_bodies_with_named_points_have_a_row_of_points():
    model = vr.Model()
    model.add("rod", vr.Rod.straight((0, 0, 0), (1, 0, 0), **STEEL))
    model.add("ball", vr.Sphere(radius=0.1, centre=(1, 0, 0), density=1000.0))
    model.attach("rod.end", "ball")
    (row,) = check(DiscreteModel.of(model)).bodies
    assert "points" not in row


def test_rods_of_a_large_frame_that_differ_in_direction_only_are_one_row():
    model = vr.Model()
    for k, angle in enumerate(np.linspace(0.0, 3.0, 20)):
        turned = (0, np.cos(angle), np.sin(angle))
        model.add(f"rod{k}", vr.Rod.straight((0, k, 0), (1, k, 0), **STEEL, d1=turned, elements=1))
        model.clamp(f"rod{k}.start")
    report = check(DiscreteModel.of(model))
    assert len({row["d1 at its start"] for row in report.rods}) > 12  # in the numbers they are all there
    assert "rod0 and 19 more" in report.text(80).partition("Sections")[0]
