"""Every command of the README's table runs as it is printed, or with fewer poses and robots, in a
folder that holds the examples and nothing else.
"""

import re
import shlex

import pytest

from tests.command import carried_out
from tests.docs.pages import ROOT

README = (ROOT / "README.md").read_text("utf-8")
TABLE = README.partition("| question | command |")[2].partition("\n\n")[0]
# What the first command prints.
SCREEN = README.partition("```text\n")[2].partition("\n```")[0]
COMMANDS = re.findall(r"`(lostmotion [^`]+)`", TABLE)
# The live view serves until it is stopped; its own tests drive it in a browser.
ENDLESS = "lostmotion view "
# Added to the commands that take longest: their answers have tests of their own.
FEWER = {
    "study": "--poses 64 --robots 24 --visits 3 --until 20%",
    "map": "--per-cell 2 --poses 256",
    "iso9283": "--robots 20",
    "size": "--poses 8",
    "target": "--poses 16 --robots 24 --visits 3",
    "compare": "--poses 16 --robots 24 --visits 3",
    "sweep": "--poses 16 --robots 24 --visits 3",
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Return an empty folder beside which the examples lie as they do in the project; a later
    command reads what an earlier one wrote.
    """
    here = tmp_path_factory.mktemp("reader")
    (here / "examples").symlink_to(ROOT / "examples")
    return here


@pytest.mark.slow
# what `size` studies has no option, nor have the samples with which `target` solves
@pytest.mark.usefixtures("few_samples")
@pytest.mark.parametrize(
    "command",
    [
        COMMANDS[0],  # its screen is compared
        *(
            pytest.param(each, marks=pytest.mark.few_counts)
            for each in COMMANDS[1:]
            if not each.startswith(ENDLESS)
        ),
    ],
)
def test_a_command_of_the_readme_runs_as_printed(command, folder, request):
    """It ends with exit code 0 and an answer, on lines of 80 columns, and the report that it names
    lies in the folder.
    """
    words = shlex.split(command)[1:]
    if command != COMMANDS[0]:
        words += FEWER.get(words[0], "").split()
        request.getfixturevalue("unpainted")  # of a report it is read that it is there
    done = carried_out(*words, cwd=folder)
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip()
    assert max(map(len, done.stdout.splitlines())) <= 80
    if command == COMMANDS[0]:
        assert done.stdout.strip() == SCREEN
    for written in re.findall(
        r"^(?:Report|File|Picture): (.+?)(?:   --full.*)?$", done.stdout, re.MULTILINE
    ):
        assert (folder / written).stat().st_size > 0


def test_the_table_names_every_question_that_a_reader_may_ask():
    """Every command has a row, but for the format of files."""
    import lostmotion
    from lostmotion.cli.generator import command_name

    named = {
        " ".join(each.split()[1:3]) if each.startswith("lostmotion export") else each.split()[1]
        for each in COMMANDS
    }
    assert {command_name(name) for name in lostmotion.QUESTIONS} - named == {"schema"}
