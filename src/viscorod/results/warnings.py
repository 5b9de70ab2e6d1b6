"""What a reader of a result should know before trusting it."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING

import numpy as np

from viscorod.results.schema import COUNTERS

if TYPE_CHECKING:
    from viscorod.results.result import Result

_NUMERICAL = 0.01  # accepted remainder of the energy account, as a part of what moved
_STRAIN = 0.1  # shear and stretch beyond which a linear material law for small strains is doubtful


def warnings_of(result: Result) -> list[str]:
    """Return the warnings stored with a result and those that its data call for.

    Stored ones are the JSON list of texts in the attribute ``warnings``. Added are: a remainder of the energy
    account above 1 % of the energy that moved, steps that had to be halved, and shear or stretch beyond 0.1,
    where the Kelvin-Voigt law for small strains (Linn, Lang and Tuganov, section 2.2) is doubtful.
    """
    data = result.data
    texts = [str(text) for text in json.loads(data.attrs.get("warnings", "[]"))]
    if "numerical" in data and "kinetic" in data:
        from viscorod.results.energy import Energy

        fraction = Energy.of(data).numerical_fraction
        if fraction > _NUMERICAL:
            texts.append(
                f"the numerical remainder of the energy account reaches {100.0 * fraction:.2g} % "
                "of the energy that moved; use a smaller time_step"
            )
    rejected = int(data.attrs.get(COUNTERS[-1], 0))
    if rejected:
        what = "time step" if result.dimension == "time" else "load step"
        plural = "s" if rejected > 1 else ""
        texts.append(
            f"{rejected} {what}{plural} did not converge and had to be tried again with a smaller one"
        )
    if "strain" in data and data.sizes.get("point", 0):
        strain = np.abs(np.asarray(data["strain"].values, dtype=float)[..., :3])
        worst = np.unravel_index(int(np.argmax(strain)), strain.shape)
        if strain[worst] > _STRAIN:
            name = ("shear 1", "shear 2", "stretch")[int(worst[-1])]
            where = ""
            if "point_rod" in data and "point_s" in data:
                point = int(worst[-2])
                where = f" at {data['point_rod'].values[point]}@{float(data['point_s'].values[point]):.4g}"
            texts.append(
                f"the strain {name} reaches {strain[worst]:.2g}{where}; "
                "the material law is meant for strains well below 1"
            )
    return texts
