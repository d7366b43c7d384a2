"""Mistakes on the command line name the options that were typed, with an example that can be
typed.
"""

from pathlib import Path

import pytest

import lostmotion
from lostmotion.analyses.signature import question_of
from lostmotion.cli.generator import spelled
from lostmotion.errors import Problem
from tests.command import carried_out

ARM = str(Path(__file__).parents[2] / "examples" / "z-arm.toml")


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (
            ("run", ARM, "--method", "analitic", "--poses", "many", "--robots", "0"),
            """lostmotion: 3 mistakes
--poses
  found     'many'
  expected  a whole number, at least 1, or a CSV file of poses
  example   --poses 2048
--robots
  found     '0'
  expected  a whole number, at least 1
  example   --robots 1000
--method
  found     'analitic'
  expected  one of montecarlo, analytic, both
  example   --method montecarlo
  did you mean 'analytic'?
""",
        ),
        (
            ("statics", ARM, "--poses", "--1"),
            """lostmotion: 1 mistake
--poses
  found     '--1'
  expected  a whole number, at least 1, or a CSV file of poses
  example   --poses 2048
""",
        ),
        (
            ("run", ARM, "--pose", "3"),
            """lostmotion: 1 mistake
lostmotion run
  found     '--pose'
  expected  an option that lostmotion run --help lists
  example   --poses 2048
  did you mean '--poses'?
""",
        ),
        (
            ("sweep", "--arm", ARM),
            """lostmotion: 1 mistake
lostmotion sweep
  found     '--arm'
  expected  an option that lostmotion sweep --help lists
""",
        ),
        (
            ("run",),
            """lostmotion: 1 mistake
ARM
  found     nothing
  expected  an arm, the path of its file, or a dictionary
  example   lostmotion study arm.toml
""",
        ),
        (
            ("run", ARM, "--seed"),
            """lostmotion: 1 mistake
--seed
  found     nothing after it
  expected  Seed of the random draws: same seed, same result.
  example   --seed 1
""",
        ),
        (
            ("run", ARM, "--force=yes"),
            """lostmotion: 1 mistake
--force
  found     a value
  expected  the option alone: it is a switch
  example   --force
""",
        ),
        (
            ("run", ARM, "--zone", "x", "0.2..0.5", "m"),
            """lostmotion: 1 mistake
lostmotion run
  found     '0.2..0.5 m'
  expected  nothing more: values stand behind an option that lostmotion run --help lists, those with spaces in quotes
  example   --zone "x 0.2..0.5 m"
""",
        ),
        (
            ("target", ARM, "5mm"),
            """lostmotion: 1 mistake
lostmotion target
  found     '5mm'
  expected  nothing more: values stand behind an option that lostmotion target --help lists, those with spaces in quotes
  example   --error 5mm
""",
        ),
        (
            ("map", ARM, "50", "mm"),
            """lostmotion: 1 mistake
lostmotion map
  found     '50 mm'
  expected  nothing more: values stand behind an option that lostmotion map --help lists, those with spaces in quotes
  example   --cell "50 mm"
""",
        ),
        (
            ("mapp", ARM),
            """lostmotion: 1 mistake
command
  found     'mapp'
  expected  one of study, map, iso9283, target, size, statics, task, calibrate, gear, bearing, view, new, check, catalog, compare, sweep, replay, compensate, export c, export fmu, export ros2, schema
  example   lostmotion study arm.toml
  did you mean 'map'?
""",
        ),
    ],
    ids=[
        "values",
        "signs",
        "option",
        "argument",
        "file",
        "no value",
        "switch",
        "spaces",
        "length",
        "two words",
        "command",
    ],
)
def test_words_that_no_option_takes_are_reported_like_any_mistake(tmp_path, words, said):
    """All at once, each with what was found, what is expected and an example; exit code 2 and
    nothing else printed.
    """
    done = carried_out(*words, cwd=tmp_path)
    assert (done.returncode, done.stdout, done.stderr) == (2, "", said)


@pytest.mark.parametrize(
    ("words", "keys"),
    [
        (
            ("run", ARM, "--at", "A=3", "--zone", "q 1..2 m", "--zone", "x 1..2", "--until", "5x"),
            ["--at", "--zone", "--zone", "--until"],
        ),
        (("run", "none.toml", "--at", "A=3", "--zone", "q 1..2 m"), ["none.toml", "--zone"]),
        (("target", "none.toml", "--error", "1 mm", "--zone", "x 1..2"), ["none.toml", "--zone"]),
        (
            ("map", "none.toml", "--cell", "3", "--target", "3 kg"),
            ["none.toml", "--cell", "--target"],
        ),
        (("statics", "none.toml", "--tilt", "3"), ["none.toml", "--tilt"]),
        (
            ("bearing", "none.toml", "--moment", "3", "--force-axial", "2"),
            ["none.toml", "--force-axial", "--moment"],
        ),
        (
            ("iso9283", "none.toml", "--load", "3", "--path", "P1", "--warm-up", "3"),
            ["--load", "none.toml", "--load", "--path", "--warm-up"],
        ),
        (
            ("catalog", "--ratio", "x", "--min-torque", "3", "--file", "none.toml"),
            ["--ratio", "--min-torque", "none.toml"],
        ),
    ],
)
def test_options_and_file_are_refused_together(tmp_path, words, keys):
    """Nobody mends one option to hear of the next: what file and options say wrongly comes in one
    message.
    """
    done = carried_out(*words, cwd=tmp_path)
    said = done.stderr.splitlines()
    assert (done.returncode, said[0]) == (2, f"lostmotion: {len(keys)} mistakes")
    assert [line for line in said[1:] if not line.startswith("  ")] == keys


@pytest.mark.parametrize(
    ("words", "lines"),
    [
        (
            ("run", ARM, "--at", "99999"),
            [
                "--at",
                "  found     99999",
                "  expected  a number from 0 to 2047",
                "  example   --at 0",
            ],
        ),
        (("run", ARM, "--zone", "x 8..9 m"), ["--zone", '  example   --zone "x 0.2..0.5 m"']),
        (
            ("run", ARM, "--until", "0 %"),
            ["--until", "  found     '0 %'", '  example   --until "1 %"'],
        ),
        (
            ("run", ARM, "--most-robots", "5", "--until", "5 %"),
            ["--most-robots", "  example   --most-robots 10000"],
        ),
        (("target", ARM), ['  example   --error "0.5 mm"']),
        (("target", ARM, "--error", "1 mm", "--share", "0.2"), ["--share"]),
    ],
)
def test_a_refused_argument_is_named_as_it_was_typed(tmp_path, words, lines):
    """Exit code 2, the option's own name, what was typed, and an example that can be."""
    done = carried_out(*words, cwd=tmp_path)
    assert done.returncode == 2
    said = done.stderr.splitlines()
    assert said[0] == "lostmotion: 1 mistake"
    for line in lines:
        assert line in said
    assert " = " not in done.stderr
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("key", "passing", "named", "typed", "assigned"),
    [
        ("at", {"at": 0}, "--at", "--at 0", "at = 0"),
        (
            "at",
            {"at": "A=30deg B=-10deg"},
            "--at",
            '--at "A=30deg B=-10deg"',
            'at = "A=30deg B=-10deg"',
        ),
        ("pose_law", {"pose_law": "sobol"}, "--pose-law", "--pose-law sobol", 'pose_law = "sobol"'),
        (
            "robots, tile",
            {"robots": 10, "visits": 3},
            "--robots, tile",
            "--robots 10 --visits 3",
            "robots = 10, visits = 3",
        ),
        ("arm", {"arm": "arm.toml"}, "ARM", "lostmotion study arm.toml", 'arm = "arm.toml"'),
        ("tile", {"tile": 2}, "tile", "", "tile = 2"),
    ],
)
def test_an_argument_is_spelled_where_it_was_asked(key, passing, named, typed, assigned):
    """An option on the command line, an assignment in Python; what is no option is no example of
    one.
    """
    problem = Problem("", key, "that", "this", passing=tuple(passing.items()))
    seen = spelled(problem, question_of(lostmotion.study))
    assert (seen.key, seen.found, seen.expected, seen.example) == (named, "that", "this", typed)
    assert str(problem).endswith(f"example   {assigned}")


def test_a_pair_of_values_is_spelled_value_by_value():
    """As it stands behind the option, and as a tuple."""
    problem = Problem(
        "", "slope_range", "that", "this", passing=(("slope_range", ("50 %", "100 %")),)
    )
    assert spelled(problem, question_of(lostmotion.gear)).example == '--slope-range "50 %" "100 %"'
    assert str(problem).endswith('slope_range = ("50 %", "100 %")')


def test_mistakes_in_files_keep_their_words():
    """A key of a file is no option, whatever it is called."""
    problem = Problem("arm.toml", "poses", "that", "this", "poses = 0")
    assert spelled(problem, question_of(lostmotion.study)) is problem
