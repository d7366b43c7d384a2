"""Extremes of a run, reproduced from their draws."""

from __future__ import annotations

import io
import json

import numpy as np
import pytest
from rich.console import Console

import lostmotion
from lostmotion.mechanism.placed_terms import short_name
from lostmotion.reporting.layout import row_at
from lostmotion.reporting.screen import print_sheet
from lostmotion.reporting.sheet import length
from lostmotion.runs.blocks import COLUMNS
from tests.command import carried_out as ran
from tests.runs.conftest import ARM, SWEEP

# A row of docs/validation.md each: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "replayed extremes",
        "the stored length, by the recomputed block and by the sum over terms",
        "bit for bit; 1e-12",
    ),
)


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """Carry out a small sweep."""
    folder = tmp_path_factory.mktemp("replayed")
    (folder / "tiny.toml").write_text(ARM + SWEEP, encoding="utf-8")
    return lostmotion.sweep(
        folder / "tiny.toml", poses=64, robots=20, visits=3, block=8, out=folder / "run", workers=2
    )


def test_an_extreme_is_reproduced(run):
    """From its pose and draws the error has the stored length: to the bit by its block, within
    1e-12 by the sum over terms, whose parts add up.
    """
    found = lostmotion.replay(run.store.folder, worst=5)
    assert len(found) == 5
    for each in found:
        assert each.kernel == each.found.error
        assert each.apart < 1e-12
        assert sum(term.along for term in each.terms) == pytest.approx(each.length, rel=1e-12)
        np.testing.assert_allclose(
            sum(term.shift for term in each.terms), each.error, rtol=1e-12, atol=1e-20
        )
        assert (
            np.linalg.norm(each.exact[:3, 3] - each.tool[:3, 3] - each.error) < 1e-3 * each.length
        )
        assert not each.others
        assert [abs(term.along) for term in each.terms] == sorted(
            (abs(term.along) for term in each.terms), reverse=True
        )


def test_the_largest_are_the_largest(run):
    """What is replayed are the largest errors that the blocks hold, over all designs or of one,
    each of a pose of its own.
    """
    order, store = run.store.order, run.store
    largest = COLUMNS.index("largest")
    errors = np.array(
        [
            np.concatenate(
                [store.read(k, block).poses[:, largest] for block in range(order.blocks)]
            )
            for k in range(order.designs)
        ]
    )
    assert [each.found.error for each in lostmotion.replay(store.folder, worst=4)] == sorted(
        errors.ravel(), reverse=True
    )[:4]
    of_one = lostmotion.replay(store.folder, design=1, worst=100)
    assert [each.found.error for each in of_one] == sorted(errors[1], reverse=True)
    assert sorted(each.found.pose for each in of_one) == list(range(64))


def test_joint_values_are_those_of_the_pose(run):
    """The pose of an extreme is the one that the study visits under this number, and the tool
    stands where the arm puts it.
    """
    each = lostmotion.replay(run.store.folder)[0]
    arm = run.store.order.read(each.found.design)
    q = lostmotion.sample_poses(arm, 64, seed=1).q[each.found.pose]
    np.testing.assert_array_equal(each.found.q, q)
    np.testing.assert_allclose(
        lostmotion.state_of(arm, q[None]).frames[-1, 0], each.tool, atol=1e-15
    )


def test_the_sheet_compares_stored_and_replayed_error(run):
    """The sheet has the stored and the recomputed magnitude, and whether they are identical."""
    sheet = lostmotion.replay(run.store.folder)[0].sheet
    assert row_at(sheet.sections, "length", "block_recomputed").note == "identical"
    stored = row_at(sheet.sections, "length", "stored").cells[0]
    assert stored.value == pytest.approx(sheet.facts["error_m"])
    assert sum(
        row.cells[2].as_shown
        for section in sheet.sections
        if section.key.startswith("terms_")
        for row in section.rows
    ) == pytest.approx(100)


def test_the_headline_names_the_largest_terms(run):
    """The question is what an error is made of: the three terms with the largest component along it
    stand in the first sentence, largest first.
    """
    each = lostmotion.replay(run.store.folder)[0]
    assert np.argmax([abs(term.along) for term in each.terms]) == 0
    named = [
        each.sheet.verdict.index(f"{short_name(term.name)} {length(term.along)}")
        for term in each.terms[:3]
    ]
    assert named == sorted(named)


def test_the_terms_fit_a_terminal(run):
    """At 80 columns every term is one line in its table, and its shift one line with a column for
    each axis that add up to the error.
    """
    each = lostmotion.replay(run.store.folder)[0]
    with (screen := Console(width=80, file=io.StringIO(), force_terminal=False)).capture() as said:
        print_sheet(each.sheet, screen)
    lines = said.get().splitlines()
    assert max(map(len, lines)) <= 80
    shown = [
        row.label
        for section in each.sheet.sections
        if section.key == "moves"
        for row in section.rows
    ]
    assert len(shown) > 5
    for name in shown:
        assert len([line for line in lines if line.startswith(f" {name} ")]) == 2
    moves = next(section for section in each.sheet.sections if section.key == "moves")
    assert moves.columns == ("X", "Y", "Z")
    for k in range(3):
        assert sum(row.cells[k].as_shown for row in moves.rows) == pytest.approx(
            1e6 * each.error[k], rel=0.02, abs=1
        )


def test_the_command_prints_it(run):
    """`lostmotion replay` prints data for machines, and refuses designs that are none with a
    word.
    """
    folder = run.store.folder
    found = ran("replay", folder.name, "--design", "2", "--worst", "2", "--json", cwd=folder.parent)
    assert found.returncode == 0, found.stderr
    said = json.loads(found.stdout)
    assert [each["design"] for each in said] == [2, 2]
    assert all(each["same_bits"] for each in said)
    with pytest.raises(lostmotion.InputError, match="from 0 to 3"):
        lostmotion.replay(folder, design=4)
    with pytest.raises(lostmotion.LostmotionError, match=r"no run: no run\.json in it"):
        lostmotion.replay(folder.parent)
