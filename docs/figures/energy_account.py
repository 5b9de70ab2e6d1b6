"""Draw the account of docs/explanation/energy_account.md and print its table of remainders.

python docs/figures/energy_account.py
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

import viscorod as vr
from viscorod.casefile.case import load_case
from viscorod.casefile.shipped import shipped_case

TARGET = Path(__file__).parents[1] / "images" / "energy_account.png"


def strip() -> vr.Model:
    """Return the shipped strip of rubber in gravity, with a damper at its end and a clamp that is lifted."""
    model = load_case(shipped_case("rubber_strip")).model(vr.Model)
    model.supports[:] = []
    model.clamp("strip.start", motion={"uz": vr.TimeTable([0, 1.0, 1.5], [0, 0, 0.02])})
    model.spring("strip.end", damping={"uz": 0.02}, name="damper")
    model.gravity()
    return model


def main() -> None:
    run = strip().simulate(4.0, title="Rubber strip in gravity, let go, then lifted")
    run.plot_energy(TARGET)
    print(run.energy)
    print("\n| case | integrator | largest remainder | warned |\n|---|---|---|---|")
    for name, duration in (("cantilever_swing", 5.0), ("right_angle_frame", 10.0)):
        case = load_case(shipped_case(name))
        initial = "equilibrium" if name == "cantilever_swing" else "reference"
        for given in (
            {"tolerance": 1e-1},
            {"tolerance": 1e-2},
            {"tolerance": 1e-3},
            {"tolerance": 1e-4},
            {"tolerance": 1e-5},
            {"integrator": "generalized_alpha", "time_step": 0.1},
            {"integrator": "generalized_alpha", "time_step": 0.025},
            {"integrator": "midpoint", "time_step": 0.025},
        ):
            run = case.model(vr.Model).simulate(duration, initial=initial, **given)
            share = 100 * run.energy.numerical / run.energy.moved
            worst = share[np.argmax(np.abs(share))]
            warned = "yes" if run.energy.numerical_fraction > 0.01 else "no"
            words = ", ".join(f"{key} {value}" for key, value in given.items())
            print(f"| {name} | {words} | {worst:.2g} % | {warned} |", flush=True)


if __name__ == "__main__":
    main()
