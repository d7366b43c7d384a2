"""Mistakes on the command line name the options that were typed, with an example that can be typed."""

import subprocess
import sys
from pathlib import Path

import pytest

from lostmotion.cli.spoken import Option, spoken
from lostmotion.errors import Problem

ARM = str(Path(__file__).parent.parent / "examples" / "z-arm.toml")
OPTIONS = {
    "pose": Option("--at"),
    "robots": Option("--robots", number=True),
    "visits": Option("--visits", number=True),
    "pose_law": Option("--pose-law"),
    "cell": Option("--cell"),
    "share": Option("--share", number=True),
}


@pytest.mark.parametrize(
    ("words", "lines"),
    [
        (("run", ARM, "--at", "99999"), ["--at", "  found     99999", "  expected  a number from 0 to 2047", "  example   --at 0"]),
        (("run", ARM, "--zone", "x 8..9 m"), ["--zone", '  example   --zone "x 0.2..0.5 m"']),
        (("run", ARM, "--until", "0 %"), ["--until", "  found     '0 %'", '  example   --until "1 %"']),
        (("run", ARM, "--most-robots", "5", "--until", "5 %"), ["--most-robots", "  example   --most-robots 10000"]),
        (("target", ARM), ['  example   --error "0.5 mm"']),
        (("target", ARM, "--error", "1 mm", "--share", "0.2"), ["--share"]),
    ],
)
def test_a_refused_argument_is_named_as_it_was_typed(tmp_path, words, lines):
    """Exit code 2, the option's own name, what was typed, and an example that can be."""
    done = subprocess.run([sys.executable, "-m", "lostmotion", *words], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 2
    said = done.stderr.splitlines()
    assert said[0] == "lostmotion: 1 mistake"
    for line in lines:
        assert line in said
    assert " = " not in done.stderr
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("key", "example", "named", "typed"),
    [
        ("pose", "pose = 0", "--at", "--at 0"),
        ("pose", 'pose = "A=30deg B=-10deg"', "--at", '--at "A=30deg B=-10deg"'),
        ("pose law", 'pose_law = "sobol"', "--pose-law", "--pose-law sobol"),
        ("robots, tile", "robots = 1000, visits = 30", "--robots, tile", "--robots 1000 --visits 30"),
        ("cell", "cell = 0.05", "--cell", ""),
        ("cell", "a larger cell", "--cell", "a larger cell"),
        ("share", 'share = "95 %"', "--share", ""),
        ("share", "share = 0.95", "--share", "--share 0.95"),
        ("pose", "pose = (0.1, 0.2)", "--at", ""),
        ("arm", 'lostmotion.read("z-arm.toml")', "arm", ""),
        ("threads", "threads = 2", "threads", "threads = 2"),
        ("--path", '--path "P2 P4"', "--path", '--path "P2 P4"'),
    ],
)
def test_examples_are_rewritten_or_left_out(key, example, named, typed):
    """Names of arguments become options; what only Python takes is left out; what is no option stays."""
    told = spoken(Problem("", key, "that", "this", example), OPTIONS)
    assert (told.key, told.found, told.expected, told.example) == (named, "that", "this", typed)


def test_mistakes_in_files_keep_their_words():
    """A key of a file is no option, whatever it is called."""
    problem = Problem("arm.toml", "pose", "that", "this", "pose = 0")
    assert spoken(problem, OPTIONS) is problem
