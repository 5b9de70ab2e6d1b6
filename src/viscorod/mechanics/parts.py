"""How Numba compiles functions that only other kernels call: to code that is linked into these, and no further.

Numba optimises every function together with all that it calls and makes machine code of it, and then optimises it again
within each of its callers. For functions that nothing calls from outside that is lost: a third of the time of
compilation. Here they are optimised once, within the kernel that machine code is made of.
"""

from __future__ import annotations

from typing import Any

import numba.core.codegen
import numba.core.compiler

_Library: Any = numba.core.codegen.JITCodeLibrary
_Compiler: Any = numba.core.compiler.Compiler


class _Codegen:
    """Numba's code generator, but environments of functions without machine code are not registered."""

    def __init__(self, codegen: Any) -> None:
        self._codegen = codegen

    def __getattr__(self, name: str) -> Any:
        return getattr(self._codegen, name)

    def set_env(self, env_name: str, env: Any) -> None:
        """Do nothing: there is no machine code that could look it up."""


class _PartLibrary(_Library):  # type: ignore[misc]
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


class PartCompiler(_Compiler):  # type: ignore[misc]
    """Numba's compiler, putting code into a :class:`_PartLibrary`."""

    def define_pipelines(self) -> Any:
        """Say where the code goes before Numba does."""
        state, library = self.state, _PartLibrary  # type: Any, Any
        state.library = library(state.targetctx.codegen(), state.func_id.func_qualname)
        return super().define_pipelines()
