"""Records of measurements with no more than an identification asks of them."""

from dataclasses import dataclass, field

import numpy as np


@dataclass(frozen=True)
class PlainUnknown:
    name: str
    start: float = 0.0
    low: float = -np.inf
    high: float = np.inf
    deviation: float = np.inf
    key: str | None = None


@dataclass
class PlainRecord:
    name: str
    observed: np.ndarray
    noise: np.ndarray | None = None
    nuisances: dict = field(default_factory=dict)

    def by_nuisances(self, result, nuisances=None):
        found = {}
        for full in self.nuisances:
            ends = [
                self.predicted(result, {**(nuisances or {}), full: (nuisances or {}).get(full, 0.0) + step})
                for step in (1e-5, -1e-5)
            ]
            found[full] = (ends[0] - ends[1]) / 2e-5
        return found

    def value(self, word, nuisances):
        full = f"{self.name}.{word}"
        return nuisances.get(full, self.nuisances[full].start) if full in self.nuisances else 0.0


@dataclass
class PlainHistory(PlainRecord):
    times: np.ndarray = field(default_factory=lambda: np.zeros(0))
    place: str = "beam.end"
    axis: int = 1
    analysis = "simulate"
    quantity = "displacement"

    @property
    def interval(self):
        return self.times[1] - self.times[0]

    def predicted(self, result, nuisances=None):
        nuisances = nuisances or {}
        times = np.clip(self.times - self.value("release_time", nuisances), 0.0, None)
        found = result.probe(self.place, times)["displacement"].values[:, 0, self.axis]
        return found + self.value("offset", nuisances)


@dataclass
class PlainModes(PlainRecord):
    frequencies: np.ndarray = field(default_factory=lambda: np.zeros(0))
    damping_ratios: np.ndarray | None = None
    analysis = "modes"

    def predicted(self, result, nuisances=None):
        count = len(self.frequencies)
        hertz = result.frequencies[:count]
        return hertz if self.damping_ratios is None else np.append(hertz, result.damping_ratios[:count])


@dataclass
class PlainStatics(PlainRecord):
    place: str = "beam.end"
    axis: int = 1
    loads: np.ndarray = field(default_factory=lambda: np.zeros(0))
    analysis = "equilibrium"

    def predicted(self, result, nuisances=None):
        moved = result.probe(self.place)["displacement"].values[:, 0, self.axis]
        return np.interp(self.loads, result.load_factor, moved)
