"""Time loops and errors of the other programs against viscorod's reference.

    python -m bench.peers [--case llt frame string]

The references are computed once and kept in out/bench, some minutes in all. "time loop" is the best of several
runs of the loop over time steps alone. "error" is the largest deviation of the tip over the part of the motion
that is compared (llt 5 s, frame 5 s, string 1 s), over the length of the rod (of a leg). PyElastica has no
material damping and is compared with an undamped reference, where its label says so only over the first part.
"""

from __future__ import annotations

import argparse
from importlib import import_module

from .cases import CASES, INSTALL, Case, PeerRun
from .suite import MODULES, SUITE, Entry, available


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--case", nargs="+", choices=sorted(CASES), default=list(CASES))
    args = parser.parse_args()
    for module, package in MODULES.items():
        if not available(module):
            print(f"{package} is not installed and is left out: {INSTALL}")
    for name in args.case:
        print(f"\n{name}\n{'program':20s} {'label':52s} {'time loop [s]':>13s} {'error / L':>10s}")
        for entry in SUITE:
            if entry.case == name and available(entry.module):
                try:
                    print(_line(*_measured(entry)), flush=True)
                except RuntimeError as reason:
                    print(f"{MODULES[entry.module]}: {reason}")


def _measured(entry: Entry) -> tuple[Case, PeerRun]:
    case = CASES[entry.case]
    case = case.undamped() if entry.undamped else case
    run = import_module(f".{entry.module}", __package__).run
    return case, run(case, entry.elements, **entry.settings)


def _line(case: Case, run: PeerRun) -> str:
    program = f"{run.program} {run.version}"
    return f"{program:20s} {run.label:52s} {run.loop_seconds:13.3f} {case.error(run.t, run.tip):10.1e}"


if __name__ == "__main__":
    main()
