"""Functions about measurements with values of wrong kinds: one message, or an answer."""

import numpy as np
import pytest

import viscorod as vr
from viscorod.records.record_table import record_of

SAMPLES = np.arange(0.0, 9.0, 0.17)


def record(**more):
    given = {"values": np.zeros_like(SAMPLES), "place": "beam.end", "quantity": "position", "direction": "y"}
    return vr.Record(SAMPLES, **(given | more))


WRONG = {
    "none": None, "true": True, "fraction": 1.5, "nan": float("nan"), "denormal": 5e-324, "text": "",
    "surrogate": "\ud800",
    "nul": "a\0b", "bytes": b"x", "empty": [], "words": ["x"], "nones": [None], "table": {"a": 1}, "object": object(),
    "huge": 10**400, "complex": 1j, "array": np.array([1.0, np.nan]),
    "array of text": np.array("x"), "nested": [[1, 2], [3]],
}  # fmt: skip


def described():
    """Functions about measurements with arguments that are right."""
    times = np.arange(64) * 0.1
    tip = record(unknown=["offset"])
    hertz = np.arange(1.0, 40.0)
    peak = 1.0 / (20.0**2 - hertz**2 + 0.5j * hertz)
    static = {
        "loads": [1.0, 2.0],
        "values": [1.0, 2.0],
        "place": "a.end",
        "direction": "x",
        "full_load": 1.0,
        "noise": 1.0,
    }
    return {
        "record": (record, {"values": SAMPLES, "quantity": "velocity", "direction": "x", "lever": (0, 0, 1)}),
        "window": (tip.window, {"start": 0.0, "end": 5.0}),
        "noise": (tip.with_noise_of, {"start": 0.0, "end": 5.0}),
        "decimated": (tip.decimated, {"factor": 2}),
        "predicted": (tip.predicted, {"result": None, "nuisances": {}}),
        "measured": (tip.measured, {"raw": SAMPLES, "nuisances": {}}),
        "response": (vr.ResponseRecord, {"frequencies": hertz, "values": peak, "unknown": [], "name": "a"}),
        "modes": (vr.ModesRecord, {"frequencies": [1.0], "damping_ratios": [0.1], "modes": [1], "name": "a"}),
        "static": (vr.StaticRecord, static),
        "moduli": (vr.ModuliRecord, {"frequencies": [1.0], "storage": [1.0], "loss": [1.0], "of": "shear"}),
        "unknown": (vr.Unknown, {"name": "gain", "start": 1.0, "deviation": 0.1, "low": 0.0, "high": 2.0}),
        "decay": (vr.decay, {"source": times, "values": np.cos(times * 6.0), "start": 0.0, "end": 6.0, "modes": 1}),
        "modal_fit": (vr.modal_fit, {"records": vr.ResponseRecord(hertz, peak), "band": (1.0, 39.0)}),
        "master_curve": (vr.master_curve, {"files": [], "reference": 1.0, "band": (1.0, 2.0), "law_range": (1.0, 2.0)}),
        "table": (record_of, {"table": {"kind": "moduli", "storage": [1.0]}, "folder": "."}),
    }  # fmt: skip


@pytest.mark.parametrize("name", described())
def test_wrong_arguments_get_a_message(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    function, good = described()[name]
    refused = 0
    for argument in good:
        for wrong in WRONG.values():
            try:
                function(**{**good, argument: wrong})
            except vr.InputError as error:
                refused += bool(str(error).encode("utf-8"))
    assert refused > 10
