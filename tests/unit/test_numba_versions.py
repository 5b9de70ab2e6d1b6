"""Versions of Numba: its inner classes are used where they are known to fit, and nowhere else."""

from types import SimpleNamespace

import numba
import pytest
from numba.core.compiler import Compiler

from viscorod.mechanics.compilation import pipelines


@pytest.mark.parametrize("version", [(0, 60), (0, 99), (1, 0)])
def test_other_versions_compile_by_themselves(monkeypatch, version):
    monkeypatch.setattr(pipelines.numba, "version_info", SimpleNamespace(short=version))
    assert pipelines.part_compiler() is Compiler
    assert pipelines.kernel_compiler() is Compiler


def test_known_versions_take_the_short_way(monkeypatch):
    for version in (*pipelines.TESTED, (0, 64)):
        monkeypatch.setattr(numba, "version_info", SimpleNamespace(short=version))
        assert issubclass(pipelines.part_compiler(), Compiler)
        assert pipelines.kernel_compiler() is not Compiler
