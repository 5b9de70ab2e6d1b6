"""Numba pipelines: kernels become machine code, and functions that only kernels call become code linked into these.

Numba optimises every function together with all that it calls, makes machine code of it, and optimises it again within
each of its callers. For functions that nothing calls from outside this work is wasted: here they are optimised once,
within the kernel of which machine code is made. Kernels are optimised at level 2: level 3 adds copies of whole loops
for every condition that does not change within, which take longer to compile and do not run faster.
"""

from __future__ import annotations

from typing import Any

import numba
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler

_Library: Any = JITCodeLibrary
_Compiler: Any = Compiler

_LEVEL = 2

TESTED = (0, 61), (0, 68)
"""The first and the last version of Numba whose inner classes are known to fit: ``make numba`` tries them and two in
between. With later ones Numba's own compiler does everything, which takes half as long again."""


class _Codegen:
    """Numba's code generator, but environments of functions without machine code are not registered."""

    def __init__(self, codegen: Any) -> None:
        self._codegen = codegen

    def __getattr__(self, name: str) -> Any:
        return getattr(self._codegen, name)

    def set_env(self, env_name: str, env: Any) -> None:
        """Do nothing: there is no machine code that could look it up."""


class _PartLibrary(_Library):
    """Code of one function with all that it calls, ready to be linked into other code but not to be run."""

    @property
    def codegen(self) -> Any:
        return _Codegen(self._codegen)

    def _optimize_final_module(self) -> None: ...

    def _finalize_final_module(self) -> None:
        self._finalize_dynamic_globals()
        self._finalized = True

    def get_pointer_to_function(self, name: str) -> int:
        """Return the null pointer that stands for a function that cannot be called from Python."""
        del name
        self._ensure_finalized()
        return 0


class _KernelLibrary(_Library):
    """Code of a kernel with all that it calls."""

    def _optimize_final_module(self) -> None:
        managers: Any = self._codegen._module_pass_manager
        # inlines first, so that counts of references cancel
        for options in (
            {"loop_vectorize": False, "slp_vectorize": False, "opt": 0, "cost": "cheap"},
            {"opt": _LEVEL},
        ):
            found = managers(**options)
            if isinstance(found, tuple):
                passes, builder = found
                passes.run(self._final_module, builder)
            else:  # Numba 0.61
                found.run(self._final_module)


class _LibraryCompiler(_Compiler):
    """Numba's compiler, putting code into a library of the class ``library``."""

    library: Any = _Library

    def define_pipelines(self) -> Any:
        """Set the library of the code before Numba does."""
        state: Any = self.state
        state.library = self.library(state.targetctx.codegen(), state.func_id.func_qualname)
        state.library.enable_object_caching()
        return super().define_pipelines()


class _PartCompiler(_LibraryCompiler):
    library = _PartLibrary


class _KernelCompiler(_LibraryCompiler):
    library = _KernelLibrary


def _fits() -> bool:
    return TESTED[0] <= tuple(numba.version_info.short) <= TESTED[1]


def part_compiler() -> Any:
    """Return the compiler for functions that only kernels call."""
    return _PartCompiler if _fits() else _Compiler


def kernel_compiler() -> Any:
    """Return the compiler for kernels."""
    return _KernelCompiler if _fits() else _Compiler
