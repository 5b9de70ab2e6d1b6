"""Whole results of members in the files of their writers: the same arrays, whatever was cut off or damaged is told."""

import io
import json

import numpy as np
import pytest

import viscorod as vr
from helpers.strip import content
from viscorod.casefile.case import case_from_dict
from viscorod.results.files.packed_results import append, packed, unpacked

SHEAR = "materials.rubber.damping.shear_time"
VALUES = {SHEAR: [0.01, 0.02, 0.03]}
KINDS = {
    "simulate": {"duration": 0.1, "output_interval": 0.02},
    "equilibrium": {},
    "modes": {"count": 3},
    "response": {"frequencies": [1.0, 2.0, 5.0], "inputs": ["beam.end fy"], "outputs": ["beam.end uy"]},
}


def strip():
    return case_from_dict(content("simulate", **KINDS["simulate"]))


def computed(folder=None):
    return vr.sweep(strip(), VALUES, fields=True, workers=1, folder=folder)


@pytest.fixture
def folder(tmp_path):
    computed(tmp_path)
    return tmp_path


def results(folder):
    """The file of results; there is one writer."""
    (found,) = (folder / "members").glob("*.results")
    return found


def written(folder):
    """How often each member was written."""
    (lines,) = (folder / "members").glob("*.jsonl")
    names = [json.loads(line)["name"] for line in lines.read_text().splitlines() if line]
    return sorted(names.count(name) for name in set(names))


@pytest.mark.parametrize("kind", KINDS)
def test_every_bit_comes_back(kind):
    sweep = vr.sweep(case_from_dict(content(kind, **KINDS[kind])), {SHEAR: [0.02]}, fields=True, workers=1)
    data = sweep.members[0].result.data
    again = unpacked(packed(data))
    assert again.identical(data)
    assert {name: v.dtype for name, v in again.variables.items()} == {
        name: v.dtype for name, v in data.variables.items()
    }


def test_a_folder_gives_back_whole_results(folder):
    alone, found = computed(), vr.load(folder)
    timed = ("wall_time_s", "loop_time_s")
    for one, other in zip(alone.members, found.members, strict=True):
        left, right = one.result.data.copy(), other.result.data.copy()
        left.attrs, right.attrs = (
            {k: v for k, v in data.attrs.items() if k not in timed} for data in (left, right)
        )
        assert left.identical(right)


def test_numpy_reads_them(folder):
    stored = vr.load(folder).members[1].stored
    part = stored.path.read_bytes()[stored.offset : stored.offset + stored.length]
    with np.load(io.BytesIO(part)) as arrays:
        assert np.array_equal(arrays["array/position"], stored().data["position"].values)


def test_what_the_system_lost_of_the_end_is_computed_again(folder):
    whole = vr.load(folder).members[2].result.data["position"].values
    with results(folder).open("rb+") as file:
        file.truncate(results(folder).stat().st_size - 1)
    assert vr.load(folder).members[2].outcome == "not run"
    again = computed(folder)
    assert written(folder) == [1, 1, 2]
    assert np.array_equal(again.members[2].result.data["position"].values, whole)


def test_what_was_cut_off_before_is_not_read(tmp_path):
    """A killed process left half a result, and its number became that of another one."""
    before = tmp_path / "before"
    computed(before)
    half = packed(computed().members[0].result.data)
    folder = tmp_path / "now"
    (folder / "members").mkdir(parents=True)
    (folder / "members" / results(before).name).write_bytes(
        half[: len(half) // 2]
    )  # this process writes on there
    computed(folder)
    assert vr.load(folder).members[0].stored.offset == len(half) // 2
    assert vr.load(folder).data["position"].equals(computed().data["position"])


@pytest.mark.parametrize("part", np.linspace(0.0, 1.0, 23)[1:-1])
def test_a_flipped_bit_is_told_and_never_read(folder, part):
    """Of any byte: it is refused, or (beside names and numbers, as in dates of the archive) changes nothing."""
    stored = vr.load(folder).members[1].stored
    whole = stored().data
    content = bytearray(stored.path.read_bytes())
    content[stored.offset + int(part * stored.length)] ^= 4
    stored.path.write_bytes(content)
    try:
        found = vr.load(folder).members[1].result.data
    except vr.InputError as error:
        told = str(error)
    else:
        assert found.identical(whole)
        told = ""
    assert not told or "damaged" in told
    assert vr.load(folder).members[0].result is not None


def test_a_result_in_a_file_that_is_gone_is_computed_again(folder):
    results(folder).unlink()
    assert {member.outcome for member in vr.load(folder).members} == {"not run"}
    assert computed(folder).count_completed == 3
    assert written(folder) == [2, 2, 2]


def test_a_disk_without_room_stops_at_that_member(tmp_path, monkeypatch):
    """It is told with its member, what is on disk stays, and the next call computes the rest."""

    def full(path, data):
        if full.left:
            full.left -= 1
            return append(path, data)
        raise OSError(28, "No space left on device")

    full.left = 2
    monkeypatch.setattr("viscorod.results.files.sweep_folder.append", full)
    with pytest.raises(vr.SolveError, match="stopped at member 2: it cannot be kept") as caught:
        computed(tmp_path)
    table = caught.value.run.table()
    assert table["outcome"].tolist() == ["completed", "completed", "not kept"]
    assert "No space left on device" in table["message"][2]
    monkeypatch.undo()
    assert computed(tmp_path).count_completed == 3
    assert written(tmp_path) == [1, 1, 1]


def test_folders_of_earlier_versions_open(folder):
    """Their results were netCDF files by the names of their members."""
    (lines,) = (folder / "members").glob("*.jsonl")
    before = vr.load(folder)
    position = before.data["position"].load()
    texts = []
    for member, line in zip(before.members, filter(None, lines.read_text().splitlines()), strict=True):
        record = json.loads(line)
        member.result.save(folder / "members" / f"{record['name']}.nc")
        del record["result"]
        texts.append(json.dumps(record | {"file": True}))
    lines.write_text("\n".join(texts) + "\n")
    results(folder).unlink()
    assert vr.load(folder).data["position"].equals(position)
