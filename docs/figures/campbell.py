"""Draw the Campbell diagram of the shipped shaft for docs/howto/campbell.md.

python docs/figures/campbell.py
"""

from __future__ import annotations

from pathlib import Path

import viscorod as vr
from viscorod.analyses.case_run import run_case
from viscorod.casefile.case import load_case
from viscorod.casefile.shipped import shipped_case

TARGET = Path(__file__).parents[1] / "images" / "campbell.png"


def main() -> None:
    result = run_case(load_case(shipped_case("whirling_shaft")))
    assert isinstance(result, vr.Campbell)
    print(result.report())
    result.plot(TARGET)


if __name__ == "__main__":
    main()
