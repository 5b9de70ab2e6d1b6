"""Reports of results as plain text."""
