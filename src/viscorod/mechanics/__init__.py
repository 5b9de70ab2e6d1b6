"""What nature does: kernels from arrays to arrays, in SI units, without user objects."""
