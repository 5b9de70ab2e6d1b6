"""The page on choosing damping: what it says that `viscorod check` prints is what it prints."""

import pytest
from typer.testing import CliRunner

from viscorod.cli.app import app

from .test_examples import ROOT, blocks, write_tables

PAGE = ROOT / "docs" / "howto" / "choose_damping.md"
CASES = dict(zip(("rubber", "steel", "polymer", "blade"), blocks(PAGE, "toml"), strict=True))
SAID = dict(zip(CASES, blocks(PAGE, "text"), strict=True))


@pytest.mark.parametrize("name", CASES)
def test_check_says_what_the_page_shows(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "100")
    write_tables(PAGE, tmp_path)
    (tmp_path / "case.toml").write_text(CASES[name])
    result = CliRunner().invoke(app, ["check", "case.toml"])
    assert result.exit_code == 0, result.output
    printed = [" ".join(line.split()) for line in result.output.splitlines()]
    assert SAID[name].strip()
    for line in SAID[name].splitlines():
        assert " ".join(line.split()) in printed
