"""Every picture is a Matplotlib figure, goes into axes of the user's, and is a file only when asked."""

import matplotlib.pyplot as plt
import numpy as np
import pytest
from matplotlib.figure import Figure

import viscorod as vr
from helpers.synthetic_results import rolled_up, swing
from viscorod.cli.plot_command import KINDS
from viscorod.results.sweep_result import Sweep, SweepRun


@pytest.fixture
def axes():
    figure, panels = plt.subplots(1, 2)
    yield panels
    plt.close(figure)


def beam():
    model = vr.Model()
    section = vr.Rectangle(0.02, 0.002)
    material = vr.Material(70e9, 0.3, 2700.0, damping=vr.KelvinVoigt(1e-4, 1e-4))
    rod = vr.Rod.straight((0, 0, 0), (0.4, 0, 0), section=section, material=material, elements=2, order=3)
    model.add("beam", rod)
    model.clamp("beam.start")
    return model


def a_sweep():
    rows = [(1.0, 2.0), (2.0, 2.0), (3.0, 2.0), (1.0, 5.0), (2.0, 5.0), (3.0, 5.0)]
    members = [
        SweepRun(k, {"a.stiffness": a, "b": b}, quantities={"tip": a * b, "ratio": a + b})
        for k, (a, b) in enumerate(rows)
    ]
    return Sweep([*members, SweepRun(6, {"a.stiffness": 9.0, "b": 9.0}, None, "it failed", "refused")])


def test_values_with_units_are_numbers_in_the_picture_of_a_sweep():
    """In the unit of the first; what all members share stands in no legend, and a missing number takes no place."""
    rows = [("800 kPa", 1.0), ("1 MPa", 2.0), ("1.2 MPa", np.nan)]
    members = [
        SweepRun(k, {"modulus": modulus, "time": time, "duration": 4.0}, quantities={"tip": tip, "top": 1.0})
        for k, (modulus, time, tip) in enumerate((m, t, tip) for t in ("10 ms", "20 ms") for m, tip in rows)
    ]
    axes = Sweep(members).plot().axes[0]
    assert axes.get_xlabel() == "modulus [kPa]"
    assert [line.get_label() for line in axes.lines] == ["time = 10 ms", "time = 20 ms"]
    for line in axes.lines:
        assert np.asarray(line.get_xdata(), dtype=float) == pytest.approx([800.0, 1000.0, 1200.0], rel=1e-12)
        assert line.get_linestyle() == "-"
    words = Sweep([SweepRun(k, {"a": a}, quantities={"tip": 1.0}) for k, a in enumerate(["1 of", "2 of"])])
    assert words.plot().axes[0].get_xlabel() == "a"


def drawings():
    """Pictures by name: a method, and what is drawn first into axes."""
    run, held, model = vr.Run(swing()), vr.Equilibrium(rolled_up()), beam()
    modes = model.modes(3)
    shaken = model.frequency_response(inputs="base uz", outputs="beam.end uz", band=(5.0, 60.0))
    model.force("beam.end", (-1.0, 0, 0))
    return {
        "plot": run.plot,
        **{
            f"plot_{kind.replace('-', '_')}": getattr(run, f"plot_{kind.replace('-', '_')}")
            for kind in KINDS
            if kind != "modes"
        },
        "equilibrium": held.plot,
        "modes": modes.plot,
        "response": shaken.plot,
        "nyquist": lambda path=None, **more: shaken.plot(path, "nyquist", **more),
        "buckling": model.buckling(count=1).plot,
        "model": model.draw,
        "sweep": a_sweep().plot,
        "fit": vr.kelvin_voigt_fit(
            vr.RelaxationModulus(1e6, [1e5], [0.1]),
            (1, 100),
        ).plot,
    }


def test_a_picture_is_a_figure_of_its_own_or_goes_into_axes(axes, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name, draw in drawings().items():
        known = plt.get_fignums()
        figure = draw()
        assert isinstance(figure, Figure), name
        assert figure._repr_png_().startswith(b"\x89PNG"), name
        assert plt.get_fignums() == known, f"{name} is no figure of pyplot"
        axes[1].clear()
        before = len(axes[0].figure.axes)
        assert draw(ax=axes[1]) is axes[1].figure, name
        drawn = [*axes[1].lines, *axes[1].collections, *axes[1].patches, *axes[1].images]
        assert drawn, name
        assert axes[1].get_xlabel(), name
        assert axes[1].get_ylabel(), name
        assert not axes[0].has_data(), name
        for bar in axes[0].figure.axes[before:]:
            bar.remove()
    assert list(tmp_path.iterdir()) == []


def test_a_picture_goes_into_a_panel_of_a_subfigure():
    figure = plt.figure()
    panel = figure.subfigures(1, 2)[1].subplots()
    assert vr.Run(swing()).plot(ax=panel) is figure
    plt.close(figure)


def test_one_mode_alone_is_drawn(axes):
    modes = beam().modes(3)
    modes.plot(number=2, ax=axes[0])
    assert axes[0].get_title(loc="left").startswith("2: ") or axes[0].get_title().startswith("2: ")
    assert len(modes.plot(count=2).axes) == 2
    assert len(modes.plot(number=3).axes) == 1
    for wrong in ({"number": 4}, {"number": 0}, {"count": -1}, {"number": True}, {"count": "two"}):
        with pytest.raises(vr.InputError, match=r"number|count"):
            modes.plot(**wrong)


@pytest.mark.parametrize("wrong", ["here", 3, [1, 2]])
def test_what_is_no_panel_is_refused(wrong):
    with pytest.raises(vr.InputError, match="axes are needed"):
        vr.Run(swing()).plot(ax=wrong)


def test_all_panels_at_once_are_refused(axes):
    with pytest.raises(vr.InputError, match="give one panel"):
        vr.Run(swing()).plot(ax=axes)


def test_a_sweep_over_lists_is_drawn():
    """Places, as in ``rods.beam.end``: a line for each, and texts along the axis."""
    ends = [[0.2, 0, 0], [0.3, 0, 0]]
    members = [
        SweepRun(k, {"a": a, "end": end}, quantities={"tip": a * end[0]})
        for k, (a, end) in enumerate((a, end) for a in (1.0, 2.0) for end in ends)
    ]
    lines = Sweep(members).plot().axes[0].lines
    for line, end in zip(lines, ends, strict=True):
        np.testing.assert_array_equal(line.get_ydata(), [end[0], 2.0 * end[0]])
        assert str(end) in line.get_label()
    assert len(Sweep(members).plot(x="end").axes[0].lines) == 2


def test_a_sweep_is_drawn_over_its_parameters(axes):
    """The numbers stand where the members are: tip = a b, a line for every b; the one that failed is left out."""
    found = a_sweep()
    found.plot(ax=axes[0])
    for line, b in zip(axes[0].lines, (2.0, 5.0), strict=True):
        np.testing.assert_array_equal(line.get_xdata(), [1.0, 2.0, 3.0])
        np.testing.assert_array_equal(line.get_ydata(), b * np.array([1.0, 2.0, 3.0]))
    found.plot(x="b", name="ratio", ax=axes[1])
    assert axes[1].get_xlabel() == "b"
    assert axes[1].get_ylabel() == "ratio"
    assert len(axes[1].lines) == 3
    assert len(found.plot().axes) == 2
    with pytest.raises(vr.InputError, match="did you mean 'ratio'"):
        found.plot(name="ratios")
    with pytest.raises(vr.InputError, match=r"it has a\.stiffness, b"):
        found.plot(x="c")
