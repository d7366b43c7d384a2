"""An accuracy map from the file to the folder: arguments, sheet, plots and files."""

import io
import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import xarray
from rich.console import Console

import lostmotion
from lostmotion import Arm
from lostmotion.analyses.workspace_map.page.labels import percentile_label
from lostmotion.analyses.workspace_map.page.plots import map_plots
from lostmotion.maps.cell_statistics import CONFIGURATIONS, QUANTILE
from lostmotion.maps.radial import full_turn_axis, radial_section
from lostmotion.propagation.analytic import analytic
from lostmotion.reporting.layout import key_of, row_at
from lostmotion.reporting.screen import print_sheet
from lostmotion.reporting.sheet import length
from tests.command import carried_out, carried_out_by_process
from tests.reporting.chart_texts import axis_titles, crowded, unprinted

EXAMPLES = Path(__file__).parents[3] / "examples"
Z_ARM = EXAMPLES / "z-arm.toml"
QUICK = ("--cell", "60 mm", "--poses", "2048", "--per-cell", "2")


def ran(*words, cwd):
    """Run the command in a folder."""
    return carried_out("map", *words, cwd=cwd)


@pytest.fixture(scope="module")
def mapped():
    """Map the paper's arm once."""
    arm = lostmotion.read(Z_ARM)
    return lostmotion.map(
        arm,
        cell=0.2,
        by="worst",
        target=1e-3,
        box=(0.4, 0.4, 0.2),
        turned=True,
        floor=0.2,
        poses=4096,
        per_cell=3,
    )


def test_the_sheet_says_what_was_found(mapped):
    """Figures on the sheet are those of the map; the plain data is JSON without NaN."""
    sheet, found = mapped.sheet, mapped
    known = found.errors[QUANTILE, 2][found.centre]
    for cell, value in (
        ("most accurate cell", known.min()),
        ("median cell", np.median(known)),
        ("least accurate cell", known.max()),
    ):
        worst = row_at(sheet.sections, "map", key_of(f"95th percentile, {cell}")).cells[
            CONFIGURATIONS.index("worst")
        ]
        assert worst.value == pytest.approx(value)
        assert worst.low <= worst.value
        assert math.isnan(worst.high)  # how much worse other configurations are is not known
    share, size = row_at(sheet.sections, "within", "within_1_mm").cells
    assert share.value == pytest.approx(np.mean(found.validation.figures[QUANTILE, 2] <= 1e-3))
    assert share.low < share.value < share.high
    assert size.low < size.value < size.high
    assert abs(share.value - np.mean(known <= 1e-3)) < 0.1
    columns = next(section for section in sheet.sections if section.key == "budget")
    for k in range(len(columns.columns)):
        assert sum(row.cells[k].as_shown for row in columns.rows[1:]) == pytest.approx(100)
    assert (
        row_at(sheet.sections, "reach", "cells_reached").cells[0].as_shown
        == np.isfinite(found.selected).sum()
    )
    box = found.placements.best[0]
    assert (
        "centred at "
        f"{', '.join(f'{a} {v * 1e3:.0f}' for a, v in zip('xyz', box.centre, strict=True))} mm"
    ) in sheet.verdict
    json.dumps(mapped.result(), allow_nan=False)
    assert "AccuracyMap of 'Z-arm'" in repr(mapped)


@pytest.mark.parametrize(
    ("level", "name"),
    [
        (0.95, "95th"),
        (0.5, "50th"),
        (0.91, "91st"),
        (0.82, "82nd"),
        (0.63, "63rd"),
        (0.997, "99.7th"),
    ],
)
def test_a_quantile_is_named_as_a_percentile(mapped, level, name):
    """Ordinal numbers end as in English."""
    assert (
        percentile_label(replace(mapped, evaluated=replace(mapped.evaluated, level=level)))
        == f"{name} percentile"
    )


def test_every_figure_of_a_map_has_its_interval(mapped):
    """Cells, shares, sizes, placements and the volume have intervals, one-sided where a bound is
    unknown; counts are integers.
    """
    for section in mapped.sheet.sections:
        if section.key in {"map", "within", "places"}:
            for figure in (figure for row in section.rows for figure in row.cells):
                # of one that was drawn nothing is known of the others
                assert figure.interval or figure.samples == "1 configuration in the cell"
                assert figure.samples
                assert np.nanmin([figure.low, figure.value]) == (
                    figure.value if math.isnan(figure.low) else figure.low
                )
                assert np.nanmax([figure.high, figure.value]) == (
                    figure.value if math.isnan(figure.high) else figure.high
                )
    volume = row_at(mapped.sheet.sections, "reach", "volume").cells[0]
    assert volume.low < volume.value < volume.high
    assert "." not in str(
        row_at(mapped.sheet.sections, "reach", "configurations_in_a_cell_median").cells[0]
    )


def test_a_narrow_screen_cuts_no_word(mapped):
    """At 80 columns no heading is truncated, and no note is broken within a word."""
    page = io.StringIO()
    print_sheet(mapped.sheet, Console(file=page, width=80))
    lines = page.getvalue().splitlines()
    assert not [line for line in lines if "…" in line.replace(" … ", "")]
    words = {
        word
        for section in mapped.sheet.sections
        for row in section.rows
        for word in row.note.split()
    }
    shown = {word for line in lines for word in line.split()}
    assert words <= shown


def test_plots_show_the_map(mapped):
    """Slices show the cells of their height with equal axes, one set of classes and the target's
    contour; every figure in them is printed, and every plot belongs to a section.
    """
    found = mapped
    at = np.array([0.4, 0.1, 0.64])
    plots = {plot.key: plot for plot in map_plots(found, at)}
    assert set(plots) == {
        "slice-xy",
        "slice-xz",
        "slice-yz",
        "slices-z",
        "slices-y",
        "share",
        "budget",
    }
    assert {plot.section for plot in plots.values()} <= {
        section.key for section in found.sheet.sections
    }
    grid = found.reached.grid
    classes = set()
    for key, axis in (("slice-xy", 2), ("slice-xz", 1), ("slice-yz", 0)):
        figure = plots[key].figure
        (on,) = figure.axes
        index = int(np.argmin(np.abs(grid.centres_along(axis) - at[axis])))
        known = np.isfinite(np.take(found.selected, index, axis=axis)).sum()
        drawn = sum(
            np.ptp(ring[:, 0]) * np.ptp(ring[:, 1])
            for patch in on.patches
            for ring in patch.get_path().vertices.reshape(-1, 5, 2)
        )
        assert drawn == pytest.approx(known * (1e3 * grid.edge) ** 2)
        assert on.get_aspect() == 1.0
        assert on.get_legend_handles_labels()[1][0] == "target 1 mm"
        (legend,) = figure.legends
        assert legend.get_title().get_text() == "95th percentile, worst configuration [mm]"
        classes.add(tuple(each.get_text() for each in legend.get_texts()[:7]))
        assert f"{grid.centres_along(axis)[index] * 1e3:.4g} mm" in figure.get_suptitle()
    assert len(classes) == 1
    assert len(plots["slices-z"].figure.axes) == 6
    curve = plots["share"].figure.axes[0].lines[2]
    assert curve.get_ydata()[-1] == 100
    assert curve.get_xdata()[-1] == pytest.approx(
        1e3 * found.errors[QUANTILE, 2][found.centre].max()
    )
    assert not set().union(*(unprinted(plot, found.sheet) for plot in plots.values()))
    assert all("[" in title for plot in plots.values() for title in axis_titles(plot))
    assert not [plot.key for plot in plots.values() if crowded(plot.figure)]


@pytest.mark.usefixtures("unpainted")
def test_the_map_is_written_with_names_and_units(mapped, tmp_path):
    """arrays.nc reads back as the map, each variable with unit and meaning, at the cell centres; an
    existing folder is not overwritten.
    """
    folder = mapped.report(tmp_path / "out")
    assert sorted(path.name for path in folder.iterdir()) == [
        "arrays.nc",
        "report.html",
        "result.json",
    ]
    data = xarray.load_dataset(io.BytesIO((folder / "arrays.nc").read_bytes()), engine="scipy")
    found = mapped
    assert np.array_equal(data["error_quantile_worst"], found.selected, equal_nan=True)
    assert np.array_equal(data["x"], found.reached.grid.centres_along(0))
    assert all(one.attrs["units"] and one.attrs["long_name"] for one in data.variables.values())
    assert set(np.unique(data["place"])) <= {0, 1, 2, 3}
    assert int((data["within_target"] == 1).sum()) == (found.selected <= 1e-3).sum()
    assert float(data.sel(x=0.4, y=0.1, z=0.6, method="nearest")["error_quantile_worst"]) > 0
    with pytest.raises(lostmotion.OutputExistsError):
        mapped.report(tmp_path / "out")


def test_turned_places_hold_the_box(mapped):
    """Placements with any yaw stay above the floor and share no cell."""
    places = mapped.placements.best
    assert places
    assert all(box.centre[2] - box.size[2] / 2 >= 0.2 - 1e-9 for box in places)
    cells = np.concatenate([box.cells for box in places])
    assert len(np.unique(cells)) == len(cells)


def test_a_first_axis_that_turns_fully_has_a_radial_section():
    """A vertical first axis with 360° gives a radial section, as for the UR5e; the paper's arm with
    ±170° has none.
    """
    assert full_turn_axis(lostmotion.read(Z_ARM)) is None
    arm = lostmotion.read(EXAMPLES / "ur5e.urdf")
    assert full_turn_axis(arm) == pytest.approx((0, 0), abs=1e-9)
    found = lostmotion.map(arm, cell=0.3, by="best", poses=1024, per_cell=2)
    section = radial_section(found)
    known = np.isfinite(section.values)
    assert np.nanmin(section.values) == np.nanmin(found.selected)
    away = np.hypot(found.reached.points[:, 0], found.reached.points[:, 1])
    assert known.any(axis=1).sum() == math.ceil(away.max() / 0.3)
    assert "radial" in {plot.key for plot in map_plots(found)}


def test_a_planar_arm_has_one_slice():
    """An arm in a plane has a map of that plane, areas instead of volumes, and no isosurfaces."""
    links = [
        {
            "name": name,
            "type": "revolute",
            "axis": "-y",
            "limits": ("-90 deg", "90 deg"),
            "link": {"length": "0.4 m"},
            "encoder": {"zero": "1 arcmin"},
        }
        for name in "AB"
    ]
    mapped = lostmotion.map(
        Arm.model_validate({"name": "plane", "joints": links}),
        cell=0.05,
        poses=1024,
        per_cell=3,
        box=(0.1, 0, 0.1),
    )
    assert {plot.key for plot in map_plots(mapped)} == {"slice-xz", "share", "budget"}
    row = row_at(mapped.sheet.sections, "reach", "area")
    assert row.cells[0].shown == "m²"
    assert row.cells[0].low < row.cells[0].as_shown <= row.cells[0].high
    json.dumps(mapped.result(), allow_nan=False)


def test_a_share_and_its_size_agree():
    """Where all cells are equally accurate, every share and its size are those of the whole
    workspace.
    """
    slide = {
        "name": "A",
        "type": "prismatic",
        "axis": "x",
        "limits": (0.0, 0.5),
        "encoder": {"zero": 1e-5},
        "link": {"length": 0.1},
    }
    asked = lostmotion.map(Arm(name="slide", joints=[slide]), cell=0.05, poses=512, per_cell=2)
    whole = asked.size.value
    rows = next(section for section in asked.sheet.sections if section.key == "within").rows
    assert whole > 0
    assert len(rows) == 1  # and is reported once
    for row in rows:
        assert row.cells[1].as_shown == pytest.approx(row.cells[0].as_shown / 100 * whole)


def uncertain(monkeypatch, where):
    """Make the quantile uncertain by a fifth at poses whose first joint value fulfils `where`."""

    def unsure(arm, poses, **more):
        found = analytic(arm, poses, **more)
        off = where(poses.q[:, 0])[:, None]
        return replace(
            found,
            quantiles_uncertainty=np.where(off, 0.2 * found.quantiles, found.quantiles_uncertainty),
        )

    monkeypatch.setattr("lostmotion.maps.cell_statistics.analytic", unsure)


def slid(**asked):
    """Map a prismatic arm with backlash and an uncertain zero."""
    encoder, play = {"zero": 1e-4}, {"ratio": 1, "backlash": "50 µm"}
    slide = {
        "name": "A",
        "type": "prismatic",
        "axis": "x",
        "limits": (0.0, 0.5),
        "encoder": encoder,
        "gearbox": play,
        "link": {"length": 0.1},
    }
    return lostmotion.map(
        Arm(name="slide", joints=[slide]), cell=0.05, poses=512, per_cell=2, **asked
    )


def test_uncertain_figures_have_wide_intervals_and_are_counted(monkeypatch):
    """Where no figure is valid, intervals contain the uncertainty, a share within a target may be
    none or all, and the page states it.
    """
    target = 1.02 * float(np.nanmax(slid().selected))
    true = slid(target=target).sheet
    assert "100 % (" in true.verdict
    assert not any("without a valid figure" in note for note in true.notes)
    uncertain(monkeypatch, lambda q: q >= -1)
    mapped = slid(target=target)
    found, sheet = mapped, mapped.sheet
    assert found.uncertain[np.isfinite(found.selected)].all()
    assert any(
        f"{int(found.uncertain.sum())} cells without a valid figure" in note for note in sheet.notes
    )
    share = row_at(sheet.sections, "within", key_of(f"within {length(target, stated=True)}")).cells[
        0
    ]
    assert share.low < 0.01
    assert share.high == 1
    row = next(section for section in sheet.sections if section.key == "map").rows[0]
    assert row.cells[0].high - row.cells[0].low > 0.35 * row.cells[0].value
    assert row_at(sheet.sections, "reach", "poses_with_valid_figures").cells[0].as_shown == 0


def test_places_where_figures_are_valid_have_narrow_intervals(monkeypatch):
    """With half of the cells uncertain, only figures based on them have a wide interval."""
    target = 0.95 * float(np.nanmin(slid().selected))
    uncertain(monkeypatch, lambda q: q > 0.25)
    sheet = slid(target=target).sheet
    share = row_at(sheet.sections, "within", key_of(f"within {length(target, stated=True)}")).cells[
        0
    ]
    assert share.value < 0.01
    assert 0.4 < share.high < 0.75


@pytest.mark.usual_counts
def test_mapping_works_out_of_the_box(tmp_path):
    """`lostmotion map` prints and writes; the same input gives the same bytes on other threads; an
    existing folder is not overwritten.
    """
    # in a plane, with few plots; cells and configurations are more than those of the Z-arm
    words = (
        EXAMPLES / "planar-2r.toml",
        *QUICK,
        "--target",
        "0.2 mm",
        "--box",
        "200 x 0 x 100 mm",
        "--by",
        "best",
        "--at",
        "400 mm, 0 mm, 100 mm",
    )
    first = ran(*words, "--threads", 1, "--full", cwd=tmp_path)
    assert first.returncode == 0, first.stderr
    assert "planar-2r-map/report.html\n" in first.stdout
    assert "Best placement for a task of 200 x 0 x 100 mm" in first.stdout
    second = carried_out_by_process("map", *words, "--threads", 3, "--out", "again", cwd=tmp_path)
    assert second.returncode == 0
    for name in ("result.json", "arrays.nc", "report.html"):
        assert (tmp_path / "again" / name).read_bytes() == (
            tmp_path / "planar-2r-map" / name
        ).read_bytes()
    third = ran(*words, cwd=tmp_path)
    assert third.returncode == 2
    assert "exists" in third.stderr


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--box", "300 mm x 200 mm"), "three lengths"),
        (("--box", "3 kg x 1 m x 1 m"), "--box"),
        (("--cell", "50"), "--cell"),
        (("--target", "-1 mm"), "--target"),
        (("--at", "1 m, 2 m"), "three lengths"),
    ],
)
def test_what_cannot_be_is_refused(tmp_path, words, said):
    """Invalid options give one message and exit code 2, and nothing is written."""
    done = ran(Z_ARM, *words, cwd=tmp_path)
    assert done.returncode == 2
    assert said in done.stderr
    assert not list(tmp_path.iterdir())


def test_a_box_that_fits_nowhere_is_reported():
    """A box larger than the workspace has no placement, and the largest of its proportions is
    reported.
    """
    mapped = lostmotion.map(lostmotion.read(Z_ARM), cell=0.4, poses=512, per_cell=2, box=(3, 3, 3))
    said = mapped.result()
    assert said["places"] == []
    assert 0 < said["largest_box_m"][0] < 3
    assert "No placement of 3000 x 3000 x 3000 mm is within reach" in mapped.sheet.verdict
    assert (
        next(section for section in mapped.sheet.sections if section.key == "places").note
        in mapped.sheet.verdict
    )


def test_a_point_beyond_the_reach_is_reported(mapped):
    """Slices through an unreachable point show the nearest cells, with a note; a reachable point
    needs none.
    """
    grid, counts = mapped.reached.grid, mapped.reached.counts
    missed = grid.centres(np.flatnonzero(counts.ravel() == 0)[:1])[0]
    words = [
        replace(mapped, at=np.array(at)).sheet.notes
        for at in ((50.0, 0.0, 0.3), missed, mapped.best_place)
    ]
    assert any("x 50000, y 0, z 300 mm is outside the map" in note for note in words[0])
    assert any("no pose found in the cell of the point x " in note for note in words[1])
    assert words[2] == mapped.sheet.notes


@pytest.mark.usefixtures("unpainted")
def test_no_place_for_a_box_is_an_answer_of_its_own(tmp_path):
    """Without a placement the folder is written, the verdict goes to standard error, and the exit
    code is 1.
    """
    done = ran(
        EXAMPLES / "planar-2r.toml",
        "--cell",
        "300 mm",
        "--poses",
        "64",
        "--per-cell",
        "2",
        "--box",
        "50 x 0 x 50 m",
        cwd=tmp_path,
    )
    assert done.returncode == 1
    assert "No placement of 50000 x 0 x 50000 mm is within reach" in done.stderr
    assert (tmp_path / "planar-2r-map" / "report.html").is_file()


def test_python_refuses_unknown_wishes():
    """Unknown names and invalid points are refused."""
    arm = lostmotion.read(Z_ARM)
    with pytest.raises(TypeError, match="bx"):
        lostmotion.map(arm, bx=3)
    with pytest.raises(lostmotion.InputError, match="at"):
        lostmotion.map(arm, at=(1, 2))
    with pytest.raises(lostmotion.InputError, match="approach"):
        lostmotion.map(arm, approach="sideways")
    with pytest.raises(lostmotion.InputError, match="threads"):
        lostmotion.map(arm, threads=-1)
