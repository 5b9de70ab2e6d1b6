"""Draw the picture of docs/howto/periodic.md: the shipped case of a clamped strip."""

from pathlib import Path

from viscorod.analyses.case_run import run_case
from viscorod.casefile.case import load_case
from viscorod.casefile.shipped import shipped_case

IMAGES = Path(__file__).parents[1] / "images"

found = run_case(load_case(shipped_case("clamped_strip")))
print(found.plot(IMAGES / "periodic_amplitude.png"))
print(found.report())
