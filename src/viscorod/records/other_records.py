"""Records of other kinds: frequency responses, frequencies with damping ratios, static loads, moduli."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, ClassVar

import numpy as np

from viscorod.errors import Fault, InputError
from viscorod.limits import SMALLEST_NUMBER
from viscorod.model.materials.dma_table import read_dma_table
from viscorod.records.any_record import AnyRecord, deviations, finite, increasing
from viscorod.records.arguments import described
from viscorod.records.columns import si_size
from viscorod.records.other_files import columns_of
from viscorod.records.read_off import QUANTITIES, Direction, strain_along
from viscorod.records.unknown import Unknown
from viscorod.typing import Floats

__all__ = ["ModesRecord", "ModuliRecord", "ResponseRecord", "StaticRecord"]


NORMAL = 1.959963984540054
"""Standard deviations of half of a 95 % interval."""


def _complex(where: str, values: Any) -> np.ndarray:
    """Return complex numbers in one row."""
    try:
        given = np.asarray(values)
    except ValueError:
        given = np.empty(0, dtype=object)
    if given.dtype.kind not in "fiuc" or given.ndim != 1:
        raise InputError(Fault(where, "", "these are no complex numbers in one row", "give a list of them"))
    return given


class ResponseRecord(AnyRecord):
    """A frequency response that was measured: output over input, complex, exp(i omega t).

    Args:
        frequencies: increasing, Hz (n,).
        values: complex, SI units of output over input (n,).
        output, source: words or numbers of the output and the input of the model's response.
        noise: standard deviation of real and imaginary part, one number or (n,); None where it is not known.
        unknown: "gain", "delay" (s, by which the output comes late).
        name: of the record.

    Attributes:
        observed: real parts, then imaginary parts (2 n,).

    Raises:
        InputError: numbers, words or shapes are wrong.
    """

    kind: ClassVar[str] = "response"
    analysis: ClassVar[str] = "response"

    @described
    def __init__(
        self,
        frequencies: Any,
        values: Any,
        *,
        output: str | int = 0,
        source: str | int = 0,
        noise: Any = None,
        unknown: Sequence[str | Unknown] = (),
        name: str = "response",
    ) -> None:
        where = f"record {name}"
        self.frequencies = increasing(f"{where}: frequencies", frequencies)
        given = _complex(f"{where}: values", values)
        self.observed = finite(f"{where}: values", np.concatenate([np.real(given), np.imag(given)], axis=0))
        if len(self.observed) != 2 * len(self.frequencies):
            raise InputError(
                Fault(
                    where,
                    f"{len(self.observed) // 2} values",
                    f"there are {len(self.frequencies)} frequencies",
                    "",
                )
            )
        if self.frequencies[0] < 0.0:
            raise InputError(
                Fault(f"{where}: frequencies", "", "a frequency is negative", "give the positive ones")
            )
        self.output, self.source = output, source
        one = deviations(f"{where}: noise", noise, self.frequencies.shape)
        self.noise = None if one is None else np.concatenate([one, one])
        step = float(np.min(np.diff(self.frequencies))) if len(self.frequencies) > 1 else 1.0
        self._named(name, unknown, {"gain": (1.0, 1e-3, 1e3), "delay": (0.0, -0.25 / step, 0.25 / step)})

    @classmethod
    @described
    def read(
        cls,
        source: Any,
        value: str | int | Sequence[str | int],
        *,
        frequency: str | int = 1,
        unit: str | None = None,
        frequency_unit: str | None = None,
        **more: Any,
    ) -> ResponseRecord:
        """Return a response from columns of a file, or of an object of xarray or pandas; see `Record.read`.

        Args:
            source: path or object.
            value: a complex column, or real and imaginary part as two.
            frequency: column of the frequencies, by name or number from 1.
            unit: of output over input, such as "m/s^2/N", where the source does not say.
            frequency_unit: where the source does not say.
            more: all else that a `ResponseRecord` has.

        Raises:
            InputError: it cannot be read, a column or a unit is missing.
        """
        columns = columns_of(source)
        parts = [value] if isinstance(value, str | int) else list(value)
        places = [columns.number("value", part) for part in parts]
        if len(places) > 2:
            raise InputError(
                Fault("value", repr(value), "too many columns", "give one complex, or two real ones")
            )
        written = {columns.units[k] for k in places} if unit is None else {unit}
        if written == {None} or len(written) > 1:
            raise InputError(
                Fault(
                    f"{columns.source}: value",
                    repr(value),
                    "its unit is not known",
                    "give unit, such as 'm/s^2/N'",
                )
            )
        size = si_size(columns.source, "value", str(written.pop()))
        values = columns.values[:, places[0]] + (
            1j * columns.values[:, places[1]] if len(places) > 1 else 0.0
        )
        return cls(columns.si("frequency", frequency, "Hz", frequency_unit), size * values, **more)

    @property
    def values(self) -> np.ndarray:
        """The complex responses (n,)."""
        count = len(self.frequencies)
        found: np.ndarray = self.observed[:count] + 1j * self.observed[count:]
        return found

    @described
    def predicted(self, result: Any, nuisances: Mapping[str, float] | None = None) -> Floats:
        """Return what a `FrequencyResponse` says (2 n,), straight lines between its frequencies; see `AnyRecord`."""
        self._needs(result, "response")
        hertz = np.asarray(result.frequencies, dtype=float)
        mine = self.frequencies
        slack = 1e-9 * hertz[-1]
        if mine[0] < hertz[0] - slack or mine[-1] > hertz[-1] + slack:
            raise InputError(
                f"record {self.name}: it goes from {mine[0]:.6g} to {mine[-1]:.6g} Hz, and the response from "
                f"{hertz[0]:.6g} to {hertz[-1]:.6g} Hz; compute it over the band of the record"
            )
        response = np.asarray(result.response(self.output, self.source))
        values = self.values_of(nuisances)
        model = np.interp(mine, hertz, response.real) + 1j * np.interp(mine, hertz, response.imag)
        shown = self.nuisance("gain", values, 1.0) * model
        shown = shown * np.exp(-2j * np.pi * mine * self.nuisance("delay", values))
        return np.concatenate([shown.real, shown.imag])


class ModesRecord(AnyRecord):
    """A table of measured natural frequencies, with damping ratios or without.

    Args:
        frequencies: Hz (n,).
        damping_ratios: as many, or None.
        modes: which modes of the model they are, numbers from 1 or names such as "bend_1 2"; by default the first ones
            in their order, rigid motions left out.
        frequency_noise, ratio_noise: standard deviations, Hz and 1, one number or (n,); None where they are not known.
        unknown: "clock" (factor on frequencies); others with the key of a number of the case.
        name: of the record.

    Attributes:
        observed: frequencies, then damping ratios.

    Raises:
        InputError: numbers, words or shapes are wrong.
    """

    kind: ClassVar[str] = "modes"
    analysis: ClassVar[str] = "modes"

    @described
    def __init__(
        self,
        frequencies: Any,
        damping_ratios: Any = None,
        *,
        modes: Sequence[int | str] | None = None,
        frequency_noise: Any = None,
        ratio_noise: Any = None,
        unknown: Sequence[str | Unknown] = (),
        name: str = "modes",
    ) -> None:
        where = f"record {name}"
        self.frequencies = finite(f"{where}: frequencies", frequencies)
        if not (self.frequencies > 0.0).all():
            raise InputError(
                Fault(f"{where}: frequencies", "", "frequencies are positive", "leave rigid motions out")
            )
        count = len(self.frequencies)
        self.damping_ratios = None
        if damping_ratios is not None:
            self.damping_ratios = finite(f"{where}: damping_ratios", damping_ratios)
            if len(self.damping_ratios) != count or not (np.abs(self.damping_ratios) < 1.0).all():
                raise InputError(
                    Fault(
                        f"{where}: damping_ratios",
                        "",
                        f"{count} numbers below 1 are needed",
                        "0.01 is one per cent",
                    )
                )
        if modes is not None and (isinstance(modes, str | bytes) or not isinstance(modes, Sequence)):
            raise InputError(
                Fault(f"{where}: modes", type(modes).__name__, "no list of modes", "give [1, 2, 3]")
            )
        self.modes = tuple(range(1, count + 1)) if modes is None else tuple(modes)
        if len(self.modes) != count or len(set(map(str, self.modes))) != count:
            raise InputError(
                Fault(f"{where}: modes", str(self.modes), f"{count} different modes are needed", "")
            )
        for one in self.modes:
            if isinstance(one, bool) or not (isinstance(one, str) or (isinstance(one, int) and one >= 1)):
                raise InputError(
                    Fault(
                        f"{where}: modes",
                        repr(one),
                        "no mode",
                        "give its number from 1, or its name 'bend_1 2'",
                    )
                )
        self.observed = self.frequencies
        noise = [deviations(f"{where}: frequency_noise", frequency_noise, (count,))]
        if self.damping_ratios is not None:
            self.observed = np.concatenate([self.frequencies, self.damping_ratios])
            noise.append(deviations(f"{where}: ratio_noise", ratio_noise, (count,)))
        known = [part for part in noise if part is not None]
        if known and len(known) < len(noise):
            raise InputError(
                Fault(
                    where, "", "the noise of frequencies and of ratios go together", "give both, or neither"
                )
            )
        self.noise = np.concatenate(known) if known else None
        self._named(name, unknown, {"clock": (1.0, 0.5, 2.0)})

    @classmethod
    @described
    def of(cls, found: Any, **more: Any) -> ModesRecord:
        """Return the modes of a `Decay` or a `ModalFit` as a record, with the noise that their intervals mean.

        Args:
            found: the result.
            more: all else that a record has: modes, unknown, name.

        Raises:
            InputError: it is no such result.
        """
        if getattr(found, "kind", "") not in ("decay", "modal_fit"):
            raise InputError(
                Fault("found", type(found).__name__, "it has no measured modes", "give a Decay or ModalFit")
            )
        widths = [found.data[f"{name}_width"].values / NORMAL for name in ("frequency", "damping_ratio")]
        return cls(
            found.frequencies, found.damping_ratios, frequency_noise=widths[0], ratio_noise=widths[1], **more
        )

    @described
    def predicted(self, result: Any, nuisances: Mapping[str, float] | None = None) -> Floats:
        """Return frequencies, and damping ratios if the record has them, of a result of `modes`; see `AnyRecord`."""
        self._needs(result, "modes")
        at = self.places_in(result)
        values = self.values_of(nuisances)
        hertz = np.asarray(result.frequencies)[at] * self.nuisance("clock", values, 1.0)
        if self.damping_ratios is None:
            return np.asarray(hertz)
        return np.concatenate([hertz, np.asarray(result.damping_ratios)[at]])

    def places_in(self, result: Any) -> list[int]:
        """Return the places of the record's modes among those of a result.

        Raises:
            InputError: the result has too few modes, or none of a name.
        """
        names = list(result.names)
        found = []
        for one in self.modes:
            if isinstance(one, str):
                if one not in names:
                    raise InputError(
                        f"record {self.name}: no mode is called {one!r}; there are {', '.join(names)}"
                    )
                found.append(names.index(one))
            else:
                found.append(int(result.rigid) + one - 1)
        if max(found) >= len(names):
            raise InputError(
                f"record {self.name}: it has mode {max(found) + 1}, and the result {len(names)} modes; ask for more"
            )
        return found


class StaticRecord(AnyRecord):
    """Static loads with what they moved: one number at a place for each load.

    Args:
        loads: increasing, N or N m (n,).
        values: SI (n,).
        full_load: the load of the case at load factor 1, in the same unit; left out, `loads` are load factors.
        place, quantity, direction: as of a `Record`, without velocities and accelerations.
        noise: standard deviation, SI, one number or (n,); None where it is not known.
        unknown: "offset", "gain".
        name: of the record; by default its place.

    Raises:
        InputError: numbers, words or shapes are wrong.
    """

    kind: ClassVar[str] = "static"
    analysis: ClassVar[str] = "equilibrium"

    @described
    def __init__(
        self,
        loads: Any,
        values: Any,
        *,
        place: str,
        direction: Direction,
        quantity: str = "displacement",
        full_load: float = 1.0,
        noise: Any = None,
        unknown: Sequence[str | Unknown] = (),
        name: str | None = None,
    ) -> None:
        where = f"record {name or place}"
        self.loads = increasing(f"{where}: loads", loads)
        self.values = self.observed = finite(f"{where}: values", values)
        if len(self.values) != len(self.loads):
            raise InputError(
                Fault(
                    where, f"{len(self.values)} values", f"there are {len(self.loads)} loads", "give as many"
                )
            )
        if not abs(full_load) > SMALLEST_NUMBER:
            raise InputError(
                Fault(f"{where}: full_load", f"{full_load:g}", "no load", "give the load at factor 1")
            )
        self.load_factors = self.loads / full_load
        if quantity not in ("position", "displacement", "strain", "force"):
            raise InputError(
                Fault(f"{where}: quantity", repr(quantity), "nothing at rest has it",
                      "use one of position, displacement, strain, force")
            )  # fmt: skip
        self.place, self.quantity = place, quantity
        self.direction = QUANTITIES[quantity].direction(f"{where}: direction", direction)
        self.noise = deviations(f"{where}: noise", noise, self.values.shape)
        reach = float(np.abs(self.values).max()) or 1.0
        self._named(
            name or place, unknown, {"offset": (0.0, -1e3 * reach, 1e3 * reach), "gain": (1.0, 0.1, 10.0)}
        )

    @described
    def predicted(self, result: Any, nuisances: Mapping[str, float] | None = None) -> Floats:
        """Return what an `Equilibrium` says at the loads (n,), straight lines between its states; see `AnyRecord`."""
        self._needs(result, "equilibrium")
        known = np.asarray(result.load_factor, dtype=float)
        low, high = float(self.load_factors.min()), float(self.load_factors.max())
        if low < known.min() - 1e-9 or high > known.max() + 1e-9:
            raise InputError(
                f"record {self.name}: its loads are {low:.6g} to {high:.6g} of the full load, and the equilibria "
                f"{known.min():.6g} to {known.max():.6g}; ask for all of them (load_factor, steps)"
            )
        found = result.probe(self.place).isel(place=0)
        if self.quantity == "strain":
            model = strain_along(found, self.direction, np.zeros(3))
        else:
            vectors = found["section_force" if self.quantity == "force" else self.quantity].values[:, :3]
            if self.quantity == "force":
                vectors = np.einsum("tij,tj->ti", found["frame"].values, vectors)
            model = vectors @ np.asarray(self.direction)
        order = np.argsort(known, kind="stable")
        values = self.values_of(nuisances)
        shown: Floats = np.interp(self.load_factors, known[order], np.asarray(model)[order])
        return self.nuisance("gain", values, 1.0) * shown + self.nuisance("offset", values)


class ModuliRecord(AnyRecord):
    """Storage and loss modulus of a material over frequency (dynamic mechanical analysis).

    Args:
        frequencies: Hz (n,).
        storage, loss: moduli, Pa (n,).
        of: "extension" or "shear".
        relative_noise: standard deviation of each, as a part of the size of the complex modulus; None where not known.
        unknown: "gain" (of the sample's dimensions).
        name: of the record.

    Attributes:
        observed: storage moduli, then loss moduli (2 n,).

    Raises:
        InputError: numbers or shapes are wrong.
    """

    kind: ClassVar[str] = "moduli"
    analysis: ClassVar[str] = "material"

    @described
    def __init__(
        self,
        frequencies: Any,
        storage: Any,
        loss: Any,
        *,
        of: str = "extension",
        relative_noise: float | None = None,
        unknown: Sequence[str | Unknown] = (),
        name: str = "moduli",
    ) -> None:
        where = f"record {name}"
        self.frequencies = increasing(f"{where}: frequencies", frequencies)
        self.storage, self.loss = finite(f"{where}: storage", storage), finite(f"{where}: loss", loss)
        if not len(self.storage) == len(self.loss) == len(self.frequencies):
            raise InputError(
                Fault(where, "", "there are as many moduli as frequencies", "give lists of one length")
            )
        if of not in ("extension", "shear"):
            raise InputError(Fault(f"{where}: of", repr(of), "no strain", "give 'extension' or 'shear'"))
        self.of = of
        self.observed = np.concatenate([self.storage, self.loss])
        size = np.hypot(self.storage, self.loss)
        self.noise = (
            None
            if relative_noise is None
            else deviations(
                f"{where}: relative_noise", relative_noise * np.tile(size, 2), self.observed.shape
            )
        )
        self._named(name, unknown, {"gain": (1.0, 0.1, 10.0)})

    @classmethod
    @described
    def read(cls, path: str, **options: Any) -> ModuliRecord:
        """Return a table of one sweep that an instrument exported; see `ModulusTable` for files and options.

        Args:
            path: of the file.
            options: `frequency_unit`, `modulus_unit`, `temperature` of the file; `of`, `relative_noise`, `unknown`,
                `name`.

        Raises:
            InputError: it cannot be read; the message names line and column.
        """
        own = {key: options.pop(key) for key in ("of", "relative_noise", "unknown", "name") if key in options}
        table = read_dma_table(path, **options)
        if table.strain is not None:
            own.setdefault("of", table.strain)
        return cls(table.omega / (2.0 * np.pi), table.storage, table.loss, **own)

    @described
    def predicted(self, result: Any, nuisances: Mapping[str, float] | None = None) -> Floats:
        """Return what a `Material` says (2 n,); see `AnyRecord`.

        Raises:
            InputError: this is no material, or its damping is known only by times.
        """
        from viscorod.model.materials.material import Material

        if not isinstance(result, Material):
            raise InputError(f"record {self.name}: it is compared with a Material")
        omega = 2.0 * np.pi * self.frequencies
        law = result.relaxation(self.of)
        if law is not None:
            modulus = law.complex_modulus(omega)
            real, imaginary = modulus.real, modulus.imag
        elif self.of == "extension":
            real, imaginary = np.full_like(omega, result.youngs_modulus), omega * result.extensional_viscosity
        else:
            real, imaginary = np.full_like(omega, result.shear_modulus), omega * result.shear_viscosity
        found: Floats = np.concatenate([real, imaginary])
        return self.nuisance("gain", self.values_of(nuisances), 1.0) * found
