"""What the shells complete: commands, options, and words of which there is a choice."""

import pytest
from typer.testing import CliRunner

from viscorod.casefile.shipped import shipped_cases
from viscorod.cli.app import app
from viscorod.cli.plot_command import KINDS
from viscorod.programs.inputs import PROGRAMS


def asked(shell, line):
    """What a shell gets for the line up to the cursor."""
    words = line.split() + [""] * line.endswith(" ")
    given = {
        "_VISCOROD_COMPLETE": f"complete_{shell}",
        "COMP_WORDS": line,
        "COMP_CWORD": str(len(words) - 1),
        "_TYPER_COMPLETE_ARGS": line,
        "_TYPER_COMPLETE_FISH_ACTION": "get-args",
    }
    return CliRunner().invoke(app, env=given, prog_name="viscorod").output


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("viscorod camp", {"campbell"}),
        ("viscorod run case.toml --an", {"--anew"}),
        ("viscorod example ", set(shipped_cases())),
        ("viscorod plot run.nc --what ", set(KINDS)),
        ("viscorod plot run.nc --what strain --component b", {"bend_1", "bend_2"}),
        ("viscorod modes case.toml --about re", {"released", "reference"}),
        ("viscorod damping from ", set(PROGRAMS)),
        ("viscorod damping programs case.toml --program so", {"sorosim", "soromox"}),
        ("viscorod theories case.toml --theory ", {"euler_bernoulli", "timoshenko", "von_karman"}),
    ],
)
def test_words_of_which_there_is_a_choice_are_completed(line, words):
    assert set(asked("bash", line).split()) == words


@pytest.mark.parametrize("shell", ["zsh", "fish"])
def test_other_shells_show_what_a_command_does_to_its_end(shell):
    told = " ".join(asked(shell, "viscorod period").replace("''", "'").split())
    assert "a table 'periodic'" in told  # brackets would be markup, and were left out
