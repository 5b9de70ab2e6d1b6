"""What the user is shown runs: the shipped cases in full, and every piece of Python and TOML in the documents."""

import importlib
import re
import shutil
import sys
import warnings
from pathlib import Path
from unittest.mock import patch

import pytest

import viscorod as vr
from helpers.measured_files import write_files
from viscorod.analyses.case_run import run_case
from viscorod.casefile.analysis_tables import ANALYSES
from viscorod.casefile.case import load_case
from viscorod.casefile.shipped import shipped_cases
from viscorod.solve.transient.integrators import INTEGRATORS

ROOT = Path(__file__).parents[2]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
MEASURED = ("records", "measurements")
"""Pages that read the reader's own measurements."""
CASE_FILE = ROOT / "docs" / "reference" / "case_file.md"


def blocks(page, language):
    """The code blocks of a page in a language."""
    return re.findall(
        rf"^```{language}\n(.*?)^```", page.read_text(encoding="utf-8"), re.DOTALL | re.MULTILINE
    )


def write_tables(page, folder):
    """Write the tables that a page shows, each under the name in its first line."""
    for text in blocks(page, "none"):
        (folder / text.partition("\n")[0].lstrip("# ")).write_text(text)


@pytest.fixture(scope="module")
def results():
    """Results of the shipped cases, computed once each."""
    known = {}

    def result(name):
        if name not in known:
            known[name] = run_case(load_case(shipped_cases()[name]))
        return known[name]

    return result


@pytest.fixture(scope="module")
def saved(results, tmp_path_factory):
    """The folder with the results that pages about results start from."""
    folder = tmp_path_factory.mktemp("saved")
    for name in ("cantilever_swing", "soft_arm"):
        results(name).save(folder / "out" / name / "run.nc")
    return folder / "out"


def test_page_of_the_soft_arm_is_as_large_as_the_document_says(results, tmp_path):
    said = re.search(
        r"run\.html \(([\d.]+) MB\)", (ROOT / "docs" / "howto" / "view.md").read_text(encoding="utf-8")
    )
    size = vr.view(results("soft_arm"), tmp_path / "run.html").stat().st_size
    assert float(said[1]) == pytest.approx(size / 1e6, abs=0.1)


@pytest.mark.parametrize(
    "page", [page for page in PAGES if blocks(page, "python")], ids=lambda page: page.stem
)
def test_python_in_documents_runs(page, saved, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    write_tables(page, tmp_path)
    shutil.copytree(saved, tmp_path / "out")
    (tmp_path / "cantilever_swing.toml").write_bytes(shipped_cases()["cantilever_swing"].read_bytes())
    if page.stem in MEASURED:
        write_files(tmp_path)
    names = {"__name__": "__main__"}  # a page is read from top to bottom
    with patch.dict(INTEGRATORS):  # one page adds an integrator
        for code in blocks(page, "python"):
            exec(compile(code, str(page), "exec"), names)
    if "matplotlib.pyplot" in sys.modules:  # pandas leaves its pictures there
        sys.modules["matplotlib.pyplot"].close("all")


QUOTED = {
    "howto/choose_mesh.md": ("cantilever_swing",),
    "howto/choose_integrator.md": ("cantilever_swing", "helix_spring"),
}
"""Pages that quote reports, and the shipped cases whose reports they are, in their order."""
ROUNDED = 2.0
"""Largest ratio of an estimate that is told with one digit to that of another machine."""


@pytest.mark.parametrize(("page", "names"), QUOTED.items(), ids=str)
def test_pages_quote_what_reports_say(page, names, results):
    quoted = blocks(ROOT / "docs" / page, "text")
    assert len(quoted) == len(names)
    for text, name in zip(quoted, names, strict=True):
        wanted, printed = text.split(), results(name).report().split()
        first = printed.index(wanted[0])
        assert alike(wanted, printed[first : first + len(wanted)], ROUNDED), text


def test_the_account_that_its_page_quotes(monkeypatch):
    """To 1e-3 of what moved, beside which the remainder and what is still in motion are rounding of the steps."""
    monkeypatch.syspath_prepend(str(ROOT / "docs" / "figures"))
    account = importlib.import_module("energy_account").strip().simulate(4.0).energy
    (text,) = blocks(ROOT / "docs" / "explanation" / "energy_account.md", "text")
    printed, quoted = str(account).split(), text.split()
    assert len(printed) == len(quoted)
    for word, other, unit in zip(printed, quoted, [*quoted[1:], ""], strict=True):
        if word != other:
            moved = 100.0 if unit == "%" else account.moved
            assert float(word) == pytest.approx(float(other), abs=1e-3 * moved), (word, other)


def alike(words, others, ratio):
    """Whether texts are the same, but for numbers whose ratio is less than that."""
    for word, other in zip(words, others, strict=True):
        if word == other:
            continue
        try:
            found = abs(float(word) / float(other))
        except ValueError:
            return False
        if not 1.0 / ratio <= found <= ratio:
            return False
    return True


def run_cells(page):
    """Run the cells of a page as a notebook does, in the present folder."""
    names = {"__name__": "__main__"}
    for code in blocks(page, r"\{code-cell\} ipython3"):
        if code.startswith("!viscorod example "):
            name = code.split()[-1]
            Path(f"{name}.toml").write_bytes(shipped_cases()[name].read_bytes())
            continue
        exec(compile(code, str(page), "exec"), names)
    if "matplotlib.pyplot" in sys.modules:
        sys.modules["matplotlib.pyplot"].close("all")


@pytest.mark.parametrize(
    "page", [page for page in PAGES if page.parent.name == "notebooks"], ids=lambda page: page.stem
)
def test_notebooks_run(page, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    run_cells(page)


REFERENCE = ROOT / "docs" / "reference"


def topics():
    """The pages of public names by the heading under which the table of contents has them."""
    contents = (REFERENCE / "index.md").read_text(encoding="utf-8")
    for section in re.split(r"^## ", contents, flags=re.MULTILINE)[1:]:
        names = re.findall(r"^classes/(\w+)$", section, re.MULTILINE)
        if names:
            yield section.partition("\n")[0], [REFERENCE / "classes" / f"{name}.md" for name in names]


@pytest.mark.parametrize("pages", [pytest.param(pages, id=topic) for topic, pages in topics()])
def test_examples_of_public_names_run(pages, tmp_path, monkeypatch):
    for page in pages:
        folder = tmp_path / page.stem
        folder.mkdir()
        monkeypatch.chdir(folder)
        with warnings.catch_warnings():
            run_cells(page)


@pytest.mark.parametrize(
    "page", [page for page in PAGES if page != CASE_FILE and blocks(page, "toml")], ids=lambda page: page.stem
)
def test_cases_in_documents_load(page, tmp_path):
    write_tables(page, tmp_path)
    for number, text in enumerate(blocks(page, "toml")):
        case = tmp_path / f"case_{number}.toml"
        case.write_text(text)
        load_case(case)


@pytest.mark.parametrize("analysis", ANALYSES)
def test_examples_of_the_case_file_are_one_case(analysis, tmp_path):
    others = tuple(f"[{other}]" for other in ANALYSES if other != analysis)
    parts = [text for text in blocks(CASE_FILE, "toml") if not text.startswith(others)]
    write_tables(CASE_FILE, tmp_path)
    case = tmp_path / "case.toml"
    case.write_text("\n".join(parts))
    load_case(case)


def test_every_key_of_the_case_file_has_its_row_and_its_example(monkeypatch):
    monkeypatch.syspath_prepend(ROOT / "docs")
    case_keys = importlib.import_module("case_keys")
    text = "\n".join(blocks(CASE_FILE, "toml"))
    for part in ("rods", *case_keys.PARTS):
        for key, value, default, meaning in case_keys.part_rows(part):
            assert all((value, default, meaning)), f"{part}.{key} is not documented"
            assert re.search(rf"\b{key} = ", text), f"no example of {part}.{key}"
