"""The page "Damping over frequency": damping ratios of its blades against closed forms of the complex modulus."""

import importlib.util
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).parents[2]
_spec = importlib.util.spec_from_file_location(
    "damping_over_frequency", ROOT / "docs" / "figures" / "damping_over_frequency.py"
)
assert _spec is not None
figure = importlib.util.module_from_spec(_spec)
PAGE = ROOT / "docs" / "explanation" / "damping_over_frequency.md"


@pytest.fixture(scope="module", autouse=True)
def loaded():
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(str(ROOT / "docs" / "figures"))  # scripts share how pictures look
        _spec.loader.exec_module(figure)


def row(title, name):
    """Return the damping ratios and frequencies that the page has."""
    table = PAGE.read_text(encoding="utf-8").split(f"| {title} |")[1].split("\n\n")[0]
    cells = next(line for line in table.splitlines() if line.startswith(f"| {name} |")).split("|")[2:-1]
    pairs = [cell.split("% at") for cell in cells if "%" in cell]
    return np.array([[float(ratio), float(hertz.strip().removesuffix(" Hz"))] for ratio, hertz in pairs]).T


def test_steel():
    """Kelvin-Voigt: omega tau/2 with the undamped frequency; Zener: half the loss factor of his closed form."""
    blade = figure.steel()
    hertz, ratios = figure.bending(blade.models["Kelvin-Voigt"], blade.band)
    np.testing.assert_allclose(ratios / ratios[0], hertz / hertz[0], rtol=1e-6)
    _, flat = figure.bending(blade.models["flat loss"], blade.band)
    np.testing.assert_allclose(flat, flat[0], rtol=1e-9)
    hertz, ratios = figure.bending(blade.models["measured"], blade.band)
    strength = 2.1e11 * 1.2e-5**2 * 293.0 / (7850.0 * 470.0)
    x = 2 * np.pi * hertz * 0.002**2 * 7850.0 * 470.0 / (np.pi**2 * 45.0)
    np.testing.assert_allclose(ratios, 0.5 * strength * x / (1 + x**2), rtol=3e-3)
    told = row(blade.title, "Zener")
    np.testing.assert_allclose(told, [100 * ratios, hertz], rtol=6e-3)


def test_silicone():
    """A power law has the same phase at all frequencies: zeta = sin(0.04 pi/2); flat loss sin(atan(eta)/2)."""
    blade = figure.silicone()
    hertz, ratios = figure.bending(blade.models["measured"], blade.band)
    np.testing.assert_allclose(ratios, np.sin(0.02 * np.pi), rtol=1e-3)
    flat, damping = figure.bending(blade.models["flat loss"], blade.band)
    np.testing.assert_allclose(damping, np.sin(0.5 * np.arctan(2 * ratios[0])), rtol=1e-3)
    # the modulus rises as f^0.08 and frequencies as its root, so they are those of flat loss to the power 1/(1 - 0.04)
    np.testing.assert_allclose(hertz / hertz[0], (flat / flat[0]) ** (1 / 0.96), rtol=2e-3)
    np.testing.assert_allclose(row(blade.title, "measured"), [100 * ratios, hertz], rtol=6e-3)
    np.testing.assert_allclose(row(blade.title, "flat loss"), [100 * damping, flat], rtol=6e-3)
