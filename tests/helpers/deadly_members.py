"""Members of a sweep that end their own process, for tests of what becomes of the others."""

import os
import signal
import time
from pathlib import Path


def work(job, tell, stopped):
    """Do a job: ``deaths`` times die of a signal, then give the square of its number."""
    if job.get("signal"):
        deaths = Path(job["folder"]) / str(job["number"])
        count = len(deaths.read_text()) if deaths.exists() else 0
        if count < job["deaths"]:
            deaths.write_text("x" * (count + 1))
            tell(0.5)
            os.kill(os.getpid(), getattr(signal, job["signal"]))
    if job.get("exit"):
        os._exit(job["exit"])
    if job.get("unsendable"):
        return lambda: None, "", "completed"
    if job.get("counted"):
        with (Path(job["counted"]) / f"{job['number']}-computed").open("a") as file:
            file.write("x")
    time.sleep(job.get("seconds", 0.0))
    tell(1.0)
    return job["number"] ** 2, "", "completed"
