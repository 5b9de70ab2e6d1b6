"""Machine code in wheels: made for one kind of processor, used where it fits, and nowhere else."""

import os
import subprocess
import sys

import numpy as np
import pytest
from numba import njit

from viscorod.mechanics.compilation import machine_code
from viscorod.mechanics.compilation.machine_code import MAKES, TARGET, _KernelCache, shipped

pytestmark = pytest.mark.skipif(TARGET is None, reason="no machine code is made for this kind of processor")

TURN = """
import sys
from pathlib import Path
import numpy as np
from viscorod.mechanics.compilation import machine_code
machine_code.SHIPPED = Path(sys.argv[1])
from viscorod.mechanics.rotations.rotation import rotate_rows
out = np.zeros((1, 3))
rotate_rows(np.array([[np.sqrt(0.5), 0.0, 0.0, np.sqrt(0.5)]]), np.array([[2.0, 0.0, 0.0]]), out)
print(len(rotate_rows.stats.cache_misses), *out[0].round(12))
"""


def twice(x):
    return 2.0 * x


@pytest.fixture
def wheel(tmp_path, monkeypatch):
    """What reads machine code of one function from a wheel."""
    monkeypatch.setattr(machine_code, "SHIPPED", tmp_path / "wheel")
    compiled = njit(twice)
    assert compiled(1.5) == 3.0
    ((signature, code),) = compiled.overloads.items()
    _KernelCache(twice, tmp_path / "wheel", TARGET).save_overload(signature, code)
    machine_code._shipped_folder.cache_clear()

    def load():
        cache = shipped(twice)
        return None if cache is None else cache.load_overload(signature, compiled.targetctx)

    yield load
    machine_code._shipped_folder.cache_clear()


def test_code_that_fits_is_used(wheel):
    assert wheel() is not None


def test_other_sources_are_compiled(wheel, monkeypatch):
    monkeypatch.setattr(machine_code, "_content", lambda: "another version")
    assert wheel() is None


def test_other_versions_of_numba_compile(wheel, monkeypatch):
    monkeypatch.setattr("numba.__version__", "0.0.1")
    assert wheel() is None


def test_processors_without_its_abilities_compile(wheel, monkeypatch):
    monkeypatch.setattr("llvmlite.binding.get_host_cpu_features", dict)
    assert wheel() is None


def test_code_for_a_processor_that_is_asked_for_is_compiled(wheel, monkeypatch):
    monkeypatch.setattr(machine_code._config, "CPU_NAME", "generic")
    assert wheel() is None


def test_made_by_one_process_and_used_by_another(tmp_path):
    """A quarter turn about z takes 2 x to 2 y; the second process compiles nothing."""

    def output(**given):
        environment = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path / "here")} | given
        command = [sys.executable, "-c", TURN, str(tmp_path / "wheel")]
        done = subprocess.run(command, check=True, capture_output=True, text=True, env=environment)
        return np.array(done.stdout.split(), dtype=float)

    processor = {"NUMBA_CPU_NAME": TARGET.name, "NUMBA_CPU_FEATURES": ""}
    assert output(**{MAKES: str(tmp_path / "wheel")} | processor).tolist() == [1.0, 0.0, 2.0, 0.0]
    assert output().tolist() == [0.0, 0.0, 2.0, 0.0]
    assert not list((tmp_path / "here").rglob("*.nbc"))
