"""examples/controller: robots that are drawn one by one arrive where the controller and the study
say.
"""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path

import numpy as np
import pytest

import lostmotion

# A row of docs/validation.md each: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "drawn robots, compensated and calibrated",
        (
            "exact composition of all errors of 24 robots at the corrected commands, beside the "
            "study's waterfall"
        ),
        "95 % intervals overlap at every stage; 95 % of what gravity causes taken away",
    ),
)

FOLDER = Path(__file__).parents[2] / "examples" / "controller"


@pytest.fixture(scope="module")
def example():
    """Return the example as a module."""
    described = importlib.util.spec_from_file_location("demonstrate", FOLDER / "demonstrate.py")
    module = importlib.util.module_from_spec(described)
    sys.modules["demonstrate"] = module
    described.loader.exec_module(module)
    return module


@pytest.mark.slow
def test_drawn_robots_gain_what_the_study_predicts(example, monkeypatch):
    """At every stage the intervals of drawn robots and of the study overlap; with each robot mapped
    95 % of what gravity causes is gone.
    """
    monkeypatch.setattr(example, "POSES", 32)
    monkeypatch.setattr(example, "ROBOTS", 24)
    arm = lostmotion.read(FOLDER.parent / "z-arm-drawn.toml")
    found = example.demonstrate(arm)
    stages = {stage.name: stage.q95 for stage in found.predicted.stages}
    for sent, of in example.STAGES.items():
        _, low, high = example.percentile(found.errors[sent])
        assert low < stages[of].high, sent
        assert high > stages[of].low, sent
    before, by_design, mapped = np.sqrt((found.by_gravity**2).mean(axis=1))
    assert mapped <= 0.05 * before
    assert mapped < by_design
    sheet, plots = example.sheet_of(arm, found)
    assert [row.label for row in sheet.sections[0].rows] == list(example.STAGES)
    assert len(example.contents(sheet, plots)) == 2
