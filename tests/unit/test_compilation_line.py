"""The line about compilation on a terminal, with kernels that are ready when the test says so."""

import logging
from types import SimpleNamespace

import pytest

from viscorod.analyses import compilation_line
from viscorod.analyses.compilation_line import COSTS, CompilationLine, end_compilation_line
from viscorod.analyses.warmup import kernels
from viscorod.mechanics.compilation import compiled

KNOWN = {kernel.py_func.__name__ for kernel in kernels()}


def a_kernel(name, ready):
    return SimpleNamespace(py_func=SimpleNamespace(__name__=name), signatures=[()] * ready)


@pytest.fixture
def line():
    handler = CompilationLine()
    logging.getLogger("viscorod").addHandler(handler)
    yield handler
    end_compilation_line()
    logging.getLogger("viscorod").removeHandler(handler)


def test_kernels_are_those_of_the_package():
    assert set(COSTS) <= KNOWN


def test_tells_how_far_it_is(line, monkeypatch, capsys):
    monkeypatch.setattr("sys.stderr.isatty", lambda: True)
    now = [0.0]
    monkeypatch.setattr(compilation_line.time, "monotonic", lambda: now[0])
    monkeypatch.setattr(compilation_line, "COSTS", {"strains": 1.0, "assemble": 3.0})
    kernels = [a_kernel("strains", True), a_kernel("assemble", False)]
    monkeypatch.setattr(compiled, "KERNELS", kernels)
    logging.getLogger("viscorod").warning("compiling", extra={"compiles": True})
    now[0] = 10.0
    line.show()
    now[0] = 20.0
    line.show()
    shown = capsys.readouterr().err
    assert shown.startswith("compiling\n")
    # a quarter after 10 s: 40 s in all
    assert "25 %, about 30 s left" in shown
    assert "25 %, about 20 s left" in shown
    end_compilation_line()
    assert capsys.readouterr().err == "\r\033[K"


def test_other_messages_and_files_have_no_line(line, monkeypatch, capsys):
    logging.getLogger("viscorod").warning("finding modes")
    monkeypatch.setattr("sys.stderr.isatty", lambda: False)
    logging.getLogger("viscorod").warning("compiling", extra={"compiles": True})
    end_compilation_line()
    assert capsys.readouterr().err == "finding modes\ncompiling\n"
