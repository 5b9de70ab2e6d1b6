"""Put the solvers together: from a model and settings to a result, one module per analysis."""
