"""Results on disk: one netCDF file, a journal of a run on its way there, CSV and ParaView files."""
