"""The simulated measurements beside the examples."""

from __future__ import annotations

import re
import runpy
import sys
from pathlib import Path

import pytest

FOLDER = Path(__file__).parents[2] / "examples" / "measured"
NUMBER = re.compile(r"-?\d+\.\d+")


@pytest.mark.parametrize(("what", "file"), [("visits", "z-arm.csv"), ("loads", "z-arm-loads.csv")])
def test_the_files_are_what_their_script_writes(monkeypatch, capsys, what, file):
    """Row by row, each reading to a micrometre: processors differ in the last digit; else run
    examples/measured/make.py.
    """
    monkeypatch.setattr(sys, "argv", ["make.py", what])
    runpy.run_path(str(FOLDER / "make.py"), run_name="__main__")
    written = capsys.readouterr().out
    stored = (FOLDER / file).read_text("utf-8")
    assert NUMBER.sub("#", written).split() == NUMBER.sub("#", stored).split()
    assert list(map(float, NUMBER.findall(written))) == pytest.approx(
        list(map(float, NUMBER.findall(stored))), abs=1e-3
    )
