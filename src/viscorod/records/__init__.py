"""Records of measurements: read, described, compared with results, and taken apart by themselves."""
