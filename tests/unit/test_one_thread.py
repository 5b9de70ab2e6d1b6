"""Linear algebra takes one thread while something is computed, and as many as before afterwards."""

from threadpoolctl import threadpool_info, threadpool_limits

import viscorod as vr


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
    seen = []
    with threadpool_limits(limits=2, user_api="blas"):
        model.simulate(0.01, initial="reference", progress=lambda t, h: seen.append(threads()))
        after = threads()
    assert set.union(*seen) == {1}
    assert after == {2}
