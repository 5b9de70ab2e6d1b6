"""Draw the pictures of the hinged beam in docs/explanation/awp_beams.md and print its tables, in some minutes.

python docs/figures/awp_hinged.py
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from scipy.interpolate import KroghInterpolator

import viscorod as vr
from viscorod.mechanics.rotations.quaternion import matrices
from viscorod.pictures.style import BLUE, GREEN, RED, clean, heading, legend_inside

STIFFNESS = np.array([5e3, 5e3, 1e4, 1.0, 2.0, 1.0])
INERTIA = np.array([1.0, 1.0, 1.0, 2e-4, 2e-4, 4e-4])
AXIS = np.array([0.0, 0.0, 1.0])
DAMPINGS = ("linearised", "full")
COLOURS = {0.01: GREEN, 0.001: RED, 0.0001: BLUE}
DURATION, PUSHED = 50.0, 0.5
MESH, TOLERANCE = (4, 5), 1e-7
FINE_MESH, FINE_TOLERANCE = (8, 5), 1e-8
STEP = 1e-3
IMAGES = Path(__file__).parents[1] / "images"


def hinged(eta: float, elements: int = MESH[0], order: int = MESH[1]) -> vr.Model:
    """Return the beam on a ball joint of Artola, Wynn and Palacios, section V.B."""
    section = vr.StiffnessSection(STIFFNESS.tolist(), INERTIA.tolist(), damping=(eta * STIFFNESS).tolist())
    model = vr.Model()
    rod = vr.Rod.straight((0, 0, 0), (1, 0, 0), section=section, elements=elements, order=order)
    model.add("beam", rod)
    model.pin("beam.start")
    model.moment("beam.end", (0.5, 0.5, 0), following=True, time=vr.Sine(2.0), until=PUSHED)
    return model


def motion(
    eta: float, damping: str, mesh: tuple[int, int] = MESH, tolerance: float = TOLERANCE, **given: float
) -> vr.Run:
    model = hinged(eta, *mesh)
    return model.simulate(
        DURATION, initial="reference", formulation="intrinsic", damping=damping, tolerance=tolerance, **given
    )


def body_twist(run: vr.Run) -> np.ndarray:
    """Return (v, w) at the stations in body axes, x1 of the paper."""
    turn = matrices(np.ascontiguousarray(run.data["rotation"].values.reshape(-1, 4)))
    velocity = np.einsum("kji,kj->ki", turn, run.data["velocity"].values.reshape(-1, 3))
    shape = run.data["velocity"].shape
    return np.concatenate([velocity.reshape(shape), run.data["angular_velocity"].values], axis=-1)


def strain_rates(run: vr.Run, x1: np.ndarray, strain: np.ndarray) -> dict[str, np.ndarray]:
    """Return x1' - E^T x1 ("linearised") or eps_t ("full") at the Gauss points, from x1 at the stations."""
    s, points = run.data["station_s"].values, run.data["point_s"].values
    order = int(run.data["station_order"].values[0])
    at_points, slope = np.empty_like(strain), np.empty_like(strain)
    for first in range(0, len(points), order):
        mine, nodes = slice(first, first + order), slice(first, first + order + 1)
        element = KroghInterpolator(s[nodes], x1[:, nodes], axis=1)
        at_points[:, mine], slope[:, mine] = element(points[mine]), element.derivative(points[mine])
    v, w = at_points[..., :3], at_points[..., 3:]
    gamma, kappa = strain[..., :3], strain[..., 3:]
    slope[..., :3] += np.cross(AXIS, w)
    turned = np.concatenate([np.cross(kappa, v) + np.cross(gamma, w), np.cross(kappa, w)], axis=-1)
    return {"linearised": slope, "full": slope + turned}


def energy_rates(eta: float, damping: str) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return times, rate of the energy, and the dissipation of AWP (19) or (32), at mid-steps of one second.

    The energy is summed from the recorded fields, too. The midpoint rule keeps the balance to round-off.
    """
    run = hinged(eta).simulate(
        1.0,
        initial="reference",
        formulation="intrinsic",
        damping=damping,
        integrator="midpoint",
        time_step=STEP,
    )
    x1, strain, weight = body_twist(run), run.data["strain"].values, run.data["point_weight"].values
    elastic = 0.5 * np.einsum("kgi,i,g->k", strain**2, STIFFNESS, weight)
    energy = run.energy.kinetic + elastic
    middle = [(values[1:] + values[:-1]) / 2 for values in (run.time, x1, strain)]
    rate = strain_rates(run, *middle[1:])[damping]
    dissipated = np.einsum("kgi,i,g->k", rate**2, eta * STIFFNESS, weight)
    return middle[0], np.diff(energy) / np.diff(run.time), -dissipated


def print_end(name: str, run: vr.Run) -> None:
    """Print the state at the end, and how much it still changes in the last second."""
    energy, last = run.energy, run.time >= run.time[-1] - 1.0
    x1, strain = body_twist(run)[last], run.data["strain"].values[last]
    spin = x1[-1, 0, 3:]
    speed = np.linalg.norm(spin)
    rate = np.abs(strain_rates(run, x1, strain)["full"]).max()
    lost = np.ptp(energy.viscous[last]) / np.ptp(run.time[last])
    momentum = np.linalg.norm(run.data["angular_momentum"].values, axis=1)
    steps = run.data.attrs["steps"]
    print(f"{name}: {steps} steps, mean step {run.time[-1] / steps:.4f} s")
    print(
        f"  E {energy.total[-1]:.8f} J = kinetic {energy.kinetic[-1]:.8f} + stored {energy.elastic[-1]:.3e}"
    )
    print(f"  spin of the base about its axis {spin[2]:.6f}, about all axes {speed:.6f} rad/s")
    print(
        f"  i1 L w^2/2 = {0.5 * INERTIA[5] * spin[2] ** 2:.8f} J; largest strain {np.abs(strain[-1]).max():.2e},",
        f"in the last second: largest strain rate / spin {rate / speed:.2e}, power lost {lost:.2e} W",
    )
    print(
        f"  angular momentum about the joint at 0.5 s {momentum[run.time >= PUSHED][0]:.6f},",
        f"at the end {momentum[-1]:.6f} N m s; kinetic energy / (momentum spin/2)",
        f"{2 * energy.kinetic[-1] / momentum[-1] / speed:.4f}; remainder {energy.numerical_fraction:.1e}",
    )


def print_shares(name: str, run: vr.Run, eta: float, damping: str) -> None:
    """Print the strains in which the energy was lost."""
    rate = strain_rates(run, body_twist(run), run.data["strain"].values)[damping]
    power = eta * STIFFNESS * np.einsum("kgi,g->ki", rate**2, run.data["point_weight"].values)
    loss = np.trapezoid(power, run.time, axis=0)
    shear, stretch, bending, twist = loss[:2].sum(), loss[2], loss[3:5].sum(), loss[5]
    shares = f"shear {shear:.4f}, stretch {stretch:.4f}, bending {bending:.4f}, twist {twist:.4f} J"
    print(f"{name}, lost to viscosity: {shares}; account {run.energy.viscous[-1]:.4f} J")


def draw_energy(runs: dict[tuple[float, str], vr.Run]) -> Figure:
    figure = Figure(figsize=(9.0, 8.0), layout="constrained")
    top, bottom = figure.subfigures(2, 1, height_ratios=(1.0, 1.0))
    axes = top.subplots()
    for (eta, damping), run in runs.items():
        width = 1.1 if damping == "linearised" else 2.6
        label = f"{damping} damping, η = {eta:g} s"
        axes.plot(run.time[1:], run.energy.total[1:], color=COLOURS[eta], lw=width, label=label)
    axes.axvline(PUSHED, color="0.4", ls="--", lw=1.0)
    axes.annotate(
        "torque ends", (PUSHED, 1.0), xycoords=("data", "axes fraction"), xytext=(-4, -10), ha="right",
        textcoords="offset points", fontsize=9, color="0.3",
    )  # fmt: skip
    axes.set(xscale="log", xlim=(0.01, DURATION), ylim=(0, None))
    axes.set_xticks([0.01, 0.1, 1, 10, 50], ["0.01", "0.1", "1", "10", "50"])
    clean(axes, "time [s]", "kinetic + stored energy [J]")
    legend_inside(axes)
    panels = bottom.subplots(1, 2, sharey=True)
    for panel, damping in zip(panels, DAMPINGS, strict=True):
        equation = "(32)" if damping == "linearised" else "(19)"
        for eta, colour in COLOURS.items():
            time, rate, dissipated = energy_rates(eta, damping)
            free = time > PUSHED
            gap = np.abs(rate - dissipated)[free].max() / np.abs(dissipated[free]).max()
            print(f"energy rate, {damping}, eta {eta:g}: after 0.5 s within {gap:.1e} of AWP {equation}")
            panel.plot(time, rate, color=colour, lw=3.2, alpha=0.4)
            panel.plot(time, dissipated, color=colour, lw=1.3, ls=(0, (3, 2)))
        panel.axvline(PUSHED, color="0.4", ls="--", lw=1.0)
        clean(panel, "time [s]", "energy rate [W]" if panel is panels[0] else "")
        heading(panel, f"{damping} damping; dashes: AWP {equation}")
        panel.set(xlim=(0, 1))
    return figure


def in_base_frame(run: vr.Run, steps: slice) -> np.ndarray:
    """Return the positions of the stations in the axes of the cross section at the joint."""
    turn = matrices(np.ascontiguousarray(run.data["rotation"].values[steps, 0]))
    position = run.data["position"].values[steps]
    return np.einsum("kji,ksj->ksi", turn, position - position[:, :1])


def draw_snapshots(runs: dict[tuple[float, str], vr.Run]) -> Figure:
    figure = Figure(figsize=(10.0, 8.2))
    figure.subplots_adjust(left=0.0, right=0.96, bottom=0.03, top=0.94, wspace=0.04, hspace=0.12)
    floor, shown = -0.3, 50
    for row, damping in enumerate(DAMPINGS):
        run = runs[0.001, damping]
        interval = run.time[1] - run.time[0]
        stride = round(0.1 / interval)
        for column in range(3):
            axes = figure.add_subplot(2, 3, 3 * row + column + 1, projection="3d", proj_type="ortho")
            first = round(5 * column / interval)
            shapes = in_base_frame(run, slice(first, first + shown * stride + 1))
            axes.plot(shapes[:, -1, 0], shapes[:, -1, 1], floor, color=RED, lw=0.9)
            for k, shape in enumerate(shapes[::stride]):
                axes.plot(*shape.T, color=str(0.88 * (1 - k / shown)), lw=1.1)
            axes.set(xlim=(-0.4, 0.4), ylim=(-0.4, 0.4), zlim=(floor, 1))
            axes.set(xticks=(-0.3, 0, 0.3), yticks=(-0.3, 0, 0.3), zticks=(0, 0.5, 1))
            axes.set(xlabel="d1 [m]", ylabel="d2 [m]", zlabel="d3 [m]")
            axes.tick_params(labelsize=8, pad=0)
            axes.set_box_aspect((0.8, 0.8, 1.3), zoom=0.98)
            axes.view_init(elev=22, azim=-50)
            title = f"{damping} damping, {5 * column} to {5 * column + 5} s"
            axes.text2D(0.5, 1.04, title, transform=axes.transAxes, ha="center", fontsize=11)
    return figure


def main() -> None:
    runs = {(eta, d): motion(eta, d, output_interval=0.005) for eta in COLOURS for d in DAMPINGS}
    for (eta, damping), run in runs.items():
        print_end(f"eta {eta:g}, {damping}", run)
        print_shares(f"eta {eta:g}, {damping}", run, eta, damping)
    for eta, damping in runs:
        fine = motion(eta, damping, FINE_MESH, FINE_TOLERANCE, output_interval=0.01)
        print_end(f"eta {eta:g}, {damping}, finer mesh and steps", fine)
    draw_energy(runs).savefig(IMAGES / "awp_hinged_energy.png", dpi=110)
    draw_snapshots(runs).savefig(IMAGES / "awp_hinged_snapshots.png", dpi=110)


if __name__ == "__main__":
    main()
