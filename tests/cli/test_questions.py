"""One signature per question: the command line, `help()` and the function itself say the same."""

import importlib
import inspect
import re
import subprocess
import sys
from pathlib import Path

import pytest
import typer.main

import lostmotion
from lostmotion.analyses.signature import question_of
from lostmotion.cli.app import app
from lostmotion.cli.generator import command_name, command_of
from lostmotion.cli.shared_options import shared_options
from tests.command import carried_out

NAMES = tuple(lostmotion.QUESTIONS)


def asked(name):
    """Return a question's function."""
    return getattr(lostmotion, name)


def test_the_command_line_asks_what_python_asks():
    """The same names on both sides; `run` stays as another name of `study`."""
    group = typer.main.get_command(app)
    assert tuple(name.replace("export ", "export_") for name in group.list_commands(None)) == NAMES
    assert group.get_command(None, "run").name == "study"
    assert set(NAMES) == {
        "study",
        "map",
        "iso9283",
        "target",
        "size",
        "statics",
        "task",
        "calibrate",
        "gear",
        "bearing",
        "view",
        "new",
        "check",
        "catalog",
        "compare",
        "sweep",
        "replay",
        "compensate",
        "export_c",
        "export_fmu",
        "export_ros2",
        "schema",
    }


@pytest.mark.parametrize("name", NAMES)
def test_every_argument_is_an_option_and_every_option_an_argument(name):
    """But for callbacks, which no one types, and the options that all commands share."""
    question = question_of(asked(name))
    parameters = {each.name for each in question.parameters if not each.argument.python_only}
    assert parameters | {each.name for each in question.parameters} == set(
        inspect.signature(asked(name)).parameters
    )
    options = {param.name for param in command_of(asked(name)).params if param.name != "help"}
    shared = {each.name for each in shared_options(question)}
    assert options == parameters | shared
    assert not parameters & shared
    printed = {"json", "full", "quiet"}
    assert shared in (
        set(),
        {"json"},
        {"out", "force", "figures", "tables"} | printed,
        {"figures", "tables"} | printed,
        printed,
    )


@pytest.mark.parametrize("name", NAMES)
def test_every_argument_is_documented_once(name):
    """Each has one entry in the docstring, with its type, and the same words in `--help`."""
    function = asked(name)
    text = function.__doc__
    helps = {param.name: param.help for param in command_of(function).params}
    for each in question_of(function).parameters:
        assert text.count(f"\n{each.name} : {each.type_text}\n") == 1
        assert each.argument.help.endswith((".", "lists."))
        if each.name in helps:
            assert helps[each.name].startswith(each.argument.help)
    words = re.sub(r"\s+", " ", text)
    assert all(words.count(each.argument.help) == 1 for each in question_of(function).parameters)
    assert "Any" not in str(inspect.signature(function)).replace("Mapping[str, Any]", "").replace(
        "dict[str, Any]", ""
    )


@pytest.mark.parametrize("name", NAMES)
def test_a_default_is_valid_and_stated(name):
    """Defaults pass their own reader, and those that are a value stand in the help."""
    question = question_of(asked(name))
    for each in question.parameters:
        if not each.required and each.default is not None and each.name not in {"poses", "also"}:
            assert each.read(each.default, {}) is not None or each.default == ()
        if each.default not in (None, (), False, "", inspect.Parameter.empty):
            assert f"Default: {each.default}." in each.help


def test_every_public_name_stands_once_and_can_be_loaded():
    """Fewer than 60 of them, each found where the stub says."""
    stub = Path(lostmotion.__file__).with_suffix(".pyi").read_text(encoding="utf-8")
    names = re.findall(r" as (\w+)", stub)
    assert len(names) == len(set(names)) < 60
    assert names == lostmotion.__all__
    assert sorted(names) == dir(lostmotion)
    for name in names:
        assert getattr(importlib.import_module(lostmotion.HOMES[name]), name) is getattr(
            lostmotion, name
        )


@pytest.mark.parametrize(
    "name",
    [
        name
        for name in lostmotion.__all__
        if name not in NAMES and inspect.isfunction(getattr(lostmotion, name))
    ],
)
def test_public_functions_have_typed_arguments(name):
    """No argument without a type, and none that takes anything."""
    for each in inspect.signature(getattr(lostmotion, name)).parameters.values():
        assert each.annotation is not inspect.Parameter.empty
        assert each.kind is not inspect.Parameter.VAR_KEYWORD
        assert getattr(lostmotion, name).__doc__


@pytest.mark.parametrize(
    "words",
    [
        "",
        "run",
        *sorted(
            {
                name
                for each in lostmotion.QUESTIONS
                for name in (command_name(each), command_name(each).partition(" ")[0])
            }
        ),
    ],
)
def test_every_command_and_group_of_commands_has_help(words, tmp_path):
    """`--help` prints the usage and ends with exit code 0: of the program, of each command, and of
    what several commands begin with.
    """
    done = carried_out(*words.split(), "--help", cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    assert re.match(rf"\s*Usage: .*{' '.join(['lostmotion', *words.split()])} ", done.stdout)
    assert all(name in done.stdout for name in ("c ", "fmu ") if words == "export")


def test_help_of_a_process_names_how_it_was_started():
    """As a module of Python, as it stands before each command."""
    done = subprocess.run(
        [sys.executable, "-m", "lostmotion", "study", "--help"],
        capture_output=True,
        text=True,
        check=False,
    )
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.lstrip().startswith("Usage: python -m lostmotion study ")


def test_help_loads_nothing_heavy():
    """`lostmotion --help`, and that of each command, load neither NumPy nor what checks files nor
    what prints tables.
    """
    heavy = (
        "numpy",
        "numba",
        "scipy",
        "pint",
        "lxml",
        "matplotlib",
        "xarray",
        "rich",
        "zarr",
        "tomlkit",
    )
    for words in (["--help"], ["map", "--help"], ["iso9283", "--help"]):
        code = (
            f"import sys; sys.argv = ['lostmotion', *{words!r}]\n"
            "from lostmotion.cli import main\n"
            "try:\n    main()\nexcept SystemExit:\n"
            f"    sys.__stderr__.write(' '.join(m for m in {heavy!r} if m in sys.modules))\n"
        )
        done = subprocess.run(
            [sys.executable, "-c", code], capture_output=True, text=True, check=True
        )
        assert "Usage: " in done.stdout
        assert done.stderr == ""


def test_a_wrong_input_is_refused_before_anything_heavy_is_loaded(tmp_path):
    """A file that is not there or is no TOML, and wrong words beside it: one message, without
    arrays, units, checks of files or tables.
    """
    (tmp_path / "torn.toml").write_text("name = \n", encoding="utf-8")
    heavy = (
        "numpy",
        "numba",
        "scipy",
        "pint",
        "lxml",
        "matplotlib",
        "xarray",
        "rich",
        "zarr",
        "tomlkit",
    )
    for words in (
        ["study", "none.toml"],
        ["map", "torn.toml"],
        ["target", "none.urdf"],
        ["study", "none.toml", "--robots", "many"],
    ):
        code = (
            f"import sys; sys.argv = ['lostmotion', *{words!r}]\n"
            "from lostmotion.cli import main\n"
            "try:\n    main()\nexcept SystemExit as end:\n"
            f"    print(end.code, *[m for m in {heavy!r} if m in sys.modules], "
            "file=sys.__stderr__)\n"
        )
        done = subprocess.run(
            [sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=tmp_path
        )
        assert "mistake" in done.stderr
        assert done.stderr.splitlines()[-1] == "2"


@pytest.mark.parametrize("typed", ["--1", "+-3", "1" * 5000])
def test_a_count_that_is_no_number_is_one_message(typed):
    """Two signs, and more digits than a number has, are refused under the name of the argument."""
    with pytest.raises(lostmotion.InputError, match="a whole number"):
        lostmotion.study("examples/planar-2r.toml", visits=typed)
