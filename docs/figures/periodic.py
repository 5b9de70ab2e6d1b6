"""Draw the pictures of docs/howto/periodic.md: the clamped strip, and the cantilever that is let go."""

from pathlib import Path

from viscorod.analyses.case_run import as_model, run_case
from viscorod.casefile.case import load_case
from viscorod.casefile.shipped import shipped_case

IMAGES = Path(__file__).parents[1] / "images"

found = run_case(load_case(shipped_case("clamped_strip")))
found.plot(IMAGES / "periodic_amplitude.png")
print(found.report())

swing = as_model(load_case(shipped_case("cantilever_swing")).description)
free = swing.periodic(mode=1, largest=0.17, outputs=["beam.end uy"], about="released", harmonics=7, step=0.3)
free.plot(IMAGES / "periodic_backbone.png")
print(free.report())
