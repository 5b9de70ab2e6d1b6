"""Compilation of kernels with Numba: decorators, the cache on disk, two processes that share the work."""
