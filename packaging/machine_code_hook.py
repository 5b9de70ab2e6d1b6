"""Put machine code of all kernels into a wheel, so that the first run on a machine compiles nothing.

Without this hook of hatch a wheel serves all platforms, and kernels are compiled in the first run. The code is made for
the Python and the Numba of the build, and for a processor that nearly all machines of its kind contain
(``viscorod.mechanics.compilation.machine_code``).
"""

from __future__ import annotations

import os
import subprocess
import sys
import sysconfig
import tempfile
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface


class MachineCode(BuildHookInterface):
    """Compile all kernels and add their machine code to the wheel."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Compile; an editable installation takes nothing of it."""
        if version == "editable":
            return
        source = str(Path(self.root) / "src")
        sys.path.insert(0, source)
        from viscorod.mechanics.compilation.machine_code import MAKES, SHIPPED, TARGET

        if TARGET is None:
            raise RuntimeError(
                "no machine code is made for this kind of processor: build the wheel without it"
            )
        self._folder = tempfile.TemporaryDirectory()
        made, about = Path(self._folder.name) / "made", Path(self._folder.name) / "about"
        made.mkdir()
        (about / "viscorod.dist-info").mkdir(parents=True)  # the package asks for its own version
        metadata = f"Metadata-Version: 2.1\nName: viscorod\nVersion: {self.metadata.version}\n"
        (about / "viscorod.dist-info" / "METADATA").write_text(metadata, encoding="utf-8")
        processor = {"NUMBA_CPU_NAME": TARGET.name, "NUMBA_CPU_FEATURES": ""}
        found = {MAKES: str(made), "PYTHONPATH": os.pathsep.join([source, str(about)])}
        command = [sys.executable, "-m", "viscorod", "warmup"]
        subprocess.run(command, check=True, env=os.environ | processor | found)
        package = Path("viscorod") / SHIPPED.name
        for path in sorted(made.rglob("*.nb[ci]")):
            build_data["force_include"][str(path)] = str(package / path.relative_to(made))
        build_data["pure_python"] = False
        python = f"cp{sys.version_info[0]}{sys.version_info[1]}"
        build_data["tag"] = f"{python}-{python}-{_platform()}"

    def finalize(self, version: str, build_data: dict[str, Any], artifact_path: str) -> None:
        """Remove what was compiled."""
        del version, build_data, artifact_path
        if hasattr(self, "_folder"):
            self._folder.cleanup()


def _platform() -> str:
    """Return the platform in the name of the wheel: nothing in it is linked yet, so that any Linux will do."""
    name = sysconfig.get_platform().replace("-", "_").replace(".", "_")
    return name.replace("linux_", "manylinux_2_17_", 1) if name.startswith("linux_") else name
