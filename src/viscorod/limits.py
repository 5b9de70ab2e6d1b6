"""Largest sizes: a file that needs more is refused before anything is allocated.

Case files and results may come from elsewhere. Nothing in them is executed; these limits keep them from filling memory
or disk, or running for years. They concern files only, what is built in Python has no limits but those of the machine
and of numbers in double precision.
"""

from __future__ import annotations

LARGEST_CASE = 20_000_000
"""Bytes of a case file: a measured centre line of 10 000 points needs less than a megabyte."""
DEEPEST_NESTING = 30
"""Tables and lists inside each other in a case file; the deepest that means something is about ten."""
LARGEST_TABLE = 50_000_000
"""Bytes of a table of measured moduli, which has some hundred rows."""
MOST_NODES = 500_000
"""Nodes of all rods together: 11 GB of memory for an equilibrium and 40 GB for a motion."""
MOST_CHOSEN = 10_000
"""Elements that the program chooses for one rod: a coil of 3000 turns. More are meant only if they are given."""
MOST_RECORDED = 100e9
"""Bytes of stored states, on disk or in memory."""
LONGEST = 30 * 86_400.0
"""Seconds of computing, by the lowest estimate."""
LARGEST_RESULT = 200e9
"""Bytes of all arrays of a result file as their shapes declare them."""
MOST_DECLARED = 1000
"""The same per byte of the file; stored states compress to a tenth at most."""
MOST_PARTS = 500_000
"""Arrays and groups of a result file: a sweep of 10 000 members that are kept apart has 300 000."""
LARGEST_NUMBER = 1e60
"""Size of a quantity in SI units: products of several leave double precision beyond it."""
SMALLEST_NUMBER = 1e-60
"""The same of one that is not 0: its inverse, or a quotient, leaves double precision below it."""

NODE_BYTES = 22e3
"""Memory for a node in statics: measured with 100 000 nodes in elements of order 5."""
MOTION_BYTES = 75e3
"""The same in motion with three stages: measured with 20 000 nodes."""
STATE_BYTES = 210
"""A stored state of a node."""
NODE_SECONDS = 10e-6
"""Time for a step (or point of a path) of a node; measured 40e-6 with three stages, a quarter of it with one."""
