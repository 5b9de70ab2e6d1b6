"""Arguments that would be ignored, numbers that are none, and models that nothing holds are refused by name."""

import numpy as np
import pytest

import viscorod as vr


def bar(*, held: bool = True) -> vr.Model:
    """Return a short bar."""
    damping = vr.KelvinVoigt(shear_time=1e-5, bulk_time=1e-5)
    steel = vr.Material(2.1e11, 0.3, 7850.0, damping=damping)
    model = vr.Model()
    rod = vr.Rod.straight((0, 0, 0), (1, 0, 0), section=vr.Circle(0.01), material=steel, elements=1)
    model.add("bar", rod)
    if held:
        model.clamp("bar.start")
        model.force("bar.end", (-1.0, 0, 0))
    return model


def test_a_tolerance_of_given_frequencies_is_refused() -> None:
    with pytest.raises(vr.InputError, match=r"tolerance: 0\.001: .*leave it out, or give a band"):
        bar().frequency_response("bar.end fz", "bar.end uz", frequencies=[1.0], tolerance=1e-3)


def test_a_count_of_given_values_is_refused() -> None:
    with pytest.raises(vr.InputError, match="count: 5: speeds that are given"):
        bar().campbell(axis=(1, 0, 0), speeds=[1.0, 2.0], count=5)
    with pytest.raises(vr.InputError, match="count: 5: load factors that are given"):
        bar().stability(load_factors=[1.0, 2.0], count=5)


@pytest.mark.parametrize("wrong", [-1.0, float("nan"), float("inf")])
def test_responses_of_a_linear_system_have_frequencies(wrong: float) -> None:
    system = bar().linear("bar.end fz", "bar.end uz")
    with pytest.raises(vr.InputError, match="finite numbers >= 0"):
        system.response([1.0, wrong])
    small = system.reduced("modal", 2, band=(1.0, 10.0))
    with pytest.raises(vr.InputError, match="finite numbers >= 0"):
        small.response(np.array([wrong]))


def test_periodic_motions_have_a_place_to_swing_about() -> None:
    message = "nothing holds the model against translation along x"
    with pytest.raises(vr.InputError, match=message):
        bar(held=False).periodic(
            inputs="bar.end fz", amplitudes=[1.0], outputs="bar.end uz", frequencies=[10.0, 20.0]
        )
    with pytest.raises(vr.InputError, match=message):
        bar(held=False).periodic(mode=1, largest=1e-3, outputs="bar.end uz")
