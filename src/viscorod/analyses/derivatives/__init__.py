"""Derivatives of results by numbers of the case."""
