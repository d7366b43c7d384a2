"""Streams that are closed, full or know ASCII alone, folders that are gone, and names that a
terminal would obey.
"""

from __future__ import annotations

import io
import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
import shellingham
from typer.testing import CliRunner

from lostmotion.cli import app
from lostmotion.errors import LostmotionError, legible
from lostmotion.reporting.screen import print_sheet
from tests.command import carried_out
from tests.runs.conftest import ARM

QUICK = ("--poses", "8", "--robots", "4", "--visits", "2")
POSIX = pytest.mark.skipif(os.name != "posix", reason="needs the streams of a POSIX shell")
SRC = Path(__file__).parents[2] / "src"


@pytest.fixture
def arm(tmp_path):
    """Return the path of a small arm."""
    path = tmp_path / "tiny.toml"
    path.write_text(ARM, encoding="utf-8")
    return path


# The command without the plots of its report, which take half of its time. Its streams are opened
# before anything is loaded, as ever.
UNDRAWN = """
from importlib import import_module

app = import_module("lostmotion.cli.app")
carried_out = app._carried_out


def undrawn():
    from lostmotion.analyses.statics.page import Statics

    Statics.plots = ()
    return carried_out()


app._carried_out = undrawn
app.main()
"""


def shell(words, cwd, program="-m lostmotion", **environment):
    """Run the command by a shell, with what the shell does to its streams behind it."""
    command = f"{sys.executable} {program} {words}"
    return subprocess.run(
        ["sh", "-c", command],
        cwd=cwd,
        capture_output=True,
        check=False,
        env={**os.environ, **environment},
    )


@pytest.fixture
def undrawn(tmp_path):
    """Return the name of the program that draws no plots."""
    path = tmp_path / "undrawn.py"
    path.write_text(UNDRAWN, encoding="utf-8")
    return path.name


@POSIX
@pytest.mark.parametrize(
    "stream", ["> /dev/full", ">&- 2>&-", "> /dev/full 2> /dev/full", ">&- <&-"]
)
def test_an_output_that_takes_nothing_costs_no_results(arm, undrawn, tmp_path, stream):
    """Standard output closed or full: exit code 1, at most one message, and the results are
    written.
    """
    if "full" in stream and not Path("/dev/full").exists():
        pytest.skip("no /dev/full here")
    words = f"statics {arm.name} --poses 8 --out out {stream}"
    done = shell(words, tmp_path, undrawn)
    assert done.returncode == 1
    assert b"Traceback" not in done.stderr
    assert b"Exception ignored" not in done.stderr
    assert done.stderr.count(b"lostmotion:") == (0 if "2>" in stream else 1)
    said = json.loads((tmp_path / "out" / "result.json").read_text(encoding="utf-8"))
    assert said["arm"] == "tiny"
    assert (tmp_path / "out" / "report.html").read_text(encoding="utf-8").startswith("<!")


@POSIX
def test_an_encoding_without_our_letters_gets_others(arm, undrawn, tmp_path):
    """On a terminal of ASCII alone every figure is printed, "um" for micrometres; JSON holds the
    same data as on any other.
    """
    words = f"statics {arm.name} --poses 8 --out out"
    done = shell(words, tmp_path, undrawn, PYTHONIOENCODING="ascii")
    assert done.returncode == 0, done.stderr
    assert re.search(rb"\d um", done.stdout)
    assert done.stdout.isascii()
    plain = shell("catalog --json", tmp_path, PYTHONIOENCODING="ascii")
    full = carried_out("catalog", "--json", cwd=tmp_path)
    assert plain.returncode == full.returncode == 0
    assert plain.stdout.isascii()
    assert not full.stdout.isascii()
    assert json.loads(plain.stdout) == json.loads(full.stdout)


@POSIX
def test_a_working_folder_that_is_gone_is_one_message(arm, tmp_path):
    """Somebody removed the folder that the user stands in: exit code 2 and a word of what to do."""
    (tmp_path / "gone").mkdir()
    done = subprocess.run(
        ["sh", "-c", f"cd gone; rmdir ../gone; {sys.executable} -m lostmotion run {arm}"],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 2
    assert "no longer exists" in done.stderr
    assert "Traceback" not in done.stderr


HOSTILE = "\x1b]0;owned\x07\x1b[2J\x9b31m\u202eevil"


def test_no_control_character_of_a_file_reaches_a_terminal(arm, tmp_path):
    """Escape sequences in an arm's name, a joint's, a file's path and a CSV's header are written
    out, in messages, sheets and JSON.
    """
    name = "".join(f"\\u{ord(char):04x}" if legible(char) != char else char for char in HOSTILE)
    arm.write_text(
        ARM.replace('name = "tiny"', f'name = "{name}"').replace('"A"', '"A\\u001b[31m"'),
        encoding="utf-8",
    )
    (tmp_path / "poses.csv").write_text(f"{HOSTILE} [deg],B [deg]\n1,2\n", encoding="utf-8")
    ran, data, *refused = (
        carried_out(*words, cwd=tmp_path)
        for words in (
            ("run", arm.name, *QUICK, "--out", "out"),
            ("statics", arm.name, "--json", "--poses", "8"),
            ("run", arm.name, "--poses-file", "poses.csv"),
            ("run", f"{HOSTILE}.toml"),
        )
    )
    assert [each.returncode for each in refused] == [2, 2]
    for each in (ran, data, *refused):
        text = each.stdout + each.stderr
        assert text
        assert legible(text) == text, ascii(text)
        assert "Traceback" not in text
    if data.returncode == 0:
        assert json.loads(data.stdout)["arm"] == HOSTILE


def test_messages_write_control_characters_out():
    """A message that names a stranger's file holds no escape, and keeps its line breaks and
    letters; a sheet likewise.
    """
    assert (
        str(LostmotionError(f"'{HOSTILE}'\n  expected µm ± 1°")).splitlines()[1]
        == "  expected µm ± 1°"
    )
    assert legible(HOSTILE) == "\\x1b]0;owned\\x07\\x1b[2J\\x9b31m\\u202eevil"
    assert legible("\ud800") == "\\ud800"
    assert legible("\ud7ff\ue000") == "\\ud7ff\\ue000"  # unassigned, private


def test_a_sheet_writes_control_characters_out(capsys):
    """Whatever a sheet says, name, notes, labels or verdict, is printed without a character that a
    terminal obeys.
    """
    from lostmotion.reporting.sheet import Cell, Row, Section, Sheet

    row = Row(HOSTILE, (Cell(1.0, "mm"),), HOSTILE)
    section = Section("key", HOSTILE, (HOSTILE,), (row,), HOSTILE)
    print_sheet(
        Sheet(
            name=HOSTILE,
            subject="",
            verdict=HOSTILE,
            cards=(),
            sections=(section,),
            source="",
            notes=(HOSTILE,),
            counts=HOSTILE,
        )
    )
    said = capsys.readouterr().out
    assert legible(said) == said
    assert "owned" in said


class Terminal(io.StringIO):
    """A stream that is a terminal."""

    def isatty(self):
        """Return what makes a terminal."""
        return True


@pytest.mark.parametrize(
    ("variables", "coloured"), [({}, True), ({"NO_COLOR": "1"}, False), ({"TERM": "dumb"}, False)]
)
def test_no_color_takes_the_colours_and_leaves_the_words(monkeypatch, variables, coloured):
    """A warning is red on a terminal, unless NO_COLOR is set; it is printed either way."""
    from lostmotion.reporting.sheet import Sheet

    for name in ("NO_COLOR", "FORCE_COLOR", "COLORTERM"):
        monkeypatch.delenv(name, raising=False)
    for name, value in {"TERM": "xterm", **variables}.items():
        monkeypatch.setenv(name, value)
    screen = Terminal()
    monkeypatch.setattr(sys, "stdout", screen)
    print_sheet(
        Sheet(
            name="arm",
            subject="",
            verdict="",
            cards=(),
            sections=(),
            source="",
            warnings=("overloaded",),
        )
    )
    printed = screen.getvalue()
    assert "overloaded" in printed
    codes = {
        code for codes in re.findall(r"\x1b\[([0-9;]*)m", printed) for code in codes.split(";")
    }
    assert ("31" in codes) == coloured


@pytest.mark.parametrize(
    ("typed", "word", "offered"),
    [
        ("lostmotion st", 1, {"study", "statics"}),
        ("lostmotion exp", 1, {"export"}),
        ("lostmotion export ", 2, {"c", "fmu", "ros2"}),
        ("lostmotion run --pose-l", 2, {"--pose-law"}),
        ("lostmotion study arm.toml --approach ", 4, {"random", "up", "down"}),
        ("lostmotion study arm", 2, set()),  # the shell offers files
    ],
)
def test_a_shell_completes_commands_options_and_words(typed, word, offered):
    """As the script of --show-completion asks for them; names of commands with two words come one
    word at a time.
    """
    environment = {
        "_LOSTMOTION_COMPLETE": "complete_bash",
        "COMP_WORDS": typed,
        "COMP_CWORD": str(word),
    }
    done = CliRunner().invoke(app, [], prog_name="lostmotion", env=environment)
    assert set(done.stdout.split()) == offered


def test_the_script_for_completion_is_printed(monkeypatch):
    """For bash it falls back on the names of files."""
    monkeypatch.setattr(shellingham, "detect_shell", lambda: ("bash", "/bin/bash"))
    done = CliRunner().invoke(app, ["--show-completion"], prog_name="lostmotion")
    assert "complete -o default -F _lostmotion_completion lostmotion" in done.stdout


READ_ONLY = """
import os, pathlib, sys, tempfile
import lostmotion
from lostmotion.error_model.draw_kernel import mix
import numpy as np
print(mix(np.uint64(5)) == mix.py_func(np.uint64(5)), os.environ["NUMBA_CACHE_DIR"])
"""


@POSIX
@pytest.mark.skipif(
    os.name != "posix" or (os.geteuid() == 0 and not shutil.which("setpriv")),
    reason="root writes everywhere without setpriv",
)
def test_a_package_that_cannot_be_written_to_compiles_elsewhere(tmp_path):
    """Neither package nor home can be written to: compiled code goes into a temporary folder that
    is deleted when the process ends.
    """
    place = tmp_path / "site"
    shutil.copytree(
        SRC / "lostmotion", place / "lostmotion", ignore=shutil.ignore_patterns("__pycache__")
    )
    home = tmp_path / "home"
    home.mkdir()
    folders = [home, place, *(path for path in place.rglob("*") if path.is_dir())]
    environment = {
        "PATH": os.environ["PATH"],
        "PYTHONPATH": str(place),
        "HOME": str(home),
        "PYTHONWARNINGS": "ignore::RuntimeWarning",
    }
    # Without its capabilities root obeys the permissions of files as their owner does; the
    # interpreter's own folders stay readable.
    unprivileged = (
        ["setpriv", "--bounding-set=-all", "--inh-caps=-all"] if os.geteuid() == 0 else []
    )
    for folder in folders:
        folder.chmod(0o555)
    done = subprocess.run(
        [*unprivileged, sys.executable, "-c", READ_ONLY],
        cwd="/",
        capture_output=True,
        text=True,
        check=False,
        env=environment,
    )
    for folder in folders:
        folder.chmod(0o755)
    assert done.returncode == 0, done.stderr
    same, folder = done.stdout.split()
    assert same == "True"
    assert not Path(folder).exists()
