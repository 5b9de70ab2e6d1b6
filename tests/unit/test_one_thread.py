"""Linear algebra takes one thread while something is computed, and as many as before afterwards."""

import os
import subprocess
import sys
from importlib import import_module

from threadpoolctl import threadpool_info, threadpool_limits

import viscorod as vr
from viscorod.one_thread import one_blas_thread


def threads():
    """Return the numbers of threads that BLAS libraries may take."""
    return {pool["num_threads"] for pool in threadpool_info() if pool["user_api"] == "blas"}


def test_threads_of_the_process_are_as_before():
    """Two threads, one in every step of a motion, two again."""
    model = vr.Model()
    rubber = vr.Material(1e6, 0.3, 1000.0)
    model.add("bar", vr.Rod.straight((0, 0, 0), (1, 0, 0), section=vr.Circle(0.01), material=rubber))
    model.clamp("bar.start")
    model.gravity()
    import_module("scipy.linalg")  # brings its library, so that the test may limit it
    seen = []
    with threadpool_limits(limits=2, user_api="blas"):
        model.simulate(0.01, initial="reference", progress=lambda t, h: seen.append(threads()))
        after = threads()
    assert set.union(*seen) == {1}
    assert after == {2}


def test_a_decay_takes_one_thread(monkeypatch):
    """On a machine with other work several threads wait for each other, thirty times as long as the decay takes."""
    import numpy as np

    from viscorod.records import free_decay

    import_module("scipy.linalg")
    seen, fit = [], free_decay.best_fit
    monkeypatch.setattr(free_decay, "best_fit", lambda *given: (seen.append(threads()), fit(*given))[1])
    times = np.linspace(0.0, 2.0, 200)
    with threadpool_limits(limits=2, user_api="blas"):
        vr.decay(times, np.exp(-0.5 * times) * np.cos(20.0 * times))
        after = threads()
    assert set.union(*seen) == {1}
    assert after == {2}


def test_threads_are_as_before_when_the_last_of_several_computations_ends():
    """One begins, another begins, the first ends, the other goes on with one thread, and ends."""
    import_module("scipy.linalg")
    with threadpool_limits(limits=2, user_api="blas"):
        first, other = one_blas_thread(), one_blas_thread()
        first.__enter__()
        other.__enter__()
        first.__exit__(None, None, None)
        meanwhile = threads()
        other.__exit__(None, None, None)
        after = threads()
    assert (meanwhile, after) == ({1}, {2})


FIRST = """
import sys
from threadpoolctl import threadpool_info
from viscorod.one_thread import one_blas_thread
assert "scipy.linalg" not in sys.modules
with one_blas_thread():
    import scipy.linalg
    print({pool["num_threads"] for pool in threadpool_info() if pool["user_api"] == "blas"})
"""


def test_the_first_computation_of_a_process_takes_one_thread_too():
    """Libraries that come with the first computation are limited as well, not only those that were there before."""
    given = {name: value for name, value in os.environ.items() if not name.endswith("NUM_THREADS")}
    told = subprocess.run(
        [sys.executable, "-c", FIRST], env=given, capture_output=True, text=True, check=False
    )
    assert told.stdout.strip() == "{1}", told.stderr
