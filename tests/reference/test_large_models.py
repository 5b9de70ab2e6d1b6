"""Ten thousand elements, hundreds of rods: right to closed forms, with effort and memory in proportion."""

from __future__ import annotations

import tracemalloc
from collections.abc import Callable

import numpy as np
import pytest
from scipy import sparse
from scipy.optimize import brentq

import viscorod as vr
from viscorod.analyses.check import check
from viscorod.analyses.discrete import DiscreteModel
from viscorod.pictures.plots.projection_view import Curves
from viscorod.solve.constraints.parts import jointed_parts
from viscorod.solve.constraints.rigid_motions import free_motions
from viscorod.solve.constraints.undetermined_motions import undetermined, undetermined_of_many
from viscorod.solve.formulations.system import State
from viscorod.solve.linear.sparse_lu import SparseLU
from viscorod.solve.modes import undamped
from viscorod.solve.modes.vibrations import complex_modes, linearise

MODULUS, DENSITY, G = 2e11, 7850.0, 9.81
STEEL = vr.Material(MODULUS, poissons_ratio=0.3, density=DENSITY, damping=vr.KelvinVoigt(1e-4, 1e-4))
FINEST = 10_000
"""Elements of the largest rods."""


def wire(length: float, radius: float, elements: int, order: int, direction: str = "x") -> vr.Model:
    """Return a steel wire from the origin along an axis."""
    end = np.where(np.array(list("xyz")) == direction, length, 0.0)
    model = vr.Model()
    rod = vr.Rod.straight(
        (0, 0, 0), end, section=vr.Circle(radius), material=STEEL, elements=elements, order=order
    )
    model.add("wire", rod)
    return model


def test_a_long_hanging_wire_of_ten_thousand_elements_stretches_by_its_weight() -> None:
    """Elongation of a bar under its weight, ``rho g L^2 / (2 E)``, and its tension at the upper end."""
    model = wire(500.0, 0.005, FINEST, 1, "z")
    model.clamp("wire.start")
    model.gravity((0.0, 0.0, G))
    found = model.equilibrium()
    exact = DENSITY * G * 500.0**2 / (2.0 * MODULUS)
    assert found.displacement("wire.end")[2] == pytest.approx(exact, rel=1e-9)
    weight = DENSITY * G * np.pi * 0.005**2 * 500.0
    assert float(found.reactions[0, 2]) == pytest.approx(-weight, rel=1e-9)
    assert found.stable


def test_a_cable_of_ten_thousand_elements_is_the_elastic_catenary() -> None:
    """Sag and tension of Irvine's elastic catenary (Cable Structures, 1981, eqs. 1.33 to 1.36).

    The wire is 50 000 times longer than thick; its bending stiffness matters within a few centimetres of the pins only.
    """
    length, radius = 500.0, 0.005
    model = wire(length, radius, FINEST, 1)
    model.pin("wire.start")
    model.pin("wire.end")
    model.gravity((0.0, 0.0, -G))
    found = model.equilibrium()

    w, stiffness = DENSITY * G * np.pi * radius**2, MODULUS * np.pi * radius**2
    up = 0.5 * w * length

    def span(tension: float) -> float:
        return tension * length / stiffness + 2.0 * tension / w * np.arcsinh(up / tension)

    tension = float(brentq(lambda h: span(h) - length, 1e2, 1e6, xtol=1e-9, rtol=1e-14))
    sag = up * length / (4.0 * stiffness) + tension / w * (np.sqrt(1.0 + (up / tension) ** 2) - 1.0)
    assert found.displacement("wire@250")[2] == pytest.approx(-sag, rel=2e-7)
    assert np.abs(found.reactions.values[0, :3]) == pytest.approx([tension, 0.0, up], rel=1e-6, abs=1e-6 * up)


def test_modes_of_ten_thousand_elements_keep_their_digits(caplog) -> None:
    """Euler-Bernoulli cantilever, 200 times longer than thick; Timoshenko's correction there is 1e-4.

    The rounding of the stiffness would leave three digits of the first mode, as that of bending grows with the fourth
    power of its waves; the work of its shape, summed up from strains, leaves as many as with 100 elements.
    """

    def frequencies(elements: int) -> np.ndarray:
        model = wire(1.0, 0.0025, elements, 2)
        model.clamp("wire.start")
        return check(DiscreteModel.of(model)).frequencies

    beam = np.repeat([1.8751040687, 4.6940911330, 7.8547574382], 2) ** 2
    exact = beam / (2.0 * np.pi) * np.sqrt(MODULUS * 0.0025**2 / (4.0 * DENSITY))
    coarse = frequencies(100)
    assert not caplog.messages
    fine = frequencies(FINEST)
    assert any("vibrations of 20001 nodes" in message for message in caplog.messages)  # it takes seconds
    assert coarse == pytest.approx(exact, rel=1e-3)
    assert fine == pytest.approx(coarse, rel=1e-6)


@pytest.mark.parametrize(("elements", "order"), [(30, 3), (1000, 1), (1000, 3)])
def test_slow_motions_are_found_beside_stretch_that_is_1e13_times_as_stiff(elements: int, order: int) -> None:
    """Euler-Bernoulli cantilever, 50 000 times longer than thick, and the damping of its material, w tau/2."""
    delay = 1e-3
    material = vr.Material(MODULUS, poissons_ratio=0.3, density=DENSITY, damping=vr.KelvinVoigt(delay, delay))
    section = vr.Circle(0.005)
    model = vr.Model()
    rod = vr.Rod.straight(
        (0, 0, 0), (500, 0, 0), section=section, material=material, elements=elements, order=order
    )
    model.add("wire", rod)
    model.clamp("wire.start")
    modes = model.modes(4)
    beam = np.repeat([1.8751040687, 4.6940911330], 2) ** 2
    exact = beam / 500.0**2 * np.sqrt(MODULUS * 0.005**2 / (4.0 * DENSITY))
    assert 2.0 * np.pi * np.asarray(modes.frequencies) == pytest.approx(exact, rel=2e-6)
    assert np.asarray(modes.damping_ratios) == pytest.approx(0.5 * exact * delay, rel=2e-6)


@pytest.mark.parametrize(("part", "unstable"), [(0.97, 0), (1.03, 2)])
@pytest.mark.parametrize(("elements", "order"), [(1000, 1), (1000, 3)])
def test_round_off_makes_no_strut_unstable(elements: int, order: int, part: float, unstable: int) -> None:
    """Euler's load of a cantilever 50 000 times longer than thick, pi^2 EI/(4 L^2); it buckles to both sides."""
    model = wire(500.0, 0.005, elements, order)
    model.clamp("wire.start")
    bending = MODULUS * np.pi * 0.005**4 / 4.0
    model.force("wire.end", (-part * np.pi**2 * bending / (4.0 * 500.0**2), 0, 0))
    assert model.equilibrium(search=False).negative_eigenvalues == unstable


def stiffness_of(elements: int, radius: float) -> sparse.csr_array:
    model = wire(500.0, radius, elements, 3)
    model.clamp("wire.start")
    discrete = DiscreteModel.of(model)
    return linearise(discrete.static, State.reference(discrete.problem), scale=0.0).stiffness


@pytest.mark.parametrize("radius", [0.005, 5.0])
def test_factors_fill_in_proportion_to_the_elements(radius: float) -> None:
    """Rows that are scaled keep their pivots on the diagonal: a wire's factors are as sparse as a thick beam's."""
    small, large = (stiffness_of(elements, radius) for elements in (200, 800))
    assert SparseLU(large).nonzeros < 4.1 * SparseLU(small).nonzeros
    lu, x = SparseLU(large), np.random.default_rng(3).standard_normal(large.shape[0])
    b = large @ x
    size = abs(large) @ np.abs(lu.solve(b)) + np.abs(b)
    assert np.abs(large @ lu.solve(b) - b).max() <= 1e-12 * size.max()


def test_scaled_factors_solve_with_conditions_and_complex_matrices() -> None:
    """Rows without a diagonal, as those of conditions, are scaled too; solutions are those of full matrices."""
    random = np.random.default_rng(5)
    a = random.standard_normal((30, 30))
    stiff = a @ a.T + 1e9 * np.diag(np.arange(30) % 2)
    held = 1e-6 * random.standard_normal((4, 30))
    matrix = np.block([[stiff, held.T], [held, np.zeros((4, 4))]])
    b = random.standard_normal((34, 2))
    assert SparseLU(matrix).solve(b) == pytest.approx(np.linalg.solve(matrix, b), rel=1e-6)
    shifted = stiff + 1j * np.diag(np.arange(1.0, 31.0))
    assert SparseLU(shifted).solve(b[:30] + 0j) == pytest.approx(np.linalg.solve(shifted, b[:30]), rel=1e-8)
    with pytest.raises(RuntimeError):
        SparseLU(np.zeros((3, 3)))


def peak(run: Callable[[], object]) -> int:
    """Return the largest memory [bytes] that numpy and Python hold while something runs."""
    run()
    tracemalloc.start()
    try:
        run()
        return tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()


def cantilevers(count: int) -> vr.Model:
    """Return equal cantilevers beside each other."""
    model = vr.Model()
    for k in range(count):
        rod = vr.Rod.straight(
            (0, 0.1 * k, 0), (0.1, 0.1 * k, 0), section=vr.Circle(0.005), material=STEEL, elements=1, order=2
        )
        model.add(f"rod{k}", rod)
        model.clamp(f"rod{k}.start")
    model.gravity()
    return model


def long_wire(elements: int) -> vr.Model:
    model = wire(500.0, 0.5, elements, 2, "z")
    model.clamp("wire.start")
    model.gravity((1.0, 0.0, G))
    return model


@pytest.mark.parametrize(("make", "small"), [(long_wire, 1600), (cantilevers, 30)])
@pytest.mark.parametrize("analysis", ["check", "equilibrium"])
def test_memory_of_checks_and_equilibria_is_in_proportion(
    make: Callable[[int], vr.Model], small: int, analysis: str
) -> None:
    """Four times the elements, or rods, take four times the memory: nothing is a full matrix."""

    def used(count: int) -> int:
        model = make(count)
        if analysis == "check":
            return peak(lambda: check(DiscreteModel.of(model)))
        return peak(model.equilibrium)

    assert used(4 * small) < 4.6 * used(small)


def test_pictures_of_long_rods_take_memory_in_proportion() -> None:
    """Drawn points are weights of some stations each, and no more of them than a picture can show."""
    small, large = (long_wire(elements).equilibrium() for elements in (400, 1600))

    def points(result: vr.Equilibrium) -> int:
        curves = Curves(result)
        return sum(len(curve) for curve in curves._rods(result.field("position")[-1]))

    assert peak(lambda: points(large)) < 4.6 * peak(lambda: points(small))
    stations = int(large.data.sizes["station"])
    assert stations <= points(large) <= 50_000
    # the last one is the tip itself
    tip = list(Curves(large)._rods(large.field("position")[-1]))[-1][-1]
    assert tip == pytest.approx(large.position("wire.end"), abs=1e-12)


def test_a_page_of_a_long_rod_reads_few_stations_of_it(tmp_path) -> None:
    """A page shows 400 stations, says so, and holds no weights of the others."""
    result = long_wire(1600).equilibrium()
    used = peak(lambda: vr.view(result, tmp_path / "view.html"))
    assert "400 stations shown of 3201" in (tmp_path / "view.html").read_text(encoding="utf-8")
    assert used < 12e6 + 400 * 3201  # weights of all stations alone would take eight times the latter


def test_many_equal_rods_have_the_modes_of_one(monkeypatch) -> None:
    """Of 240 modes with one frequency only those asked for are sought, and it is proven that none is slower."""
    searches = []
    lanczos = undamped._lanczos

    def counted(*arguments):
        searches.append(arguments[3])
        return lanczos(*arguments)

    monkeypatch.setattr(undamped, "_lanczos", counted)

    def modes_of(count: int) -> tuple[np.ndarray, bool]:
        discrete = DiscreteModel.of(cantilevers(count))
        state = State.reference(discrete.problem)
        found = complex_modes(
            discrete.static, state, linearise(discrete.static, state, scale=0.0), 6 if count > 1 else 2
        )
        return found.frequencies, found.certified

    (one, _), (all_, certified) = modes_of(1), modes_of(120)
    assert all_ == pytest.approx(np.repeat(one[0], 6), rel=1e-9)
    assert certified
    assert sum(searches) < 40


def hanging_chain(
    count: int, kind: str, gravity: tuple[float, float, float] | None, *, held: bool = True
) -> vr.Model:
    """Return rods of 0.1 m, each joined to the one above."""
    model = vr.Model()
    for k in range(count):
        rod = vr.Rod.straight(
            (0, 0, -0.1 * k),
            (0, 0, -0.1 * k - 0.1),
            section=vr.Circle(0.005),
            material=STEEL,
            elements=1,
            order=2,
        )
        model.add(f"rod{k}", rod)
        if k:
            axis = {"axis": (0, 1, 0)} if kind == "revolute" else {}
            model.joint(kind, f"rod{k - 1}.end", f"rod{k}.start", **axis)
    if held:
        model.pin("rod0.start")
    if gravity is not None:
        model.gravity(gravity)
    return model


def test_a_chain_of_many_rods_hangs_along_gravity() -> None:
    """A chain of 300 ball joints turns to where its weight pulls, and is longer by ``rho g L^2 / (2 E)``.

    No full matrix of its 900 free motions is made: they are not found one by one.
    """
    model = hanging_chain(300, "ball", (3.0, 0.0, -4.0))
    assert jointed_parts(DiscreteModel.of(model).problem) == 300
    found = model.equilibrium()
    length = 30.0 * (1.0 + DENSITY * 5.0 * 30.0 / (2.0 * MODULUS))
    assert found.position("rod299.end") == pytest.approx([0.6 * length, 0.0, -0.8 * length], abs=1e-9)


def test_a_check_of_many_joined_parts_says_what_it_leaves_out() -> None:
    model = hanging_chain(200, "ball", (0.0, 0.0, -G))
    report = check(DiscreteModel.of(model))
    assert len(report.frequencies) == 0
    assert any("200 parts are joined" in warning for warning in report.warnings)


@pytest.mark.parametrize("kind", ["revolute", "ball"])
def test_a_hanging_chain_of_many_rods_swings_as_bessel_has_it(kind: str) -> None:
    """Swinging of a hanging chain, ``2 w sqrt(L / g) = j_0n`` (Bernoulli 1733, Bessel functions).

    On balls every rod may spin as well, and the chain swings to both sides.
    """
    found = hanging_chain(150, kind, (0.0, 0.0, -G)).modes(6, oscillating=True)
    assert all(name.startswith("swing") for name in found.names[:2])
    sizes = np.abs(found.shapes).max(axis=1)
    swings = found.frequencies[(kind == "ball") | (sizes[:, 0] > sizes[:, 1])]  # hinges turn about y
    exact = np.array([2.40482556, 5.52007811]) / (4.0 * np.pi) * np.sqrt(G / 15.0)
    each = 2 if kind == "ball" else 1
    assert swings[: 2 * each] == pytest.approx(np.repeat(exact, each), rel=2.5e-4)


@pytest.mark.parametrize(
    ("kind", "gravity", "held"),
    [
        ("ball", (0.0, 0.0, -G), True),
        ("revolute", (0.0, 0.0, -G), True),
        ("revolute", (1.0, 0.0, 0.0), True),
        ("revolute", None, True),
        ("revolute", (0.0, 0.0, -G), False),
        ("rigid", (0.0, 0.0, -G), True),
        ("universal", (0.0, 0.0, -G), True),
    ],
)
def test_what_many_parts_leave_undetermined_is_what_single_motions_say(
    kind: str, gravity: tuple[float, float, float] | None, held: bool
) -> None:
    """The same verdict from sparse factors as from all free motions one by one, or none."""
    if kind == "universal":
        model = hanging_chain(4, "revolute", gravity, held=held)
        model.spring("rod3.end", None, stiffness={"ux": 10.0, "rz": 1.0})
    else:
        model = hanging_chain(4, kind, gravity, held=held)
    discrete = DiscreteModel.of(model)
    problem, system = discrete.problem, discrete.system
    system.assemble(State.reference(problem), discrete.static.loads.at(0.0), None, tangent=True, moving=False)
    size = 6 * problem.size
    stiffness = system.matrix.sparse()[:size, :size]
    found = undetermined_of_many(problem, system.external, stiffness)
    single = undetermined(problem, system.external, stiffness, free_motions(problem))
    if found is None:  # nothing pulls, or a translation is free
        assert single
        assert gravity is None or not held
    else:
        assert bool(found) == bool(single)
