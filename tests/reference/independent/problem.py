"""The bridge beam of Artola, Wynn, Palacios (AWP) section V.A: numbers, load, and the linear solution.

Pinned at s = 0; at s = L the transverse displacement is held and a dead axial force Q compresses. A transverse
dead load P(t) = P0 sin(omega t) sits on the material station s = v t. I is 0.0243 m4: the printed 0.0234 fits
neither Qcr = 9330 kN nor omega_b = 7.83 rad/s, both printed too.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .galerkin import Array


@dataclass(frozen=True)
class Bridge:
    """Properties in SI units; ``eta`` is the Kelvin-Voigt time of stretch and bending."""

    eta: float
    omega: float
    length: float = 30.0
    mass: float = 1500.0
    area: float = 0.36
    inertia: float = 0.0243
    young: float = 35e9
    amplitude: float = 2e6
    speed: float = 20.0
    compression: float = 0.1  # in units of the Euler load

    @property
    def EA(self) -> float:
        return self.young * self.area

    @property
    def EI(self) -> float:
        return self.young * self.inertia

    @property
    def Q(self) -> float:
        """Compression at the guided end."""
        return self.compression * np.pi**2 * self.EI / self.length**2

    @property
    def stretch(self) -> float:
        """Stretch 1 - Q/EA of the static straight state."""
        return 1 - self.Q / self.EA

    def load(self, t: float) -> float:
        """Load P(t)."""
        return float(self.amplitude * np.sin(self.omega * t))

    def station(self, t: float) -> float:
        """Station of the load."""
        return self.speed * t


@dataclass(frozen=True)
class Motion:
    """Mid-span deflection, positive along the load, and where the energy went, all counted from the start."""

    times: Array
    deflection: Array
    energy: Array
    work: Array
    dissipated: Array

    @property
    def imbalance(self) -> float:
        """Largest |energy + dissipated - work| over the largest energy."""
        return float(np.abs(self.energy + self.dissipated - self.work).max() / np.abs(self.energy).max())


def frequencies(bridge: Bridge, count: int, prestrained: bool = True) -> Array:
    """Undamped angular frequencies of bending about the compressed straight state, without shear and rotary inertia.

    mu w_tt + EI w''''/g^2 + Q w''/g = 0 with the stretch g = 1 - Q/EA, s being the material coordinate: the rotation
    is w'/g and the moment balance M' + g T = 0. The textbook form mu w_n^2 = EI k^4 - Q k^2 has g = 1.
    """
    k = np.pi * np.arange(1, count + 1) / bridge.length
    g = bridge.stretch if prestrained else 1.0
    return np.sqrt((bridge.EI * k**4 / g**2 - bridge.Q * k**2 / g) / bridge.mass)


def modal_sum(bridge: Bridge, times: Array, count: int = 400, prestrained: bool = True) -> Array:
    """Mid-span deflection of the linear model (L-L), closed form in each sine mode.

    q_tt + (eta EI k^4/(g^2 mu)) q_t + w_n^2 q = (2 P0/(mu L)) sin(omega t) sin(k v t), at rest at t = 0. The product of
    sines is half the difference of two cosines, of frequencies omega -+ k v; each gives a harmonic response, and
    the roots of the characteristic equation give the transient. Valid while the load is on the beam. AWP (36b) prints
    the bending term with a minus; only plus is a beam, minus grows without bound.
    """
    times = np.asarray(times, dtype=float)
    g = bridge.stretch if prestrained else 1.0
    n = np.arange(1, count + 1, 2)  # even modes have a node at mid-span
    k = np.pi * n / bridge.length
    square = frequencies(bridge, count, prestrained)[::2] ** 2
    friction = bridge.eta * bridge.EI * k**4 / g**2 / bridge.mass
    root = np.sqrt((friction / 2) ** 2 - square + 0j)
    # the sum of the roots cancels for overdamped modes, their product does not
    fast = -friction / 2 - root
    slow = square / fast
    q = np.zeros((times.size, n.size), dtype=complex)
    for sign in (1, -1):
        lam = 1j * (bridge.omega - sign * k * bridge.speed)
        y0 = sign * bridge.amplitude / (bridge.mass * bridge.length) / (lam**2 + friction * lam + square)
        # y = Re[y0 e^(lam t)] and its transient: a real problem, so take the real parts at t = 0
        start, rate = y0.real, (lam * y0).real
        fast_part = (slow * start - rate) / (slow - fast)
        slow_part = (rate - fast * start) / (slow - fast)
        t = times[:, None]
        q += np.real(y0 * np.exp(lam * t)) - fast_part * np.exp(fast * t) - slow_part * np.exp(slow * t)
    return np.real(q) @ np.sin(n * np.pi / 2)
