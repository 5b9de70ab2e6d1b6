"""Compiling everything beforehand, from an empty cache, in processes of their own."""

import os
import re
import shutil
import subprocess
import sys

import pytest

from viscorod.mechanics.compilation.machine_code import cache_folder

CHECK = """
from viscorod.mechanics.compilation.compiled import on_disk
from viscorod.analyses.warmup import kernels
print(*[kernel.py_func.__name__ for kernel in kernels() if not on_disk(kernel)])
"""


def keep(compiled):
    """Let later tests find the machine code, where there is less so far: that of the first runs of a demonstration."""
    place = cache_folder()
    if place is None:
        return
    made = compiled / place.name
    if len(list(place.rglob("*.nbc"))) < len(list(made.rglob("*.nbc"))):
        shutil.rmtree(place)
        shutil.copytree(made, place)


@pytest.mark.slow
def test_everything_is_compiled_once(tmp_path):
    def output(*arguments):
        environment = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path)}
        command = [sys.executable, *arguments]
        return subprocess.run(command, check=True, capture_output=True, text=True, env=environment)

    first = output("-m", "viscorod", "warmup")
    count = int(re.search(r"^(\d+) kernels compiled in [\d.]+ s; machine code is in ", first.stdout)[1])
    assert str(tmp_path) in first.stdout
    assert f"{count} of {count} kernels" in first.stderr
    assert "warning" not in first.stderr
    assert output("-c", CHECK).stdout.strip() == "", "a kernel that the warm-up does not reach"
    second = output("-m", "viscorod", "warmup")
    assert second.stdout.startswith(f"all {count} kernels are compiled already, in {tmp_path}")
    assert "compil" not in second.stderr
    keep(tmp_path)
