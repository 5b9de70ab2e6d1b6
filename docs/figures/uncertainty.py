"""Pictures and tables of the page on uncertain values: the decay of the LLT cantilever.

E, retardation time, width and force are uncertain; 64 points of a Sobol' sequence, 384 motions of 6 s (a minute).
"""

from pathlib import Path

import scipy.stats as st

import viscorod as vr

ROOT = Path(__file__).parents[2]
IMAGES = ROOT / "docs" / "images"
SPREAD = {
    "materials.rubber.youngs_modulus": st.norm(1.0e6, 5.0e4),
    "materials.rubber.damping.shear_time": st.lognorm(0.2, scale=0.02),
    "sections.square.width": st.norm(0.01, 2.0e-4),
    "loads[0].value[1]": st.norm(0.035, 1.75e-3),
}


def main():
    found = vr.ensemble(
        ROOT / "examples" / "cantilever_swing.toml",
        SPREAD,
        64,
        quantities={
            "period of the first cycle [s]": ("decrement", "beam.end", "y", "period", 1),
            "damping ratio of the first cycle": ("decrement", "beam.end", "y", "damping_ratio", 1),
            "tip [m]": ("displacement", "beam.end", "y", "history"),
        },
        seed=1,
        indices=True,
        constants={"simulate.duration": 6.0},
        workers=1,
    )
    print(found.report())
    print(found.moments())
    found.plot(IMAGES / "uncertainty_quantiles.png")
    found.plot_indices(IMAGES / "uncertainty_indices.png")
    found.plot_fan(IMAGES / "uncertainty_fan.png", "tip [m]")


if __name__ == "__main__":
    main()
