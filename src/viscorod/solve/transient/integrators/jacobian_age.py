"""How long a frozen Jacobian is kept where a new one does not converge faster: numbers for steps and the compiled loop.

A rate of convergence may be that of what no Jacobian of one instant knows, as of parts that turn far within a step. One
that is renewed then is no better than the one before.
"""

from __future__ import annotations

__all__ = ["HELPED", "LENIENT", "MOST_LENIENT"]

HELPED = 0.5
"""Part of the former rate of convergence below which renewing the Jacobian has helped."""
LENIENT, MOST_LENIENT = 2.0, 3.0
"""Factor by which rates from which on it is renewed grow each time that it has not, and the largest in all."""
