"""Print the table of readings in docs/explanation/awp_beams.md: the hinged beam with other data, in some minutes.

python docs/figures/awp_readings.py
"""

from __future__ import annotations

from typing import Any

import numpy as np

import viscorod as vr

SHEARS_FIRST = [1, 2, 0, 4, 5, 3]
"""The places of viscorod's components in the paper's order."""


def hinged(
    stiffness: list[float] | None = None,
    inertia: list[float] | None = None,
    *,
    eta: tuple[float, ...] = (1e-3,) * 6,
    torque: tuple[float, float] = (0.5, 0.5),
    following: bool = True,
    frequency: float = 2.0,
    until: float = 0.5,
) -> vr.Model:
    """Return the beam of section V.B; components in the paper's order, axial and twist first."""
    C = np.array(stiffness or [1e5, 5e3, 5e3, 1.0, 1.0, 2.0])[SHEARS_FIRST]
    M = np.array(inertia or [1.0, 1.0, 1.0, 4e-4, 2e-4, 2e-4])[SHEARS_FIRST]
    damping = C * np.array(eta)[SHEARS_FIRST]
    section = vr.StiffnessSection(C.tolist(), M.tolist(), damping=damping.tolist())
    model = vr.Model()
    model.add("beam", vr.Rod.straight((0, 0, 0), (1, 0, 0), section=section, elements=4, order=5))
    model.pin("beam.start")
    turned = (*torque, 0.0) if following else model.rods["beam"].frames([1.0])[1][0] @ (*torque, 0.0)
    model.moment("beam.end", turned, following=following, time=vr.Sine(frequency), until=until)
    return model


def stiff(
    axial: float = 1e5, shear: float = 5e3, twist: float = 1.0, first: float = 1.0, second: float = 2.0
) -> list[float]:
    return [axial, shear, shear, twist, first, second]


READINGS: dict[str, dict[str, Any]] = {
    "as printed: EA = 1e5": {},
    "**EA = 1e4**": {"stiffness": stiff(1e4)},
    "EA = 1e6": {"stiffness": stiff(1e6)},
    "EA = 1e3": {"stiffness": stiff(1e3)},
    "EA = 5e3, as the shear stiffness": {"stiffness": stiff(5e3)},
    "EA = 5e4": {"stiffness": stiff(5e4)},
    "shear stiffness 5e2": {"stiffness": stiff(shear=5e2)},
    "shear stiffness 5e4": {"stiffness": stiff(shear=5e4)},
    "GJ = 2, EI = 1 and 1": {"stiffness": stiff(twist=2.0, second=1.0)},
    "GJ = 2, EI = 1 and 2": {"stiffness": stiff(twist=2.0)},
    "GJ = 0.5": {"stiffness": stiff(twist=0.5)},
    "EI = 1 and 0.5 (C of bending as a compliance)": {"stiffness": stiff(second=0.5)},
    "1e5 on one shear, 5e3 on stretch": {"stiffness": [5e3, 1e5, 5e3, 1.0, 1.0, 2.0]},
    "rotary inertia 2e-4 about the axis, 4e-4 about e2": {"inertia": [1.0, 1.0, 1.0, 2e-4, 4e-4, 2e-4]},
    "rotary inertia 2e-4 about the axis, 4e-4 about e3": {"inertia": [1.0, 1.0, 1.0, 2e-4, 2e-4, 4e-4]},
    "rotary inertia 4e-4 about all axes": {"inertia": [1.0, 1.0, 1.0, 4e-4, 4e-4, 4e-4]},
    "damping of stretch and bending only": {"eta": (1e-3, 0, 0, 0, 1e-3, 1e-3)},
    "damping of bending and twist only": {"eta": (0, 0, 0, 1e-3, 1e-3, 1e-3)},
    "damping of stretch and shear only": {"eta": (1e-3, 1e-3, 1e-3, 0, 0, 0)},
    "no damping of stretch": {"eta": (0, *(1e-3,) * 5)},
    "a tenth of the damping of stretch": {"eta": (1e-4, *(1e-3,) * 5)},
    "no damping of shear": {"eta": (1e-3, 0, 0, 1e-3, 1e-3, 1e-3)},
    "no damping of twist": {"eta": (1e-3, 1e-3, 1e-3, 0, 1e-3, 1e-3)},
    "all times doubled": {"eta": (2e-3,) * 6},
    "all times halved": {"eta": (5e-4,) * 6},
    "dead torque, about axes that stay": {"following": False},
    "torque of amplitude 1": {"torque": (1.0, 1.0)},
    "torque of amplitude 1/4": {"torque": (0.25, 0.25)},
    "torque of resultant 1/2": {"torque": (0.5 / np.sqrt(2), 0.5 / np.sqrt(2))},
    "torques of opposite signs": {"torque": (0.5, -0.5)},
    "torque for two periods": {"until": 1.0},
    "torque of half the frequency, for 0.5 s": {"frequency": 1.0},
}


def main() -> None:
    print("| Reading | spin [rad/s] | E [J] | i₁Lω²/2 [J] |\n|---|---|---|---|")
    for name, given in READINGS.items():
        try:
            run = hinged(**given).simulate(
                50.0,
                initial="reference",
                formulation="intrinsic",
                damping="linearised",
                tolerance=1e-6,
                output_interval=0.5,
            )
        except (vr.SolveError, vr.InputError, np.linalg.LinAlgError) as error:
            print(f"| {name} | {error} | | |", flush=True)
            continue
        spin = float(run.data["angular_velocity"].values[-1, 0, 2])
        axial = (given.get("inertia") or [0, 0, 0, 4e-4])[3]
        print(
            f"| {name} | {abs(spin):.3f} | {run.energy.total[-1]:.5f} | {axial * spin**2 / 2:.5f} |",
            flush=True,
        )


if __name__ == "__main__":
    main()
