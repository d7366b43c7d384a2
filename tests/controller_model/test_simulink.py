"""The script for MATLAB names the functions, sources, arguments and sizes of the C source.

MATLAB is not at hand: what the script does there is not tested.
"""

from __future__ import annotations

import re
import shutil
import subprocess

import numpy as np
import pytest

import lostmotion
from tests.parts.random_arms import EXAMPLES

# Inputs of the Simulink model by the arguments of C that they feed, all but the last one.
INPUTS = ("q", "load", "gravity", "side", "options")
SHOW = r"""
#include <stdio.h>
#include "lm_flat.h"
int main(void) {
    printf("%d %d %d", LM_FLAT_PREDICTION, LM_FLAT_COMMAND, LM_JOINTS);
    return 0;
}
"""


@pytest.fixture(scope="module")
def exported(tmp_path_factory):
    """Return the folder of an export and the text of its script."""
    folder = tmp_path_factory.mktemp("export")
    lostmotion.export_c(lostmotion.read(EXAMPLES / "z-arm.toml"), out=folder)
    return folder, (folder / "lm_simulink.m").read_text(encoding="utf-8")


def quoted(script, key):
    """Return the text that follows a key in the script."""
    return re.search(rf"'{key}', '([^']+)'", script).group(1)


def test_the_script_names_all_sources_and_the_header(exported):
    """Every C file of the folder is compiled once, and the header declares both functions."""
    folder, script = exported
    assert sorted(quoted(script, "SimUserSources").split()) == sorted(
        each.name for each in (folder / "src").glob("*.c")
    )
    assert quoted(script, "SimCustomHeaderCode") == '#include "lm_flat.h"'


@pytest.mark.skipif(not shutil.which("gcc"), reason="gcc is not installed")
def test_arguments_have_the_order_and_the_sizes_of_the_c_source(exported, tmp_path):
    """The inputs are connected in the order of the prototypes, with the widths that the compiler
    reads from the header; the results come last.
    """
    folder, script = exported
    main, program = tmp_path / "show.c", tmp_path / "show"
    main.write_text(SHOW, encoding="utf-8")
    subprocess.run(["gcc", f"-I{folder / 'src'}", str(main), "-o", str(program)], check=True)
    shown = subprocess.run([str(program)], check=True, capture_output=True, text=True).stdout
    prediction, command, joints = map(int, shown.split())
    widths = {"q": joints, "load": 10, "gravity": 3, "side": joints, "options": 4}
    assert tuple(re.search(r"strsplit\('([^']+)'\)", script).group(1).split()) == INPUTS
    header = (folder / "src/lm_flat.h").read_text(encoding="utf-8")
    callers = re.findall(r"add_caller\(model, '(\w+)', \[([^]]+)\]\)", script)
    assert [name for name, _ in callers] == ["predict", "compensate"]
    for (name, sizes), results in zip(callers, (prediction, command), strict=True):
        listed = re.search(rf"void lm_flat_{name}\(([^)]+)\)", header).group(1)
        *given, last = re.findall(r"(const )?double (\w+)\[\]", listed)
        assert last == ("", "out")
        assert tuple(argument for _, argument in given) == INPUTS[: len(given)]
        assert [joints if each == "joints" else int(each) for each in sizes.split()] == [
            *(widths[argument] for _, argument in given),
            results,
        ]
    assert re.search(r"^joints = (\d+);", script, re.MULTILINE).group(1) == str(joints)


def test_constants_are_those_of_the_arm(exported):
    """Load and gravity of the model are those of the controller in Python, to the last digit."""
    _, script = exported
    tables = lostmotion.controller(EXAMPLES / "z-arm.toml").tables
    for key, values in (("load_values", tables.load), ("gravity", tables.gravity)):
        text = re.search(rf"^{key} = '\[([^]]+)\]';", script, re.MULTILINE).group(1)
        np.testing.assert_array_equal([float(each) for each in text.split()], values)
