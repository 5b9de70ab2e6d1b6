"""One outcome for one version of the code: property tests draw the same examples each time, unless asked to search."""

import os

from hypothesis import settings

# tests run side by side: threads of the linear algebra would only wait for each other
os.environ.setdefault("OMP_NUM_THREADS", "1")

settings.register_profile("same", derandomize=True)
settings.register_profile("search", print_blob=True)
settings.register_profile("fuzz", print_blob=True, max_examples=10_000)
settings.load_profile("same")
