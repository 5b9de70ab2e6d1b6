"""Random models by default against refined solutions of the same; ``make honest`` tries a thousand."""

from __future__ import annotations

import csv

import pytest

from honesty.__main__ import OUTCOMES, STEPS, table, table_of_steps
from honesty.judge import Verdict, verdict
from honesty.random_models import by_default, random_trial

SEEDS = {
    "equilibrium": (2, 3, 11, 12, 18, 20, 22, 24, 25, 29),
    "modes": (0, 6, 7, 15, 16, 26),
    "simulate": (5, 28),
    "steady": (4, 10),
}
"""Of each analysis, the first of all seeds that belong to it and take little time for it."""


@pytest.mark.slow
@pytest.mark.parametrize("seed", [seed for seeds in SEEDS.values() for seed in seeds])
def test_no_result_by_default_is_wrong_without_a_word(seed: int) -> None:
    found = verdict(seed)
    assert found.outcome in ("solved", "unjudged"), found
    assert not found.untold, found


def test_a_seed_gives_the_same_model_whenever_it_is_drawn() -> None:
    for seed in (0, 1, 2):
        first, second = random_trial(seed), random_trial(seed)
        assert first.build(by_default).to_dict() == second.build(by_default).to_dict()
        assert first.settings == second.settings


def test_verdicts_tell_what_is_wrong_without_a_word() -> None:
    fine = Verdict(0, "modes", "hinge", "solved", 1e-3, 1e-3, 2e-3, told=False)
    silent = Verdict(1, "modes", "hinge", "solved", 0.02, 0.02, 1e-4, told=False)
    warned = Verdict(2, "modes", "hinge", "solved", 0.02, 0.02, 1e-2, told=True)
    assert [v.untold for v in (fine, silent, warned)] == [False, True, False]
    assert [v.within for v in (fine, silent, warned)] == [True, False, True]
    last = table([fine, silent, warned]).splitlines()[-1]
    assert last == "| all | 3 | 3 | 0 | 0 | 0 | 1 | 3 | 66.7 % | 33.3 % |"


def test_the_documented_table_is_that_of_the_stored_verdicts() -> None:
    page = (OUTCOMES.parents[2] / "docs" / "explanation" / "honesty.md").read_text(encoding="utf-8")
    with OUTCOMES.open(newline="") as file:
        rows = [
            Verdict(
                int(row["seed"]),
                row["analysis"],
                row["structure"],
                row["outcome"],
                *(float(row[key]) for key in ("error", "true_mesh", "estimate")),
                row["told"] == "True",
                row["words"],
                *(float(row[key]) for pair in STEPS.values() for key in pair),
            )
            for row in csv.DictReader(file)
        ]
    assert table(rows) in page
    assert table_of_steps(rows) in page
