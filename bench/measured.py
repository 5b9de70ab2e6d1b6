"""What viscorod makes of five public measurements, by its public functions alone.

``python bench/measured.py FOLDER [NAME ...]`` reads the measurements from subfolders of FOLDER and prints the figures:

* eth_silicone_bar (github.com/srl-ethz/diffPD_sim2real): laws fitted to the unloaded trials foretell the loaded ones;
* pyuff_freefree_frf (github.com/ladisk/pyuff): six modes narrower than the lines, and what can be the material's;
* enes_aluminium_cantilever (github.com/EnesDemirkaya/Vibration-Tester-ADXL357-FFT): modulus with the sensor's mass or
  the clamp's compliance;
* nrel_dma (github.com/NREL/pyvisco), mahdi_dma_tension (github.com/MahdiTBT/DMA-analysis-suite): master curves, and a
  strip of the second material that swings at 20 and 60 degrees C.

With ``--hanging`` the weight of the silicone bar hangs on a ball joint instead of being fixed to it.
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path

import numpy as np

import viscorod as vr
from viscorod.casefile.case import case_from_dict

YOUNG = "materials.silicone.youngs_modulus"
LAWS = ["kelvin_voigt", "flat_loss", "branches 2"]


def bar(weight: float = 0.0, hanging: bool = False):
    """The bar of silicone, clamped, horizontal, x up; the hand is a force until the release."""
    silicone = {"youngs_modulus": 3e5, "poissons_ratio": 0.499, "density": 1070.0}
    rod = {
        "shape": "straight",
        "start": [0.0, 0.0, 0.0],
        "end": [0.0, 0.0, 0.1],
        "d1": [1.0, 0.0, 0.0],
        "section": {"shape": "rectangle", "width": 0.03, "height": 0.03},
        "material": "silicone",
        "elements": 1,
        "order": 4,
    }
    content = {
        "title": "Silicone bar",
        "materials": {"silicone": silicone},
        "rods": {"bar": rod},
        "supports": [{"kind": "clamp", "at": "bar.start"}],
        "loads": [
            {"kind": "gravity", "acceleration": [-9.81, 0.0, 0.0]},
            {"kind": "force", "at": "bar.end", "value": [0.2, 0.0, 0.0], "until": 0.0},
        ],
        "simulate": {"duration": 2.0, "tolerance": 2e-5},
    }
    if weight:
        low = [0.015 - 0.02, 0.0, 0.1] if hanging else [0.015, 0.0, 0.1]
        content["bodies"] = {
            "weight": {
                "shape": "sphere",
                "centre": low,
                "radius": 0.005,
                "mass": weight / 9.81,
                "points": {"hook": [0.015, 0.0, 0.1]},
            },
            "edge": {"shape": "sphere", "centre": [0.015, 0.0, 0.1], "radius": 0.001, "mass": 1e-5},
        }
        content["attachments"] = [{"a": "bar.end", "b": "edge"}]
        if hanging:
            content["joints"] = [{"kind": "ball", "a": "edge", "b": "weight.hook", "name": "hook"}]
        else:
            content["attachments"].append({"a": "bar.end", "b": "weight"})
    return case_from_dict(content)


def trial(file: Path, name: str, first: int, begin: float, unknown=()):
    """A marker 6 mm above the top edge of the tip; where the bar is before the release counts as straight."""
    about = {"place": "bar.end", "quantity": "position", "direction": "x"}
    raw = vr.Record.read(file, "tip1_x", time="t", **about)
    released = float(raw.times[first])
    free = vr.Record(
        raw.times,
        raw.values - raw.values[0] + 0.021,
        lever=(0.021, 0.0, 0.0),
        noise=1e-5,
        name=name,
        unknown=[
            "drift",
            vr.Unknown("release_time", released, low=released - 0.03, high=released + 0.02),
            vr.Unknown("offset", 0.0, low=-0.01, high=0.01),
            vr.Unknown("hand", 0.2, low=-1.5, high=1.5, key="loads[1].value[0]"),
            *unknown,
        ],
        **about,
    )
    return free.window(released + begin, released + 2.0)


def silicone_bar(folder: Path, hanging: bool) -> None:
    unloaded = [
        trial(folder / f"beam_gravity_V2_{name}.csv", name, first, 0.0)
        for name, first in (("a", 71), ("b", 65))
    ]
    loaded = bar(0.51012, hanging)
    place = vr.Unknown("weight_along", 0.1, deviation=0.002, key="bodies.weight.centre[2]")
    left_out = [
        (
            loaded,
            trial(
                folder / f"beam_load52_V2_{name}.csv", f"52 g {name}", first, 0.1, [] if hanging else [place]
            ),
        )
        for name, first in (("a", 44), ("b", 58))
    ]
    fit = vr.identify(
        bar(), unloaded, {YOUNG: 3e5}, laws=LAWS, left_out=left_out, profile=False, report=print
    )
    print(fit.report().split("The damping in the numbers")[0])


def free_beam(folder: Path, _hanging: bool) -> None:
    """Files of one complex number a line, of 0, 1, ... Hz."""
    records = [
        vr.ResponseRecord(
            np.arange(1.0, 1001.0),
            np.loadtxt(folder / f"meas_point_{k}.txt", dtype=complex)[1:],
            name=f"point {k}",
        )
        for k in (1, 2)
    ]
    found = vr.modal_fit(records, title="free-free beam")
    print(found)
    slope = np.polyfit(np.log(found.frequencies), np.log(found.damping_ratios), 1)[0]
    print(
        f"the ratios go with the frequency to the power of {slope:.2f}; Kelvin and Voigt: 1, a flat loss: 0"
    )


def aluminium_strip(folder: Path, _hanging: bool) -> None:
    rows = np.loadtxt(folder / "points_data.csv", delimiter=",", skiprows=1)

    def strip(length: float, turning: float | None):
        material = {"youngs_modulus": 70e9, "poissons_ratio": 0.33, "density": 2700.0}
        rod = {
            "shape": "straight",
            "start": [0.0, 0.0, 0.0],
            "end": [length, 0.0, 0.0],
            "d1": [0.0, 1.0, 0.0],
            "section": {"shape": "rectangle", "width": 0.05, "height": 0.002},
            "material": "aluminium",
            "elements": 2,
            "order": 4,
        }
        sensor = {"shape": "box", "sides": [0.01, 0.01, 0.005], "centre": [length, 0.0, 0.0], "mass": 0.005}
        content = {
            "title": "Aluminium strip",
            "materials": {"aluminium": material},
            "rods": {"strip": rod},
            "bodies": {"sensor": sensor},
            "attachments": [{"a": "strip.end", "b": "sensor"}],
            "supports": [{"kind": "clamp" if turning is None else "pin", "at": "strip.start"}],
            "modes": {"count": 2},
        }
        if turning is not None:
            content["springs"] = [{"at": "strip.start", "stiffness": {"rx": 1e6, "ry": turning, "rz": 1e6}}]
        return case_from_dict(content)

    young, mass, turn = "materials.aluminium.youngs_modulus", "bodies.sensor.mass", "springs[0].stiffness.ry"
    for title, turning, sought in (
        ("E", None, [young]),
        ("E and the mass of the sensor", None, [young, mass]),
        ("E and the compliance of the clamp", 800.0, [young, turn]),
    ):
        pairs = []
        for centimetres in sorted(set(rows[:, 0])):
            mine = rows[rows[:, 0] == centimetres]
            names = [f"bend_1 {int(mode)}" for mode in mine[:, 2]]
            record = vr.ModesRecord(mine[:, 1], modes=names, name=f"{centimetres:g} cm")
            pairs.append((strip(centimetres / 100.0, turning), record))
        fit = vr.identify(pairs, parameters=sought)
        off = fit.residuals / fit.data["measured"].values
        print(f"-- {title}: {100.0 * np.sqrt(np.mean(off**2)):.2g} % left over")
        for one in fit.numbers.values():
            print(f"{one.name}: {one.value:.5g} ({one.low:.5g} to {one.high:.5g}) {one.unit}")
        print("\n".join(fit.sentences))


def polymer(folder: Path, _hanging: bool) -> None:
    master = vr.master_curve(folder / "freq_user_raw.csv", title="NREL")
    print(master)


def loss_factor_measured(master, celsius: float, hertz: float) -> float:
    """Return that of the sweeps at a frequency, straight between the temperatures of two."""
    found = []
    for number, decades in enumerate(master.log_shifts):
        mine = master.data.isel(point=master.data.point_sweep.values == number)
        own = mine.frequency.values * 10.0**-decades
        found.append(np.interp(hertz, own, mine.loss.values / mine.storage.values))
    return float(np.interp(celsius, master.temperatures, found))


def strip_at_temperatures(folder: Path, _hanging: bool) -> None:
    files = sorted(folder.glob("T*.txt"), key=lambda one: float(one.stem[1:]))
    master = vr.master_curve(files, title="tension")
    print(master)
    for celsius in (20.0, 60.0):
        model = vr.Model()
        material = vr.Material(**master.material(celsius, density=1200.0, poissons_ratio=0.4))
        strip = vr.Rod(vr.Straight((0.0, 0.0, 0.0), (0.15, 0.0, 0.0)), vr.Rectangle(0.02, 0.002), material)
        model.add("strip", strip)
        model.clamp("strip.start")
        model.force("strip.end", (0.0, 0.0, 0.5), until=0.0)
        run = model.simulate(0.6)
        found = vr.decay(run, place="strip.end", direction="z", modes=1)
        hertz, ratio = found.frequencies[0], found.damping_ratios[0]
        modulus = material.relaxation("extension").complex_modulus(np.array([2.0 * np.pi * hertz]))[0]
        print(
            f"strip of 150 x 20 x 2 mm at {celsius:g} C: {hertz:.4g} Hz, damping ratio {ratio:.4g}; half of the loss "
            f"factor of the material there {0.5 * modulus.imag / modulus.real:.4g}, of the sweeps "
            f"{0.5 * loss_factor_measured(master, celsius, hertz):.4g}"
        )


ALL = {
    "eth_silicone_bar": silicone_bar,
    "pyuff_freefree_frf": free_beam,
    "enes_aluminium_cantilever": aluminium_strip,
    "nrel_dma": polymer,
    "mahdi_dma_tension": strip_at_temperatures,
}


def main() -> None:
    reader = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    reader.add_argument("folder", type=Path)
    reader.add_argument("names", nargs="*", choices=[*ALL, []], default=[])
    reader.add_argument("--hanging", action="store_true")
    given = reader.parse_args()
    for name in given.names or ALL:
        print(f"==== {name}")
        began = time.process_time()
        ALL[name](given.folder / name, given.hanging)
        print(f"{time.process_time() - began:.1f} s of processor time\n")


if __name__ == "__main__":
    main()
