"""The mechanics of rods as kernels from arrays to arrays, in SI units, without user objects."""
