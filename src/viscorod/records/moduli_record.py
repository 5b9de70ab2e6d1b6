"""Moduli of a material that were measured over frequency."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, ClassVar

import numpy as np

from viscorod.errors import Fault, InputError, warn
from viscorod.model.materials.dma_table import read_dma_table
from viscorod.records.any_record import AnyRecord, deviations, finite, increasing
from viscorod.records.arguments import described
from viscorod.records.unknown import Unknown
from viscorod.typing import Floats

__all__ = ["ModuliRecord"]


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

        What was averaged, left out or found doubtful on reading is a warning each.

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
        for doubt in table.doubts:
            warn(f"record {own.get('name', 'moduli')}: {doubt}")
        return cls(table.omega / (2.0 * np.pi), table.storage, table.loss, **own)

    @property
    def axes(self) -> tuple[tuple[str, str], ...]:
        """See `AnyRecord`."""
        return (("storage modulus", "Pa"), ("loss modulus", "Pa"))

    def _over(self) -> str:
        return f" in {self.of} from {self.frequencies[0]:.6g} to {self.frequencies[-1]:.6g} Hz"

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
