"""What some documents take from their reader, made up: a decay, a hit, moduli of a polymer, the case of a strip."""

import numpy as np

from helpers.strip import content
from viscorod.casefile.toml_text import toml_text

MODES = ((52.3, 6e-4, 1.0), (143.7, 4e-4, -0.7))
"""Of the bar that is hit: natural frequency [Hz], damping ratio, size."""


def write_decay(path):
    """A tip in mm that is released at 0.4 s and swings at 2.9 Hz with a damping ratio of 0.032."""
    times = np.arange(0.0, 5.0, 0.01)
    since = np.maximum(times - 0.4, 0.0)
    omega = 2.0 * np.pi * 2.9
    swing = np.exp(-0.032 * omega * since) * np.cos(omega * since)
    tip = 24.0 + 17.3 * swing + 0.03 * np.random.default_rng(1).normal(size=times.size)
    np.savetxt(path, np.c_[times, tip], delimiter=",", header="t [s],tip_y [mm]", comments="")


def write_hit(path):
    """Two responses of a bar to a hit at its first node, with lines of 1 Hz."""
    import pyuff

    times = np.arange(1000) / 1000.0
    file = pyuff.UFF(str(path))
    for node in (1, 2):
        values = np.zeros(len(times))
        for frequency, ratio, size in MODES:
            omega = 2.0 * np.pi * frequency
            values += size**node * np.exp(-ratio * omega * times) * np.sin(omega * times)
        noise = np.random.default_rng(node).normal(size=(2, 500)) * 2e-4
        lines = np.fft.rfft(values)[:500] / 1000.0 + noise[0] + 1j * noise[1]
        response = pyuff.prepare_58(
            func_type=4, rsp_node=1, rsp_dir=3, ref_node=node, ref_dir=3, data=lines, x=np.arange(500.0), id1="hit",
            rsp_ent_name="NONE", ref_ent_name="NONE", abscissa_spacing=1, abscissa_inc=1.0, ord_data_type=6,
            ordinate_spec_data_type=12, orddenom_spec_data_type=13, abscissa_spec_data_type=18,
        )  # fmt: skip
        file.write_sets(response, "overwrite" if node == 1 else "add")


def write_sweeps(path):
    """Moduli of a polymer at six temperatures: a broad loss peak, times by Williams, Landel and Ferry."""
    rows = []
    times = 10.0 ** np.arange(-10.0, 6.0, 0.5)
    parts = 1.2e8 * np.exp(-0.5 * ((np.log10(times) + 1.0) / 2.5) ** 2)
    for celsius in (46.0, 53.0, 60.0, 67.0, 74.0, 81.0):
        shift = 10.0 ** (-12.0 * (celsius - 60.0) / (70.0 + celsius - 60.0))
        for hertz in np.geomspace(0.1, 30.0, 8):
            reach = 2j * np.pi * hertz * times * shift
            modulus = 3e6 + (parts * reach / (1.0 + reach)).sum()
            rows.append(f"{hertz},{modulus.real * 1e-6},{modulus.imag * 1e-6},{celsius}")
    path.write_text("f (Hz),E' (MPa),E'' (MPa),T (C)\n" + "\n".join(rows) + "\n")


def write_files(folder):
    """Write all of them under the names that the documents use."""
    write_decay(folder / "trial.csv")
    write_decay(folder / "trial_3.csv")
    write_hit(folder / "hit.uff")
    write_hit(folder / "shaker.uff")
    write_sweeps(folder / "sweeps.csv")
    (folder / "beam.toml").write_text(toml_text(content("simulate", duration=1.0)))


STRIP = """
title = "Aluminium strip"
materials.aluminium = { youngs_modulus = "70 GPa", poissons_ratio = 0.33, density = 2700 }
bodies.sensor = { shape = "box", sides = [0.01, 0.01, 0.005], centre = [0.3, 0, 0], mass = 0.005 }
attachments = [{ a = "strip.end", b = "sensor" }]
supports = [{ kind = "pin", at = "strip.start" }]
springs = [{ at = "strip.start", stiffness = { rx = 1e6, ry = 1e6, rz = 1e6 } }]
modes = { count = 2 }
[rods.strip]
shape = "straight"
start = [0, 0, 0]
end = [0.3, 0, 0]
d1 = [0, 1, 0]
section = { shape = "rectangle", width = 0.05, height = 0.002 }
material = "aluminium"
elements = 1
order = 4
"""
"""A strip in a vise, which turns a little there, with a sensor at its free end."""


def write_lengths(folder, frequencies, sought):
    """Write the strip and a fit of its two bending frequencies at several free lengths, by length in m."""
    (folder / "strip.toml").write_text(STRIP)
    lines = ['case = "strip.toml"', "[parameters]", *(f'"{key}" = {start}' for key, start in sought.items())]
    for length, hertz in frequencies.items():
        lines += [
            "[[records]]",
            'kind = "modes"',
            f'name = "{100.0 * length:g} cm"',
            f'set = {{ "rods.strip.end[0]" = {length}, "bodies.sensor.centre[0]" = {length} }}',
            f"frequencies = {list(map(float, hertz))}",
            "modes = [1, 2]",
        ]
    (folder / "lengths.toml").write_text("\n".join(lines) + "\n")
    return folder / "lengths.toml"
