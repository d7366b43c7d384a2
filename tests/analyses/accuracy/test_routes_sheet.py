"""What a study by both routes compares, and what it says where there is nothing to compare."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import lostmotion
from lostmotion.analyses.accuracy.page.beside_sampling import comparisons
from lostmotion.error_model.intervals import Estimate
from lostmotion.propagation.error_samples import Summed
from lostmotion.reporting.layout import row_at
from lostmotion.reporting.sheet import Cell, in_one_unit, length, several
from tests.reporting.first_screen import first_screen

ARM = Path(__file__).parents[3] / "examples" / "z-arm.toml"


@pytest.fixture(scope="module")
def alone():
    """Return the study of the Z-arm without sampling, in a zone too."""
    return lostmotion.study(lostmotion.read(ARM), 64, method="analytic", zone="x 0.1..0.6 m")


def summed(study, pooled=None):
    """Return the errors without sampling, with other figures where they are given."""
    return Summed.of(pooled or study.pooled, study.budget.squares)


def test_every_figure_over_all_poses_is_compared(z_arm_study):
    """Mean, 50, 95, 99 and 99.7 %, the standard deviation, and the two routes agree."""
    whole = next(section for section in z_arm_study.sheet.sections if section.key == "routes_all")
    assert [row.label for row in whole.rows] == [
        "mean",
        "standard deviation",
        "50th percentile",
        "95th percentile",
        "99th percentile",
        "99.7th percentile",
    ]
    assert all(row.cells[1].as_shown < 1 for row in whole.rows)
    assert all(row.note == "" for row in whole.rows)


@pytest.mark.parametrize("at", range(4))
def test_a_wrong_quantile_over_all_poses_is_seen(z_arm_study, at):
    """Half as large again is beyond Monte Carlo's interval, 99.7 % too, and no other row says
    so.
    """
    wrong = list(z_arm_study.pooled.quantiles)
    wrong[at] = Estimate(*(1.5 * end for end in (wrong[at].value, wrong[at].low, wrong[at].high)))
    whole, _ = comparisons(
        z_arm_study.analytic,
        summed(z_arm_study, replace(z_arm_study.pooled, quantiles=tuple(wrong))),
        z_arm_study.sampled,
    )
    assert [row.note for row in whole.rows] == [
        "beyond the interval" if k == at + 2 else "" for k in range(6)
    ]
    assert whole.rows[at + 2].cells[1].as_shown > 1


def test_the_reason_for_no_comparison_is_stated(z_arm_study):
    """Too few robots for Monte Carlo's interval, no figure without sampling."""
    _, each = comparisons(z_arm_study.analytic, summed(z_arm_study), z_arm_study.sampled)
    row = next(row for row in each.rows if row.label == "99th percentile")
    assert "no pose to compare" in row.note
    assert "too few robots" in row.note
    assert "over all poses alone" in each.note
    untold = replace(
        z_arm_study.pooled,
        quantiles=(*z_arm_study.pooled.quantiles[:3], Estimate(*[float("nan")] * 3)),
    )
    whole, _ = comparisons(z_arm_study.analytic, summed(z_arm_study, untold), z_arm_study.sampled)
    assert whole.rows[-1].note == "nothing to compare: uncertain by more than 5 %: use Monte Carlo"


def test_one_is_not_several_and_what_was_stated_has_no_zeros_behind():
    """One pose, two poses; a size that the arm file states is printed as it stands there, one that
    was found with its digits.
    """
    assert [several(count, "pose") for count in (0, 1, 2)] == ["0 poses", "1 pose", "2 poses"]
    stated = [
        str(Cell(1e-6 * value, "µm", stated=True)) for value in (0.001, 20.0, 12.5, 1234.0, 0.0)
    ]
    assert stated == ["0.001 µm", "20 µm", "12.5 µm", "1234 µm", "0 µm"]
    assert str(Cell(1.0, "%", stated=True)) == "100 %"
    assert str(Cell(1e-9, "µm")) == "0.00100 µm"
    assert str(Cell(-0.3, "µm", -6.0, 6.0)) == "0 µm"
    one = lostmotion.study(lostmotion.read(ARM), np.zeros((1, 5)), method="analytic")
    assert one.sheet.counts == "1 pose, exact sums over terms"


def test_a_target_says_each_factor_of_what():
    """A size beside what it is now, a factor as per cent of the errors; nothing is repeated."""
    arm = lostmotion.read(ARM.with_name("planar-2r.toml"))
    found = lostmotion.target(arm, error="0.2 mm", poses=8, robots=20, visits=2)
    sections = {section.key: section for section in found.sheet.sections}
    sized = [row for key in ("single", "kinds") if key in sections for row in sections[key].rows]
    assert sized
    for row in sized:
        assert row.note.startswith(("as stated ", "of its "))
        assert "x the error" not in row.note
        assert "100.00 %" not in row.note
    assert sections["together"].columns[-1] == "share"
    shares = [row.cells[-1].as_shown for row in sections["together"].rows]
    assert shares == sorted(shares, reverse=True)


def test_the_answer_without_sampling_has_its_interval_and_tiles(z_arm_study, alone):
    """The sentence says between which ends, as its table does, and the tiles show the same
    figures.
    """
    sheet = alone.sheet
    row = row_at(sheet.sections, "analytic", "p95").cells[0]
    assert f"within {row} ({row.between})." in sheet.verdict
    assert "(poses, bound)" not in sheet.verdict
    inside = row_at(sheet.sections, "zone_1_analytic", "p95").cells[0]
    assert (
        f"In the zone x 100 … 600 mm expect 95 % within {inside} ({inside.between})."
        in first_screen(sheet)
    )
    tiles = {card.title: (card.number, card.quiet) for card in sheet.cards}
    assert tiles["95 % of positions within"] == (str(row), f"interval {row.between}")
    assert tiles["95 % of positions within, x 100 … 600 mm"][0] == str(inside)
    assert tiles["largest contributor, share of mean square"][1] in sheet.verdict
    # One sentence for the study by both routes: Monte Carlo's own.
    assert z_arm_study.sheet.verdict.count("Expect 95 % of positions") == 1


def test_figures_that_need_sampling_are_listed_in_a_sentence(alone):
    """Where a figure is uncertain by more than 5 % the answer says so, what to do, and which figure
    is known all the same.
    """
    nothing = Estimate(*[float("nan")] * 3)
    sheet = replace(alone, pooled=replace(alone.pooled, quantiles=(nothing,) * 4)).sheet
    first, _, rest = sheet.verdict.partition(". ")
    assert first.startswith("Without sampling the 95 % error is uncertain by more than 5 %")
    assert "--method montecarlo" in first
    assert "largest contributor: " in rest
    assert f"The root mean square over all poses is {length(alone.budget.rms)}." in rest
    assert sheet.cards[0].number == "not known"


def test_a_root_mean_square_over_all_poses_has_an_interval(z_arm_study):
    """By either route, of the tool's rotation too: exact at the poses visited, with what their
    choice leaves; given poses are taken as they are.
    """
    sections = z_arm_study.sheet.sections
    square = row_at(sections, "analytic", "rms").cells[0]
    (whole,) = in_one_unit([row_at(sections, "levels", "all_together").cells[0]])
    (square,) = in_one_unit([square])
    assert (square.value, square.low, square.high) == pytest.approx(
        (whole.value, whole.low, whole.high), rel=1e-9
    )
    turned = row_at(sections, "error", "rotation_rms").cells[0]
    for figure in (square, turned):
        assert figure.low < figure.value < figure.high < 1.5 * figure.value
    given = lostmotion.study(lostmotion.read(ARM), z_arm_study.poses.q, method="analytic").sheet
    assert row_at(given.sections, "analytic", "rms").cells[0].interval == ""
    assert row_at(given.sections, "levels", "all_together").cells[0].interval == ""


def test_without_sampling_the_effect_of_halving_is_reported(z_arm_study, alone):
    """Over the workspace, part by part: what a study by samples says of the same poses, within both
    intervals, and worked out once.
    """
    section = next(section for section in alone.sheet.sections if section.key == "halving")
    assert alone.halving is alone.halving
    parts = [cost.part for cost in alone.budget.parts if cost.alone > 0]
    assert {row.label for row in section.rows[: len(parts)]} == {
        part.removeprefix("joints.") for part in parts
    }
    for part in parts:
        here, there = alone.halving.gains[part], z_arm_study.halving.gains[part]
        assert here.low <= there.high
        assert there.low <= here.high
    assert all(np.isfinite(row.cells[0].as_shown) and row.cells[0].interval for row in section.rows)


def test_errors_beyond_what_is_counted_are_refused_by_their_largest_part():
    """A play of 9e14 arcminutes is a mistake: no figure, plot or remedy follows from it."""
    arm = {
        "name": "far off",
        "joints": [
            {
                "name": "A",
                "type": "revolute",
                "axis": "z",
                "limits": ["-90 deg", "90 deg"],
                "gearbox": {"ratio": 100, "backlash": "9e14 arcmin"},
                "link": {"length": "400 mm ± 1 mm", "direction": "x"},
            }
        ],
    }
    with pytest.raises(lostmotion.InputError) as error:
        lostmotion.study(arm, poses=16, robots=4, visits=2)
    (problem,) = error.value.problems
    assert problem.key == "A.gearbox"
    assert "16 m" in problem.found
