"""The comparison of figures before and after a change finds what moved, and nothing else."""

from __future__ import annotations

import copy
import json

import numpy as np
import pytest
import xarray

from tests.compare_figures import array_moves, comparison, main

FIGURE = {"name": "value", "value": 1.5, "unit": "mm", "interval": [1.4, 1.6]}


def row(label, **figure):
    """Return a row of one figure."""
    return {"label": label, "figures": [{**FIGURE, **figure}]}


RESULT = {
    "sections": [
        {
            "key": "error",
            "rows": [row("mean"), row("95 % below", value=2.0), row("largest", value=3.0)],
        },
        {"key": "iso9283", "rows": [row("RP, mean"), row("words", value=None, interval=None)]},
        {
            "key": "levels",
            "rows": [row("from load", name="share", unit="%", value=50.0, interval=None)],
        },
    ]
}


def changed(section, number, **figure):
    """Return the result with one figure changed."""
    other = copy.deepcopy(RESULT)
    other["sections"][section]["rows"][number]["figures"][0] |= figure
    return other


def with_rows(*rows):
    """Return the result with other rows of the first table."""
    other = copy.deepcopy(RESULT)
    other["sections"][0]["rows"] = list(rows)
    return other


def places(before, after, question="study-arm"):
    """Return the places of the figures that moved."""
    return [move.place for move in comparison(question, before, after).moves]


def test_the_same_figures_under_other_words_are_no_difference():
    """Labels of rows and columns may change, and each change is listed."""
    other = json.loads(
        json.dumps(RESULT)
        .replace("largest", "maximum")
        .replace('"name": "share"', '"name": "part"')
        .replace("95 % below", "95th percentile")
    )
    found = comparison("study-arm", RESULT, other)
    assert (found.moves, found.gone, found.new) == ([], [], [])
    assert found.renamed == {
        "error: largest -> maximum",
        "error: 95 % below -> 95th percentile",
        "levels: share -> part",
    }


def test_a_table_of_another_key_is_matched_by_its_rows():
    """A table with the same rows between the same tables is the same table, and its figures are
    compared.
    """
    other = json.loads(json.dumps(changed(1, 0, value=2.0)).replace("iso9283", "standard"))
    found = comparison("study-arm", RESULT, other)
    assert ([move.place for move in found.moves], found.renamed) == (
        ["standard: RP, mean: value.value"],
        {"tables: iso9283 -> standard"},
    )
    other["sections"][1]["rows"][0]["label"] = "RP"
    found = comparison("study-arm", RESULT, other)
    assert (found.moves, found.gone, found.new) == ([], ["tables: iso9283"], ["tables: standard"])


def test_rows_that_changed_places_are_matched_by_their_labels():
    """A table sorted by size may have another order."""
    mean, level, largest = RESULT["sections"][0]["rows"]
    found = comparison("study-arm", RESULT, with_rows(largest, mean, level))
    assert (found.moves, found.renamed, found.gone, found.new) == ([], set(), [], [])


def test_an_inserted_row_leaves_the_others_matched():
    """A row more is new, and no other figure is compared with its neighbour."""
    mean, level, largest = RESULT["sections"][0]["rows"]
    found = comparison(
        "study-arm", RESULT, with_rows(mean, row("standard deviation"), level, largest)
    )
    assert (found.moves, found.gone, found.new) == ([], [], ["error: standard deviation"])


@pytest.mark.parametrize(
    "rows",
    [
        [row("largest error", value=3.0), row("noise")],
        [row("largest error", value=3.0, unit="µm")],
        [],
    ],
)
def test_rows_of_changed_labels_are_not_matched_by_guess(rows):
    """With another number of rows between the same neighbours, or another unit, both sides are
    reported by name.
    """
    found = comparison("study-arm", RESULT, with_rows(*RESULT["sections"][0]["rows"][:2], *rows))
    assert (found.moves, found.gone, found.new) == (
        [],
        ["error: largest"],
        [f"error: {each['label']}" for each in rows],
    )


@pytest.mark.parametrize(
    ("section", "number", "figure", "count"),
    [
        (0, 0, {"value": 1.5 * (1 + 1e-9)}, 1),
        (0, 0, {"value": 1.5 * (1 + 1e-11)}, 0),
        (0, 2, {"interval": [1.4, 1.7]}, 1),
        (0, 2, {"interval": None}, 2),
        (1, 0, {"value": 1.5 * (1 + 1e-9)}, 0),
        (1, 0, {"value": 1.5 * (1 + 1e-7)}, 1),
        (1, 1, {"value": 2.0}, 1),
        (2, 0, {"value": 50.0 + 5e-11}, 0),
        (2, 0, {"value": 50.0 + 2e-10}, 1),
    ],
)
def test_a_figure_that_moved_is_found(section, number, figure, count):
    """Values and ends of intervals, RP with its wider limit, shares with their limit of the whole,
    a number where there was none.
    """
    assert len(places(RESULT, changed(section, number, **figure))) == count


def test_figures_without_sampling_may_move_within_their_uncertainty():
    """The mean by 0.05 %, percentiles by 0.1 %."""
    assert places(RESULT, changed(0, 0, value=1.5 * 1.0004), "analytic-arm") == []
    assert places(RESULT, changed(0, 0, value=1.5 * 1.0008), "analytic-arm") == [
        "error: mean: value.value"
    ]
    assert places(RESULT, changed(0, 2, value=3.0 * 1.0008), "analytic-arm") == []
    assert places(RESULT, changed(0, 2, value=3.0 * 1.002), "analytic-arm") == [
        "error: largest: value.value"
    ]


def test_the_rounding_of_a_larger_figure_is_no_difference():
    """A torque of zero is the rounding of the other torques."""
    before, after = (
        with_rows(row("large", value=100.0), row("none", value=value, interval=None))
        for value in (1e-15, -8e-15)
    )
    assert places(before, after) == []


@pytest.mark.parametrize(("question", "moved"), [("study-arm", 1), ("analytic-arm", 0)])
def test_single_poses_may_move_where_nothing_is_sampled(tmp_path, question, moved):
    """One pose in two hundred may move further than the limit; in a study none may."""
    before = np.linspace(1.0, 2.0, 200)
    after = before.copy()
    after[7] *= 1.02
    for name, values in (("before", before), ("after", after)):
        xarray.Dataset({"error_mean": ("pose", values)}).to_netcdf(tmp_path / name)
    assert len(array_moves(question, tmp_path / "before", tmp_path / "after")) == moved


def test_the_script_prints_each_move_and_fails(tmp_path, capsys):
    """Exit code 1 where something moved or is missing, 0 where all is as before."""
    for name in ("before", "after"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "study-arm.json").write_text(json.dumps(RESULT), encoding="utf-8")
    words = ["compare", str(tmp_path / "before"), str(tmp_path / "after")]
    assert main(words) == 0
    other = changed(0, 2, value=4.0)
    other["sections"][1]["rows"].pop()
    (tmp_path / "after" / "study-arm.json").write_text(json.dumps(other), encoding="utf-8")
    (tmp_path / "before" / "map-arm.json").write_text(json.dumps(RESULT), encoding="utf-8")
    capsys.readouterr()
    assert main(words) == 1
    assert capsys.readouterr().out.splitlines() == [
        "map-arm: not recorded after",
        "study-arm: error: largest: value.value: 0.003 -> 0.004 (2.5e-01)",
        "study-arm: 1 gone: iso9283: words",
    ]
