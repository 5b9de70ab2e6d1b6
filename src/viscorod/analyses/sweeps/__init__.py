"""Parts of sweeps: values of members, members in batches, records on disk."""
