"""Draw the pages of docs/howto/view.md, of a motion, of modes and of curves, in a Chromium without a window."""

import importlib
import sys
import tempfile
from pathlib import Path
from typing import Any

import viscorod as vr
from viscorod.analyses.case_run import run_case

ROOT = Path(__file__).parents[2]
IMAGES = ROOT / "docs" / "images"
WITHOUT_VERSION = (
    "(() => { const n = document.getElementById('notes');"
    " n.textContent = n.textContent.split(' \\u00b7 ').filter((t) => !t.startsWith('viscorod')).join(' \\u00b7 '); })()"
)
"""A picture shall not be old because of the number of the version."""


def blade() -> vr.Model:
    """Return a blade of rubber beside the hub that holds it."""
    rubber = vr.Material(2.5e6, 0.45, 1100.0, damping=vr.KelvinVoigt(0.002, 0.002))
    root, tip = (0.1, 0.0, 0.0), (0.5, 0.0, 0.0)
    model = vr.Model()
    section = vr.Rectangle(0.06, 0.02)
    model.add("blade", vr.Rod.straight(root, tip, section=section, material=rubber))
    model.add("hub", vr.Box((0.12, 0.12, 0.12), mass=2.0))
    model.rigid("blade.start", "hub")
    model.clamp("hub")
    return model


def slid(value: str) -> str:
    """Return what moves the slider as a hand does."""
    move = f"s.value = {value}; s.dispatchEvent(new Event('input'))"
    return f"(() => {{ const s = document.getElementById('scrub'); {move}; }})()"


def drawn(browser: Any, folder: Path, result: Any, name: str, size: tuple[int, int], choose: str) -> None:
    """Write the picture of a page after something was chosen on it."""
    browser.open(vr.view(result, folder / f"{name}.html").as_uri(), *size)
    browser.run(choose)
    browser.run(WITHOUT_VERSION)
    browser.drawn()
    browser.picture(IMAGES / f"{name}.png")


def main() -> None:
    """Draw them all."""
    sys.path.insert(0, str(ROOT / "tests"))
    chromium = importlib.import_module("helpers.chromium")
    modes = blade().modes(8, title="A rubber blade on a hub")
    strip = vr.load_case(ROOT / "examples" / "clamped_strip.toml")
    motions = strip.model(vr.Model).periodic(
        inputs="beam@0.2 fz",
        amplitudes=[1.0],
        outputs="beam@0.2 uz",
        frequencies=[90.0, 118.0],
        title=strip.title,
    )
    arm = run_case(vr.load_case(ROOT / "examples" / "soft_arm.toml"))
    print(arm.report(), modes.report(), motions.report(), sep="\n\n")
    bent = next(k for k, name in enumerate(modes.names) if name.startswith("bend") and name.endswith(" 2"))
    still = "document.getElementById('play').click();"
    row = f"document.querySelectorAll('#modes tbody tr')[{bent}].click();{still}" + slid("s.min")
    hertz = motions.frequencies
    upper = slid(str(next(k for k in range(len(hertz) - 1) if hertz[k] > hertz[k + 1])))  # the first fold
    with tempfile.TemporaryDirectory() as place, chromium.opened(Path(place) / "profile") as browser:
        drawn(browser, Path(place), arm, "view", (1360, 990), slid("0"))
        drawn(browser, Path(place), modes, "view_modes", (1400, 780), row)
        drawn(browser, Path(place), motions, "view_periodic", (1200, 1200), upper)


if __name__ == "__main__":
    main()
