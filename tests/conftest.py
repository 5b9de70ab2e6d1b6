"""One outcome for one version of the code: property tests draw the same examples each time, unless asked to search."""

from hypothesis import settings

settings.register_profile("same", derandomize=True)
settings.register_profile("search", print_blob=True)
settings.load_profile("same")
