"""Check the wheels and the sdist in dist/ in environments that hold nothing else.

``make release`` builds both and runs this. For every Python interpreter named (default: the one that runs this script),
each wheel is installed into an empty environment with the newest versions of its dependencies, for the oldest Python
that it is for also with the lowest versions that the wheel declares (which are older than the newest Python). In each
the Python of the README and a shipped case run, from an empty folder. A wheel with machine code is installed where its
Python is; with the Numba that it was built with, nothing may be compiled.
"""

from __future__ import annotations

import argparse
import re
import subprocess
import sys
import tarfile
import tempfile
import zipfile
from email.message import Message
from email.parser import Parser
from pathlib import Path

ROOT = Path(__file__).parents[1]
REQUIREMENT = re.compile(r"^([\w.-]+)(?:\[[\w,-]+\])?>=([\d.]+)$")


def metadata(wheel: Path) -> Message:
    """Return what an index is told about a wheel."""
    with zipfile.ZipFile(wheel) as archive:
        name = next(name for name in archive.namelist() if name.endswith(".dist-info/METADATA"))
        return Parser().parsestr(archive.read(name).decode())


def lowest(about: Message) -> list[str]:
    """Return the dependencies of a wheel, each held at the lowest minor version that it declares."""
    held = []
    for line in about.get_all("Requires-Dist") or []:
        if ";" in line:  # an extra
            continue
        found = REQUIREMENT.match(line.replace(" ", ""))
        if found is None:
            raise SystemExit(f"pyproject.toml: {line!r} has no lower bound, as 'name>=1.2'")
        held.append(f"{found[1]}=={found[2]}.*")
    return held


def oldest_python(wheel: Path) -> tuple[int, int]:
    """Return the oldest Python that a wheel is for, such as (3, 11)."""
    found = re.fullmatch(r">=(\d+)\.(\d+)", str(metadata(wheel)["Requires-Python"]))
    if found is None:
        raise SystemExit(
            f"pyproject.toml: requires-python = {metadata(wheel)['Requires-Python']!r}, not '>=3.11'"
        )
    return int(found[1]), int(found[2])


def classified(about: Message) -> list[str]:
    """Return the minor versions of Python that the classifiers of a wheel name, such as "3.12"."""
    told = about.get_all("Classifier") or []
    return [
        found[1]
        for line in told
        if (found := re.fullmatch(r"Programming Language :: Python :: (\d\.\d+)", line))
    ]


def check_contents(wheel: Path, sdist: Path) -> None:
    """Refuse a wheel or an sdist that lacks what belongs into it, and links that lead nowhere on an index."""
    with zipfile.ZipFile(wheel) as archive:
        names = archive.namelist()
    for part in (
        "viscorod/py.typed",
        "viscorod/__init__.pyi",
        "viscorod/casefile/examples/cantilever_swing.toml",
    ):
        if part not in names:
            raise SystemExit(f"{wheel.name}: {part} is missing")
    if not any(name.endswith("licenses/LICENSE") for name in names):
        raise SystemExit(f"{wheel.name}: LICENSE is missing")
    with tarfile.open(sdist) as archive:
        inside = {name.partition("/")[2] for name in archive.getnames()}
    for part in (
        "tests/conftest.py",
        "docs/conf.py",
        "examples/cantilever_swing.toml",
        "Makefile",
        "CITATION.cff",
    ):
        if part not in inside:
            raise SystemExit(f"{sdist.name}: {part} is missing")
    text = metadata(wheel).get_payload()
    relative = re.findall(r"\]\((?!https?:)([^)]+)\)", str(text))
    if relative:
        raise SystemExit(f"{wheel.name}: links that lead nowhere on a package index: {relative}")


def readme_code() -> str:
    """Return the Python of the README."""
    found = re.search(r"^```python\n(.*?)^```", (ROOT / "README.md").read_text(encoding="utf-8"), re.M | re.S)
    assert found is not None
    return found[1]


def has_machine_code(wheel: Path) -> bool:
    """Return whether a wheel has kernels compiled: it is for one Python and one platform then."""
    return not wheel.stem.endswith("-none-any")


def run(command: list[str], folder: Path) -> str:
    """Run a command in a folder and return what it told; a failure ends the check."""
    print(
        "  ", " ".join(Path(command[0]).name if part == command[0] else part for part in command), flush=True
    )
    done = subprocess.run(command, cwd=folder, text=True, capture_output=True, check=False)
    if done.returncode:
        raise SystemExit(f"failed with {done.returncode}:\n{done.stdout[-3000:]}\n{done.stderr[-3000:]}")
    return done.stdout + done.stderr


def version(python: str) -> tuple[int, int]:
    """Return the version of an interpreter, such as (3, 11)."""
    major, minor = run([python, "-c", "import sys; print(*sys.version_info[:2])"], ROOT).split()
    return int(major), int(minor)


def check_installed(python: str, wheel: Path, held: list[str]) -> None:
    """Install a wheel into an empty environment and use it there as a newcomer does."""
    # processes that compile for the next run may still write into it
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as name:
        folder = Path(name)
        run([python, "-m", "venv", "env"], folder)
        bin_ = folder / "env" / ("Scripts" if sys.platform == "win32" else "bin")
        pip = [str(bin_ / "python"), "-m", "pip", "--disable-pip-version-check", "install", "--quiet"]
        run([*pip, "--prefer-binary", str(wheel), *held], folder)
        run([str(bin_ / "python"), "-m", "pip", "check"], folder)
        told = ""
        (folder / "readme.py").write_text(readme_code(), encoding="utf-8")
        told += run([str(bin_ / "python"), "-W", "error::DeprecationWarning:__main__", "readme.py"], folder)
        run([str(bin_ / "viscorod"), "example", "cantilever_swing"], folder)
        run([str(bin_ / "viscorod"), "check", "cantilever_swing.toml"], folder)
        told += run([str(bin_ / "viscorod"), "run", "cantilever_swing.toml", "-o", "out"], folder)
        for made in ("motion.png", "out/run.nc", "out/motion.png", "out/energy.png"):
            if not (folder / made).is_file():
                raise SystemExit(f"{made} was not written")
        if has_machine_code(wheel) and not held and "compiling" in told:
            raise SystemExit(f"{wheel.name}: kernels were compiled, with the newest Numba:\n{told}")


def main() -> None:
    """Check what lies in dist/."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("python", nargs="*", default=[sys.executable], help="interpreters to install into")
    parser.add_argument("--dist", type=Path, default=ROOT / "dist", help="where wheel and sdist lie")
    options = parser.parse_args()
    wheels, (sdist,) = sorted(options.dist.glob("*.whl")), list(options.dist.glob("*.tar.gz"))
    interpreters = sorted((version(python), python) for python in options.python)
    lowest_python = oldest_python(wheels[0])
    if interpreters[0][0] != lowest_python:
        wanted = "python{}.{}".format(*lowest_python)
        raise SystemExit(
            f"name a {wanted}, too: the lowest versions of what viscorod needs are tried with it"
        )
    for wheel in wheels:
        check_contents(wheel, sdist)
        for (major, minor), python in interpreters:
            if has_machine_code(wheel) and f"-cp{major}{minor}-" not in wheel.name:
                continue
            oldest = (major, minor) == lowest_python
            for words, held in [("lowest", lowest(metadata(wheel)))] * oldest + [("newest", [])]:
                print(f"{wheel.name} on {python}, {words} versions", flush=True)
                check_installed(python, wheel, held)
    tried = [f"{major}.{minor}" for (major, minor), _ in interpreters]
    print(f"{', '.join(wheel.name for wheel in wheels)} and {sdist.name} work with Python {', '.join(tried)}")
    untried = sorted(set(classified(metadata(wheels[0]))) - set(tried))
    if untried:
        print(f"Not tried, though its classifiers promise it: Python {', '.join(untried)}; name interpreters")


if __name__ == "__main__":
    main()
