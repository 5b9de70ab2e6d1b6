"""A sweep on a local Dask cluster; left out where Dask is not installed."""

import os
import signal

import numpy as np
import pytest

import viscorod as vr
from helpers.strip import content
from helpers.sweep_records import records_in
from viscorod.analyses.sweeps import executors
from viscorod.analyses.sweeps.executors import opened
from viscorod.casefile.case import case_from_dict

distributed = pytest.importorskip("distributed")


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore")  # those of the cluster itself
def test_a_worker_of_dask_that_is_killed_loses_nothing(tmp_path):
    """Two workers, one killed in the middle: every member is there once, bit for bit that of one process."""
    case = case_from_dict(content("simulate", duration=0.1, time_step=0.01))
    values = {"materials.rubber.damping.shear_time": np.linspace(0.01, 0.04, 8)}
    quantities = {"tip": ("displacement", "beam.end", "y", "last")}
    alone = vr.sweep(case, values, quantities=quantities, workers=1).table()
    killed = []

    with distributed.LocalCluster(2, threads_per_worker=1, dashboard_address=None) as cluster:

        def kill_once(done):
            if done >= 1.0 and not killed:
                killed.append(cluster.workers[0].pid)
                os.kill(killed[0], signal.SIGKILL)

        executor = f"dask:{cluster.scheduler_address}"
        given = {"quantities": quantities, "executor": executor, "folder": tmp_path / "sweep"}
        table = vr.sweep(case, values, progress=kill_once, **given).table()
    assert killed
    assert table["tip"].tolist() == alone["tip"].tolist()
    names = [record["name"] for record in records_in(tmp_path / "sweep")]
    assert set(table["outcome"]) == {"completed"}
    assert len(set(names)) == 8


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(signal, "pthread_sigmask"), reason="this system has no masks of signals")
@pytest.mark.filterwarnings("ignore")
def test_ctrl_c_is_nothing_to_workers_of_this_machine():
    """A terminal sends it to all processes; those of the client's own cluster wait for what the client says."""
    with opened("dask") as executor:
        pids = executor._client.run(os.getpid)
        for pid in pids.values():
            os.kill(pid, signal.SIGINT)
        assert executor.submit(abs, -3).result(60) == 3
        assert set(executor._client.run(os.getpid).values()) == set(pids.values())
    assert signal.SIGINT not in signal.pthread_sigmask(signal.SIG_BLOCK, [])


@pytest.mark.parametrize(
    ("address", "words"),
    [
        ("tcp://127.0.0.1:1", "no scheduler answered within 0.5 s"),
        ("localhost", "this is no address .missing port number"),
        ("http://localhost:80", "this is no address .unknown address scheme"),
    ],
)
def test_an_address_without_a_scheduler_is_told(address, words, monkeypatch):
    monkeypatch.setattr(executors, "PATIENCE", 0.5)
    case = case_from_dict(content("equilibrium"))
    with pytest.raises(vr.InputError, match=words):
        vr.sweep(case, {"loads[0].value[1]": [1e-4]}, quantities={}, executor=f"dask:{address}")
