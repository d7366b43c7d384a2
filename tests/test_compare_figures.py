"""The comparison of figures before and after a change finds what moved, and nothing else."""

from __future__ import annotations

import copy
import json

import pytest

from tests.compare_figures import MONTE_CARLO, main, moves

FIGURE = {"value": 1.5, "unit": "mm", "interval": [1.4, 1.6]}


def row(label, **figure):
    """Return a row of one figure."""
    return {"label": label, "figures": [{**FIGURE, **figure}]}


RESULT = {
    "sections": [
        {"key": "error", "rows": [row("mean"), row("largest", value=3.0)]},
        {"key": "iso9283", "rows": [row("RP, mean"), row("words", value=None, interval=None)]},
    ]
}


def changed(section, number, **figure):
    """Return the result with one figure changed."""
    other = copy.deepcopy(RESULT)
    other["sections"][section]["rows"][number]["figures"][0] |= figure
    return other


def test_the_same_figures_under_other_words_are_no_difference():
    """Labels may change as they like."""
    other = json.loads(json.dumps(RESULT).replace("largest", "maximum"))
    assert moves(RESULT, other, MONTE_CARLO) == []


@pytest.mark.parametrize(
    ("section", "number", "figure", "count"),
    [
        (0, 0, {"value": 1.5 * (1 + 1e-9)}, 1),
        (0, 0, {"value": 1.5 * (1 + 1e-11)}, 0),
        (0, 1, {"interval": [1.4, 1.7]}, 1),
        (0, 1, {"interval": None}, 2),
        (1, 0, {"value": 1.5 * (1 + 1e-9)}, 0),
        (1, 0, {"value": 1.5 * (1 + 1e-7)}, 1),
        (1, 1, {"value": 2.0}, 1),
    ],
)
def test_a_figure_that_moved_is_found(section, number, figure, count):
    """Values and ends of intervals, RP with its wider limit, a number where there was none."""
    assert len(moves(RESULT, changed(section, number, **figure), MONTE_CARLO)) == count


def test_a_figure_that_is_gone_is_found():
    """A row less is a difference for its value and both ends."""
    other = copy.deepcopy(RESULT)
    other["sections"][0]["rows"].pop()
    assert [move.place for move in moves(RESULT, other, MONTE_CARLO)] == [f"error[1][0].{part} (largest)" for part in ("value", "low", "high")]


def test_the_script_prints_each_move_and_fails(tmp_path, capsys):
    """Exit code 1 where something moved or is missing, 0 where all is as before."""
    for name in ("before", "after"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "study-arm.json").write_text(json.dumps(RESULT), encoding="utf-8")
    words = ["compare", str(tmp_path / "before"), str(tmp_path / "after")]
    assert main(words) == 0
    (tmp_path / "after" / "study-arm.json").write_text(json.dumps(changed(0, 1, value=4.0)), encoding="utf-8")
    (tmp_path / "before" / "map-arm.json").write_text(json.dumps(RESULT), encoding="utf-8")
    assert main(words) == 1
    assert capsys.readouterr().out.splitlines() == ["map-arm: not recorded after", "study-arm: error[1][0].value (largest): 3.0 -> 4.0 (2.5e-01)"]
