"""Functions of results that other processes find, for sweeps."""

import os
import signal
from pathlib import Path


def tip_at_end(result):
    """Displacement of the tip along y in the last state."""
    return result.history("beam.end", "displacement").values[-1, 1]


def ends_its_process_once(result):
    """1, but the second member of a sweep, whose damping it is known by, kills its process the first time."""
    mark = Path(os.environ["ENDS_ONCE"])
    if '"shear_time": 0.02' in result.data.attrs["case"] and not mark.exists():
        mark.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return 1.0


def ends_its_process(result):
    """1, but a member of a sweep with a force of 2e-4 N ends its process while there is a file, which counts that."""
    mark = Path(os.environ["ENDS_WHILE"])
    if "0.0002" in result.data.attrs["case"] and mark.exists():
        with mark.open("a") as file:
            file.write("x")
        os._exit(9)
    return 1.0


def scaled_tip(factor, result):
    """Return a multiple of the deflection of the last station [m]."""
    return factor * tip_at_end(result)


def times_tip(factor):
    """Return a function of a result, which takes its factor from here."""

    def of_result(result):
        return factor * tip_at_end(result)

    return of_result


def as_the_environment_says(result):
    """Return the number that is in the environment of the process."""
    return float(os.environ["TOLD_TO_WORKERS"])
