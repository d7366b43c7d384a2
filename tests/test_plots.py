"""The plots say what the figures say, with units on their axes."""

from __future__ import annotations

import functools
import math

import numpy as np
import plotly.graph_objects as go
import pytest

import lostmotion
from lostmotion.analyses.accuracy.plots import study as plots
from lostmotion.error_model.budget import costs
from lostmotion.error_model.error_bins import bin_edges
from lostmotion.propagation.montecarlo.histogram import linear_bins
from lostmotion.reporting.plot import framed, label, styled

LINK = {"length": "400 mm ± 50 µm", "section": {"kind": "tube", "outer": "60 mm", "wall": "3 mm"}}
LINK["material"] = {"young": "70 GPa", "poisson": 0.33, "density": "2700 kg/m^3"}
JOINT = {
    "type": "revolute",
    "axis": "y",
    "limits": (-1, 1),
    "gearbox": {"backlash": "0.5 arcmin ± 0.2 arcmin", "stiffness": "120 N m/arcmin", "transmission_error": "1 arcmin", "ratio": 121},
    "bearing": {"kind": "rolling", "clearance": "40 µm ± 20 µm", "span": "50 mm"},
    "encoder": {"resolution": "1 arcmin"},
    "mounting": {"tilt": "0.5 arcmin", "offset": "20 µm"},
    "link": LINK,
}
TURNING = ({**JOINT, "name": "O", "axis": "z"}, {**JOINT, "name": "A"}, {**JOINT, "name": "B"}, {**JOINT, "name": "C"})
SLIDING = {"type": "prismatic", "name": "S", "axis": "x", "limits": ("0 mm", "300 mm")}
STIFF = {"type": "revolute", "axis": "z", "limits": (-1, 1), "name": "O", "link": {"length": "400 mm"}}


@functools.cache
def small_study(poses: int = 64, robots: int = 32, visits: int = 3, threads: int = 1, name: str = "test arm") -> lostmotion.Study:
    """Study an arm of four joints, quickly."""
    arm = lostmotion.Arm.model_validate({"name": name, "joints": TURNING, "payload": {"mass": "3 kg"}})
    return lostmotion.study(arm, poses, robots, visits, threads=threads)


def study_of(*joints: dict[str, object], visits: int = 3) -> lostmotion.Study:
    """Study an arm of these joints, quickly."""
    arm = lostmotion.Arm.model_validate({"name": "odd", "joints": joints, "payload": {"mass": "3 kg"}})
    return lostmotion.study(arm, 16, 16, visits, threads=1)


def titles_of(figure):
    """Return the titles of every axis that carries numbers."""
    layout = figure.to_plotly_json()["layout"]
    axes = [axis for key, axis in layout.get("scene", layout).items() if "axis" in key]
    return [axis.get("title", {}).get("text", "") for axis in axes if "ticktext" not in axis]


def test_every_axis_names_its_unit():
    """A thesis prints these plots: whoever sees one alone knows what is drawn and in which unit."""
    for plot in plots.plots(small_study()):
        titles = titles_of(plot.figure)
        assert titles, plot.key
        for title in titles:
            shared = plot.key == "ap-rp" and not title  # the two panels count robots on the left one's axis
            assert shared or (title.endswith("]") or "], " in title), (plot.key, title)


def test_no_two_plots_share_a_key():
    """Keys name files and places on the page."""
    keys = [plot.key for plot in plots.plots(small_study())]
    assert len(set(keys)) == len(keys) == 11


def test_histogram_counts_every_sample_once():
    """64 poses x 32 robots x 3 visits leave 6144 samples in the bars, none lost at an edge."""
    figure = plots.error_histogram(small_study())
    assert sum(figure.data[0].y) == 64 * 32 * 3


def test_histogram_agrees_with_the_quantile_it_marks():
    """Half of the counted samples lie left of the 50 % line."""
    study = small_study()
    edges, counts = linear_bins(study.sampled.replicate_hist.sum(axis=0))
    middle = plots.pooled_quantile(study.sampled.group_hist, study.sampled.replicate_hist, 0.5).value
    below = np.interp(middle, edges, np.concatenate([[0], np.cumsum(counts)]))
    assert below == pytest.approx(counts.sum() / 2, rel=0.02)


@pytest.mark.parametrize("errors", [np.array([1e-3]), np.array([1e-9, 3.0]), np.linspace(1e-4, 2e-3, 1000)])
def test_linear_bins_lose_no_sample(errors):
    """Whether one error or a thousand, over one bin or nine decades, the bars add up and their edges rise by a round step."""
    hist = np.histogram(errors, bin_edges())[0]
    edges, counts = linear_bins(hist)
    assert counts.sum() == len(errors)
    assert len(counts) <= 130
    step = edges[1] - edges[0]
    assert round(step / 10 ** math.floor(math.log10(step) + 1e-9), 6) in {1.0, 2.0, 2.5, 5.0}


def test_robot_histograms_count_every_robot():
    """32 robots were built, so each of AP and RP shows 32."""
    figure = plots.accuracy_over_robots(small_study())
    assert [sum(bars.y) for bars in figure.data] == [32, 32]


def test_one_visit_has_no_repeatability_to_draw():
    """A robot that returns once shows no scatter: the plot is omitted, and asking for it states why."""
    study = study_of(*TURNING[:2], visits=1)
    assert "ap-rp" not in {plot.key for plot in plots.plots(study)}
    with pytest.raises(ValueError, match="at least 2"):
        plots.accuracy_over_robots(study)


def test_budget_bars_add_to_the_whole():
    """Shares, with the small parts put together as others, make 100 %."""
    figure = plots.budget(small_study())
    assert sum(figure.data[0].x) == pytest.approx(100)
    assert figure.layout.yaxis.ticktext[-1] == "5 others"
    assert list(figure.data[0].x[:-1]) == sorted(figure.data[0].x[:-1], reverse=True)


def test_budget_names_the_largest_contributor_first():
    """The bar on top is the part that costs most."""
    study = small_study()
    assert plots.budget(study).layout.yaxis.ticktext[0] == costs(study.sampled.tally)[0].part.removeprefix("joints.")


def test_levels_end_at_what_remains():
    """The three stacked bars reach to the r.m.s. as manufactured, without design errors, and with the visits' alone."""
    study = small_study()
    squares = study.sampled.tally.levels / study.sampled.tally.poses
    figure = plots.levels(study.budget)
    reached = np.sum([bars.x for bars in figure.data], axis=0)
    expected = np.sqrt([squares.sum(), squares[1:].sum(), squares[2]])
    assert reached / reached[0] == pytest.approx(expected / expected[0])


def test_forces_and_torques_do_not_share_an_axis():
    """A sliding joint holds newtons, a turning one newton metres."""
    figure = plots.torques(study_of(SLIDING, *TURNING[:2]))
    assert [figure.layout.xaxis.title.text, figure.layout.xaxis2.title.text] == ["holding torque, magnitude [N m]", "holding force, magnitude [N]"]


def test_projections_have_equal_axes_and_one_colour_scale():
    """A millimetre up is a millimetre across, and a colour means the same error on every map."""
    study = small_study()
    figures = [plots.workspace_xoz(study), plots.workspace_xoy(study), plots.error_map(study)]
    assert [figure.layout.yaxis.scaleanchor for figure in figures[:2]] == ["x", "x"]
    scene = figures[2].layout.scene
    room = [scene.aspectratio[name] for name in "xyz"]
    sides = [end - begin for begin, end in (scene[f"{name}axis"].range for name in "xyz")]
    assert np.array(room) / room[0] == pytest.approx(np.array(sides) / sides[0])
    scales = {(trace.marker.cmin, trace.marker.cmax) for figure in figures for trace in figure.data if trace.marker.colorscale}
    assert len(scales) == 1


@pytest.mark.parametrize("joints", [(STIFF,), (SLIDING,), (SLIDING, *TURNING[:1])], ids=["no errors", "one slide", "slide and turn"])
def test_odd_arms_are_drawn(joints):
    """An arm stated to be free of errors, a single slide, a flat workspace: every plot is still made and finite where it has numbers."""
    for plot in plots.plots(study_of(*({**joint, "lumped": {"angle": 0.0}} for joint in joints))):
        assert "NaN" not in plot.figure.to_json(), plot.key


def test_names_cannot_carry_mark_up_into_a_plot():
    """Plotly reads tags in its texts; a name that looks like one is shown as written, and a long one is cut."""
    assert label("<b>A</b>") == "&lt;b&gt;A&lt;/b&gt;"
    assert len(label("x" * 200)) == 36


def test_a_plot_alone_looks_like_one_of_several_axes():
    """A figure that is laid out when it is made has the layout of one that is styled afterwards."""
    bars = go.Bar(x=[1, 2], y=[3, 4])
    assert framed("title", bars, height=300).to_plotly_json() == styled(go.Figure([bars]), "title", height=300).to_plotly_json()
