"""The tutorial is true: its commands run, in their order, and print what the page shows."""

from __future__ import annotations

import re
import shlex

import pytest
from typer.testing import CliRunner

from viscorod.cli.app import app

from .test_examples import ROOT

PAGE = (ROOT / "docs" / "tutorial" / "cantilever_swing.md").read_text(encoding="utf-8")
CHANGING = (
    "Effort:",
    "numerical remainder",
    "largest numerical",
    "Linear systems:",
    "Smallest step:",
    "Steps:",
)
COUNTS = re.compile(r"simulated in \d+ steps")
"""What depends on the machine's last digits or its speed."""


@pytest.fixture(scope="module")
def printed(tmp_path_factory):
    """What the commands of the page printed, by command, run one after the other in one folder."""
    folder = tmp_path_factory.mktemp("tutorial")
    (case,) = re.findall(r"^```toml\n(.*?)^```", PAGE, re.DOTALL | re.MULTILINE)
    (folder / "my_rod.toml").write_text(case)
    commands = ["viscorod example cantilever_swing", *re.findall(r"^\$ (viscorod .*)$", PAGE, re.MULTILINE)]
    texts = {}
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        patch.setenv("COLUMNS", "120")
        for command in commands:
            words = shlex.split(command)[1:]
            result = CliRunner().invoke(app, [*words, "--workers", "1"] if words[0] == "sweep" else words)
            assert result.exit_code == 0, (command, result.output)
            texts[command] = result.output
        texts["files"] = {path.relative_to(folder).as_posix() for path in folder.rglob("*.*")}
    return texts


def shown():
    """Pairs of a command and the text that the page shows as its output."""
    parts = re.split(r"^```(console|text)\n(.*?)^```", PAGE, flags=re.DOTALL | re.MULTILINE)
    command, pairs = "", []
    for kind, text in zip(parts[1::3], parts[2::3], strict=True):
        if kind == "console":
            command = text.strip().removeprefix("$ ")
        else:
            pairs.append((command, text))
    return pairs


def same(line, other):
    """Whether two lines agree: words exactly, numbers to 1e-3."""
    words, others = line.split(), other.split()
    return len(words) == len(others) and all(map(agree, words, others))


def agree(word, other):
    try:
        return float(word) == pytest.approx(float(other), rel=1e-3, abs=2e-6)
    except ValueError:
        return word == other


@pytest.mark.parametrize(("command", "text"), shown(), ids=lambda value: value.split("\n")[0][:40])
def test_command_prints_what_the_page_shows(command, text, printed):
    lines = [COUNTS.sub("simulated in N steps", line) for line in printed[command].splitlines()]
    # a paragraph begins at the margin, its further lines are indented
    text = re.sub(rf"^\s*(?:{'|'.join(CHANGING)}).*\n(?:(?<=[^\n]\n)  .*\n)*", "", text, flags=re.MULTILINE)
    wanted = [line for line in text.splitlines() if line.strip()]
    assert wanted
    for line in wanted:
        expected = COUNTS.sub("simulated in N steps", line)
        assert any(same(expected, found) for found in lines), line


def test_commands_write_the_files_that_the_page_names(printed):
    for name in ("cantilever_swing/run.nc", "cantilever_swing/motion.png", "cantilever_swing/energy.png"):
        assert f"out/{name}" in printed["files"]
    assert "out/my_rod/motion.png" in printed["files"]


def test_numbers_done_by_hand():
    """The page's arithmetic: frequency and damping ratio of the nylon rod, closed forms of Euler and Bernoulli."""
    radius, length, modulus, density = 0.0025, 0.4, 2.5e9, 1140.0
    omega = 1.8751040687**2 / length**2 * (modulus / density) ** 0.5 * radius / 2
    time = 0.05 / (2 * 3.141592653589793 * 10.0)
    assert omega / (2 * 3.141592653589793) == pytest.approx(6.473, abs=2e-3)
    assert omega * time / 2 == pytest.approx(0.0162, abs=5e-5)
