"""Blade and beam files of other programs, read and written."""
