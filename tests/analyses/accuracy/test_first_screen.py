"""What the first screen of a study shows: bars of the largest contributors and of the remedies, and
the headline.
"""

from dataclasses import replace
from pathlib import Path

import pytest

import lostmotion
from lostmotion.analyses.accuracy.page.first_screen import blame_bars, remedy_bars, rms_bars
from lostmotion.error_model.budget import Cost
from lostmotion.error_model.intervals import Estimate
from lostmotion.error_model.remedies import OUTPUT_ENCODERS, SIDE_AND_LOAD, SIDE_KNOWN, STAGES
from lostmotion.reporting.layout import key_of, row_at
from lostmotion.reporting.sheet import Bar, Bars, Cell

EXAMPLES = Path(__file__).parents[3] / "examples"


def _cost(name, share, levels=None):
    return Cost(f"joints.{name}", 1e-4, share, 1e-3, levels or (share, 0.0, 0.0))


def test_bars_show_the_figures_of_the_tables(z_arm_study):
    """Share and effect of halving are those of the error budget, what remedies leave that of the
    waterfall; all bars together are the whole.
    """
    sheet = z_arm_study.sheet
    blame, remedies = sheet.bars
    for bar in blame.bars[:-1]:
        row = row_at(sheet.sections, "budget", key_of(bar.label))
        assert bar.figure.value == row.cells[1].value == pytest.approx(bar.size)
        assert bar.effect.value == pytest.approx(row.cells[2].value)
        assert sum(bar.parts) == pytest.approx(bar.size)
    assert sum(bar.size for bar in blame.bars) == pytest.approx(1)
    # nineteen parts err: gearbox and encoder of the roll, whose axis the tool lies on, too, by the
    # bending beyond it
    assert blame.bars[-1].label == "14 others"
    rows = next(section for section in sheet.sections if section.key == "waterfall").rows
    # further remedies, listed below these, leave no less of this arm's error
    assert len(remedies.bars) == len(STAGES) < len(rows)
    assert [bar.figure for bar in remedies.bars] == [
        replace(row.cells[1], samples=bar.figure.samples)
        for row, bar in zip(rows[: len(STAGES)], remedies.bars, strict=True)
    ]


def test_without_sampling_bars_show_root_mean_squares():
    """An analytic study knows no percentile of a remedy: its bars show what each remedy leaves of
    the root mean square.
    """
    found = lostmotion.study(EXAMPLES / "planar-2r.toml", 64, method="analytic").sheet
    assert [bars.key for bars in found.bars] == ["budget", "remedies"]
    row = row_at(found.sections, "levels", "left_after_compensation_of_load_and_pose")
    (compensated,) = [bar for bar in found.bars[1].bars if bar.label == "load compensated"]
    assert compensated.figure.value == pytest.approx(row.cells[0].value)


def test_a_part_that_cancels_others_has_a_bar_to_the_left():
    """A large negative share is among the bars, below zero on the scale; six parts have a bar each,
    of more the smallest share one.
    """
    many = [_cost(f"J{k}", 0.15) for k in range(8)] + [_cost("B", -0.3), _cost("C", 0.1)]
    (blame,) = blame_bars(many, {}, "")
    assert [bar.label for bar in blame.bars] == [f"J{k}" for k in range(4)] + ["B", "5 others"]
    assert blame.bars[-1].size == pytest.approx(0.7)
    assert blame.ends == pytest.approx((-0.3, 0.7))
    assert "cancels" in blame.note
    (few,) = blame_bars(many[:6], {}, "")
    assert len(few.bars) == 6
    (split,) = blame_bars([_cost("A", 1.0, (1.5, -0.5, 0.0))], {}, "")
    assert split.ends == pytest.approx((-0.5, 1.5))


def test_reductions_share_one_unit():
    """What halving takes off is in µm where the largest is below 1 mm, else in mm; none without a
    run.
    """
    gains = {"joints.A": Estimate(2e-4, 1e-4, 3e-4), "joints.B": Estimate(1e-6, 0.0, 2e-6)}
    (blame,) = blame_bars([_cost("A", 0.9), _cost("B", 0.1)], gains, "")
    assert [bar.effect.shown for bar in blame.bars] == ["µm", "µm"]
    (without,) = blame_bars([_cost("B", 1.0)], {}, "")
    assert without.bars[0].effect is None


def test_where_nothing_errs_there_are_no_bars(z_arm_study):
    """No contributor and no remedy of an error of zero; a scale needs a length even then."""
    stages = tuple(
        replace(stage, q95=Estimate(0.0, 0.0, 0.0)) for stage in z_arm_study.waterfall.stages
    )
    assert remedy_bars(replace(z_arm_study.waterfall, stages=stages)) == ()
    assert blame_bars([replace(_cost("A", 0.0), alone=0.0)], {}, "") == ()
    assert Bars("", "", "", (Bar("", Cell(0.0, "mm"), 0.0),)).ends == (0.0, 1.0)


def test_a_remedy_of_all_described_errors_is_no_perfect_arm():
    """A bar of zero says that no described error is left, not that the arm errs by 0 µm."""
    left = dict.fromkeys(
        (*STAGES, SIDE_KNOWN, SIDE_AND_LOAD, OUTPUT_ENCODERS), Estimate(1e-4, 9e-5, 1.1e-4)
    )
    left[STAGES[-1]] = Estimate(0.0, 0.0, 0.0)
    (block,) = rms_bars(left, 64)
    assert str(block.bars[-1].figure) == "none described"
    assert (block.bars[-1].size, str(block.bars[0].figure)) == (0.0, "100 µm")
