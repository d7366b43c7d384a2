"""The plots say what the figures say, with units on their axes."""

from __future__ import annotations

import functools
import math
import re
from dataclasses import replace

import numpy as np
import pytest
from matplotlib.patches import StepPatch

import lostmotion
from lostmotion.analyses.accuracy.page import plots
from lostmotion.analyses.accuracy.page.arm_plots import arm_in_workspace, sections_of
from lostmotion.error_model.budget import costs
from lostmotion.error_model.error_bins import bin_edges
from lostmotion.mechanism.vertical_axis import vertical_axis
from lostmotion.propagation.montecarlo.histogram import linear_bins
from lostmotion.reporting.chart import label, mark_at, named_rows, one
from lostmotion.reporting.plot import Plot
from lostmotion.reporting.section import sections
from lostmotion.reporting.sheet import length
from lostmotion.reporting.svg import inline_svg
from tests.arms import STIFF, TURNING, small_study
from tests.reporting.chart_texts import axis_titles, crowded, unprinted

SLIDING = {"type": "prismatic", "name": "S", "axis": "x", "limits": ("0 mm", "300 mm")}


def study_of(*joints: dict[str, object], visits: int = 3) -> lostmotion.Study:
    """Study an arm of these joints, quickly."""
    arm = lostmotion.Arm.model_validate(
        {"name": "odd", "joints": joints, "payload": {"mass": "3 kg"}}
    )
    return lostmotion.study(arm, 16, 16, visits, threads=1)


@functools.cache
def drawn() -> list[Plot]:
    """Return the plots of the small study, of which nothing is changed."""
    return list(plots.plots(small_study()))


def test_every_axis_names_its_unit():
    """A thesis prints these plots: whoever sees one alone knows what is drawn and in which unit."""
    for plot in drawn():
        titles = axis_titles(plot)
        assert titles, plot.key
        assert not crowded(plot.figure), plot.key
        for title in titles:
            # the two panels count robots on the left one's axis
            shared = plot.key == "ap-rp" and not title
            assert shared or title.endswith("]") or "], " in title, (plot.key, title)


def test_every_figure_in_a_plot_is_in_the_tables():
    """Whoever reads a number in a plot finds the same number in the tables and in result.json."""
    sheet = small_study().sheet
    assert {plot.key: unprinted(plot, sheet) for plot in drawn()} == {
        plot.key: set() for plot in drawn()
    }


def test_a_figure_that_no_table_prints_is_found():
    """The check of the texts sees a wrong number."""
    study = small_study()
    figure, on = one("95th percentile", 60)
    mark_at(on, 0.5, "95th percentile 1.2345 mm")
    assert unprinted(Plot("k", "s", figure, ""), study.sheet) == {"1.2345"}


def test_no_two_plots_share_a_key():
    """Keys name files and places on the page."""
    keys = [plot.key for plot in drawn()]
    assert len(set(keys)) == len(keys) == 12


def areas(figure):
    """Return the sum of the steps in each histogram of a figure."""
    return [
        float(patch.get_data().values.sum())
        for on in figure.axes
        for patch in on.patches
        if isinstance(patch, StepPatch)
    ]


def test_histogram_counts_every_sample_once():
    """Each of the 64 poses x 32 robots x 3 visits is in a bar, none lost at an edge."""
    assert areas(plots.error_histogram(small_study())) == [pytest.approx(100)]


def test_histogram_agrees_with_the_quantile_it_marks():
    """Half of the counted samples lie left of the 50 % line."""
    study = small_study()
    edges, counts = linear_bins(study.sampled.replicate_hist.sum(axis=0))
    middle = plots.pooled_quantile(
        study.sampled.group_hist, study.sampled.replicate_hist, 0.5
    ).value
    below = np.interp(middle, edges, np.concatenate([[0], np.cumsum(counts)]))
    assert below == pytest.approx(counts.sum() / 2, rel=0.02)


@pytest.mark.parametrize(
    "errors", [np.array([1e-3]), np.array([1e-9, 3.0]), np.linspace(1e-4, 2e-3, 1000)]
)
def test_linear_bins_lose_no_sample(errors):
    """Whether one error or a thousand, over one bin or nine decades, the bars add up and their
    edges rise by a round step.
    """
    hist = np.histogram(errors, bin_edges())[0]
    edges, counts = linear_bins(hist)
    assert counts.sum() == len(errors)
    assert len(counts) <= 130
    step = edges[1] - edges[0]
    assert round(step / 10 ** math.floor(math.log10(step) + 1e-9), 6) in {1.0, 2.0, 2.5, 5.0}


def test_robot_histograms_count_every_robot():
    """32 robots were built, so each of AP, RP of the ISO cycle and RP from any side shows 32."""
    assert areas(plots.accuracy_over_robots(small_study())) == [32, 32, 32]


def test_one_visit_has_no_repeatability_to_draw():
    """A robot that returns once shows no scatter: the plot is omitted, and asking for it states
    why.
    """
    study = study_of(*TURNING[:2], visits=1)
    assert "ap-rp" not in {plot.key for plot in plots.plots(study)}
    with pytest.raises(ValueError, match="at least 2"):
        plots.accuracy_over_robots(study)


def names_of(figure):
    """Return the names beside the bars of a figure, from the top."""
    return [each.get_text() for each in figure.axes[0].get_yticklabels()]


def test_budget_bars_add_to_the_whole():
    """Shares, with the small parts put together as others, make 100 %, the largest on top."""
    figure = plots.budget(small_study())
    widths = [bar.get_width() for bar in figure.axes[0].patches]
    assert sum(widths) == pytest.approx(100)
    assert names_of(figure)[-1] == "5 others"
    assert widths[:-1] == sorted(widths[:-1], reverse=True)


def test_budget_names_the_largest_contributor_first():
    """The bar on top is the part that costs most."""
    study = small_study()
    assert names_of(plots.budget(study))[0] == costs(study.sampled.tally)[0].part.removeprefix(
        "joints."
    )


def test_levels_end_at_what_remains():
    """The three stacked bars reach to the r.m.s. as manufactured, without design errors, and with
    the visits' alone.
    """
    study = small_study()
    squares = study.sampled.tally.levels / study.sampled.tally.poses
    reached = np.zeros(3)
    for bar in plots.levels(study.budget).axes[0].patches:
        row = round(bar.get_y() + bar.get_height() / 2)
        reached[row] = max(reached[row], bar.get_x() + bar.get_width())
    expected = np.sqrt([squares.sum(), squares[1:].sum(), squares[2]])
    assert reached / reached[0] == pytest.approx(expected / expected[0])


def test_forces_and_torques_do_not_share_an_axis():
    """A sliding joint holds newtons, a turning one newton metres."""
    figure = plots.torques(study_of(SLIDING, *TURNING[:2]))
    assert [on.get_xlabel() for on in figure.axes] == [
        "holding torque, magnitude [N m]",
        "holding force, magnitude [N]",
    ]


def sections_in(study):
    """Return the sections of a study by name."""
    return dict(sections(sections_of(plots.pose_errors(study))))


def test_sections_have_equal_axes_and_the_classes_of_the_arm_in_its_workspace():
    """A millimetre up is a millimetre across, and a colour means the same error on the first
    picture and on every section.
    """
    study = small_study()
    pictures = [
        *sections_in(study).values(),
        next(arm_in_workspace(plots.pose_errors(study))).figure,
    ]
    assert [figure.axes[0].get_aspect() for figure in pictures] == [1.0, 1.0, 1.0]
    names = [[each.get_text() for each in figure.legends[0].get_texts()][:7] for figure in pictures]
    assert names[0] == names[1] == names[2]


def test_a_section_from_the_side_contains_the_axis_of_a_turning_column():
    """Through the axis, with the worst pose turned into the section; without such an axis through
    the worst pose itself.
    """
    study = small_study()
    on = sections_in(study)["xoz"].axes[0]
    x, y = vertical_axis(study.arm)
    at = study.tool[plots.pose_errors(study).mean.argmax()]
    (ring,) = [line for line in on.lines if line.get_label() == "worst pose"]
    assert ring.get_xdata()[0] == pytest.approx(1e3 * (x + np.hypot(at[0] - x, at[1] - y)))
    assert ring.get_ydata()[0] == pytest.approx(1e3 * at[2])
    assert sections_in(study)["xoz"].get_suptitle() == f"Section XOZ, y = {1e3 * y:.4g} mm"
    lying = lostmotion.study(
        lostmotion.Arm.model_validate({"name": "no column", "joints": TURNING[1:]}),
        16,
        16,
        2,
        threads=1,
    )
    assert vertical_axis(lying.arm) is None
    where = 1e3 * lying.tool[plots.pose_errors(lying).mean.argmax(), 1]
    assert sections_in(lying)["xoz"].get_suptitle() == f"Section XOZ, y = {where:.4g} mm".replace(
        "-", "−"
    )


def test_a_section_has_no_width_where_the_workspace_has_none():
    """An arm that moves in a horizontal plane is cut horizontally alone; one slide moves along a
    line and has no section.
    """
    plane = {**TURNING[0], "axis": "z"}
    assert list(sections_in(study_of(plane, {**plane, "name": "second"}))) == ["xoy"]
    assert sections_in(study_of({**SLIDING, "lumped": {"angle": 0.0}})) == {}


def test_the_contour_of_the_target_separates_the_cells_within_it():
    """Between the smallest and the largest error of a section there is a line, named in the legend;
    beyond them none.
    """
    study = replace(small_study(), target=float(np.median(plots.pose_errors(small_study()).within)))
    assert [each.get_text() for each in sections_in(study)["xoz"].legends[0].get_texts()].count(
        f"target {length(study.target, stated=True)}"
    ) == 1
    beyond = sections_in(replace(study, target=1.0))["xoz"]
    assert not [
        each for each in beyond.legends[0].get_texts() if each.get_text().startswith("target")
    ]


@pytest.mark.parametrize(
    "joints",
    [(STIFF,), (SLIDING,), (SLIDING, *TURNING[:1])],
    ids=["no errors", "one slide", "slide and turn"],
)
def test_odd_arms_are_drawn(joints):
    """An arm stated to be free of errors, a single slide, a flat workspace: every plot is still
    made and finite where it has numbers.
    """
    for plot in plots.plots(study_of(*({**joint, "lumped": {"angle": 0.0}} for joint in joints))):
        assert "nan" not in inline_svg(plot).lower(), plot.key


def test_names_cannot_carry_mark_up_into_a_plot():
    """A name that looks like a tag or like a formula is shown as written, and a long one is cut."""
    figure, on = one("<i>title</i>", 60)
    named_rows(on, ["<b>A</b>", "$x^2$"])
    shown = re.findall(r">([^<>]*[A$t][^<>]*)</text>", inline_svg(Plot("k", "s", figure, "")))
    assert shown == ["&lt;b&gt;A&lt;/b&gt;", "$x^2$", "&lt;i&gt;title&lt;/i&gt;"]
    assert len(label("x" * 200)) == 36
