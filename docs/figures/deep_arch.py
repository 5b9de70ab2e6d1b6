"""Draw the figure of docs/howto/paths.md and print its numbers.

python docs/figures/deep_arch.py
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

import viscorod as vr

TARGET = Path(__file__).parents[1] / "images" / "deep_arch.png"
ANGLE = np.radians(215.0)
CROWN = f"arch@{ANGLE / 2}"


def arch(side: float = 0.0) -> vr.Model:
    """Return the clamped-hinged arch of DaDeppo and Schmidt (1975), radius and bending stiffness 1; inextensible."""
    half = ANGLE / 2
    rod = vr.Rod.arc(
        (-np.sin(half), np.cos(half), 0),
        (np.cos(half), np.sin(half), 0),
        (np.sin(half), -np.cos(half), 0),
        1.0,
        ANGLE,
        section=vr.StiffnessSection([1.0] * 6, [1.0] * 6),
        elements=8,
        order=5,
        constraints="kirchhoff",
    )
    model = vr.Model()
    model.add("arch", rod)
    model.support("arch.start", ("ux", "uy", "uz", "rx", "ry"))
    model.clamp("arch.end")
    model.force(CROWN, (0, -10.0, 0))
    if side:
        model.force(CROWN, (0, 0, 10.0 * side))
    return model


def main() -> None:
    path = arch().path(place=CROWN, axis="y", displacement=-1.9, title="Clamped-hinged arch of 215 degrees")
    print(path.report())
    path.plot(TARGET)
    sideways = arch(side=1e-3).path(load_factor=0.5)
    print(f"with a force of 1/1000 out of the plane: {len(sideways.load_factor)} points,")
    print(f"at half of the load the crown is {sideways.displacement(CROWN)[2]:.3f} out of the plane,")
    print(f"negative eigenvalues: {sideways.negative_eigenvalues}")


if __name__ == "__main__":
    main()
