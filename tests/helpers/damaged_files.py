"""Result files damaged in every way: bytes, pieces, and what h5py can change."""

import h5py
import numpy as np

from viscorod.results.files.checksums import NAME

LONGEST = 4096


def damage_bytes(content, rng):
    """Return a file's content with flipped bits, a zeroed or swapped block, cut or lengthened."""
    data = bytearray(content)
    size = len(data)
    how = rng.integers(6)
    if how == 0:
        for at in rng.integers(size, size=rng.integers(1, 4)):
            data[at] ^= 1 << int(rng.integers(8))
    elif how == 1:
        at, length = rng.integers(size), rng.integers(1, LONGEST)
        data[at : at + length] = bytes(len(data[at : at + length]))
    elif how == 2:
        at, length = rng.integers(size), rng.integers(1, LONGEST)
        data[at : at + length] = rng.bytes(len(data[at : at + length]))
    elif how == 3:
        del data[rng.integers(size) :]
    elif how == 4:  # sectors of a disk change places
        sector = 512
        one, other = (sector * int(k) for k in rng.integers(size // sector, size=2))
        part = bytes(data[one : one + sector])
        data[one : one + sector] = data[other : other + sector]
        data[other : other + sector] = part
    else:
        at, length = rng.integers(size), rng.integers(1, LONGEST)
        del data[at : at + length]
    return bytes(data)


def damage_contents(path, rng):
    """Change a valid file into another valid one, through h5py; the word for how."""
    with h5py.File(path, "r+") as file:
        names = []
        file.visititems(lambda name, item: names.append(name) if isinstance(item, h5py.Dataset) else None)
        changes = [
            _remove,
            _rename,
            _retype,
            _reshape,
            _plant,
            _shuffle,
            _scale,
            _attribute,
            _no_attribute,
            _text,
            _units,
        ]
        change = changes[rng.integers(len(changes))]
        name = names[rng.integers(len(names))]
        try:
            change(file, name, rng)
        except (TypeError, ValueError, OSError, KeyError, OverflowError):
            return ""  # not every change fits every array
        return f"{change.__name__[1:]} {name}"


def unsealed(path):
    """Take the checksums off a file, as one of version 0.1.0 has none."""
    with h5py.File(path, "r+") as file:
        file.attrs.pop(NAME, None)


def _replace(file, name, values):
    attrs = {
        key: value
        for key, value in file[name].attrs.items()
        if key not in ("DIMENSION_LIST", "REFERENCE_LIST", "CLASS", "NAME")
    }
    del file[name]
    file[name] = values
    file[name].attrs.update(attrs)


def _remove(file, name, rng):
    del file[name]


def _rename(file, name, rng):
    file.move(name, name + "x")


def _retype(file, name, rng):
    values = file[name][()]
    kinds = [np.float32, np.int64, np.uint8, np.complex128, h5py.string_dtype(), "S3"]
    kind = kinds[rng.integers(len(kinds))]
    _replace(
        file, name, np.full(np.shape(values), "abc") if kind in kinds[4:] else np.asarray(values).astype(kind)
    )


def _reshape(file, name, rng):
    values = np.asarray(file[name][()])
    shapes = [
        values[..., :-1],
        values[:-1],
        values.ravel(),
        values.T,
        values[None],
        np.repeat(values, 2, axis=0),
    ]
    _replace(file, name, shapes[rng.integers(len(shapes))])


def _plant(file, name, rng):
    values = np.array(file[name][()])
    bad = [np.nan, np.inf, -np.inf, 1e300, -1.0, 0.0]
    values[np.unravel_index(rng.integers(values.size), values.shape)] = bad[rng.integers(len(bad))]
    file[name][...] = values


def _shuffle(file, name, rng):
    values = np.array(file[name][()])
    rng.shuffle(values)
    file[name][...] = values


def _scale(file, name, rng):
    file[name][...] = np.array(file[name][()]) * rng.choice([-1.0, 0.0, 1.1, 1e200])


VALUES = [
    "",
    "{",
    "[]",
    "{}",
    "null",
    "[1, 2]",
    '{"a": 1}',
    "NaN",
    "simulate",
    "sweep",
    -1,
    10**9,
    np.nan,
    np.inf,
    0.0,
    [1.0, 2.0],
    b"\xff",
]


def _attribute(file, name, rng):
    where = file if rng.random() < 0.7 else file[name]
    keys = [key for key in where.attrs if key != NAME]
    key = keys[rng.integers(len(keys))]
    where.attrs[key] = VALUES[rng.integers(len(VALUES))]


def _no_attribute(file, name, rng):
    where = file if rng.random() < 0.7 else file[name]
    keys = [key for key in where.attrs if key != NAME]
    del where.attrs[keys[rng.integers(len(keys))]]


def _text(file, name, rng):
    values = np.array(file[name][()], dtype=object)
    if h5py.check_string_dtype(file[name].dtype) is None:
        raise ValueError
    values[rng.integers(values.size)] = ["", "other", "a\x01b", "beam.end", "\U0001f600"][rng.integers(5)]
    file[name][...] = values


def _units(file, name, rng):
    file[name].attrs[["units", "scale_factor", "_FillValue", "coordinates", "dtype"][rng.integers(5)]] = (
        VALUES[rng.integers(len(VALUES))]
    )
