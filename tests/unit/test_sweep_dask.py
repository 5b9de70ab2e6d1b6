"""A sweep on a local Dask cluster; left out where Dask is not installed."""

import json
import os
import signal

import numpy as np
import pytest

import viscorod as vr
from helpers.strip import content
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
    lines = "".join(path.read_text() for path in (tmp_path / "sweep" / "members").glob("*.jsonl"))
    names = [json.loads(line)["name"] for line in lines.splitlines() if line]
    assert set(table["outcome"]) == {"completed"}
    assert len(set(names)) == 8
