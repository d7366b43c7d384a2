"""A grid of designs, from the table in a file to the report."""

from __future__ import annotations

import json
import math
import re
import subprocess
import sys
from types import SimpleNamespace

import numpy as np
import pytest

import lostmotion
from lostmotion.analyses.accuracy.page.budget import REMEDIES
from lostmotion.analyses.sweep.plots import over_two, sweep_plots
from lostmotion.error_model.intervals import Estimate
from lostmotion.io.sweep import Axis, changes, designs
from lostmotion.io.sweep_designs import read_design, read_sweep
from lostmotion.runs.design_names import design_name, short_keys, short_labels
from lostmotion.units import read_quantity
from tests.command import carried_out as ran
from tests.runs.conftest import ARM, COUNTS, SWEEP, tree

SMALL = {"poses": 64, "robots": 20, "visits": 3, "block": 8}
# The command line, to which Ctrl-C comes while it stores its third block: sent from outside, the
# signal may come when all is done.
INTERRUPTED = """
import os, signal
from lostmotion.cli import main
from lostmotion.runs.store import Store
written, write = [], Store.write
def interrupted(*given):
    write(*given)
    written.append(given)
    if len(written) == 3:
        os.kill(os.getpid(), signal.SIGINT)
Store.write = interrupted
main()
"""


def asked(tmp_path, table, arm=ARM):
    """Read a table [sweep] that stands in a file of its own, for a small arm."""
    path, by = tmp_path / "tiny.toml", tmp_path / "by.toml"
    path.write_text(arm, encoding="utf-8")
    by.write_text(table, encoding="utf-8")
    return read_sweep(path, None, by)[1]


@pytest.fixture(scope="module")
def swept(tmp_path_factory):
    """Carry out a sweep over two keys."""
    folder = tmp_path_factory.mktemp("swept")
    path = folder / "tiny.toml"
    path.write_text(ARM + SWEEP, encoding="utf-8")
    return lostmotion.sweep(path, **SMALL, out=folder / "run", workers=2)


def test_an_arm_without_a_worst_case_is_swept(tmp_path):
    """Errors without limits make the worst case infinite; every other figure is kept, and grows
    with the angle from design to design.
    """
    path = tmp_path / "tiny.toml"
    lumped = 'lumped = { angle = "9 arcmin", law = "normal without limits" }\n'
    path.write_text(
        f'{ARM}{lumped}[sweep]\n"joints.B.lumped.angle" = ["9 arcmin", "18 arcmin"]\n',
        encoding="utf-8",
    )
    run = lostmotion.sweep(path, **SMALL, out=tmp_path / "run")
    one, two = run.arrays()["rms"].sel(end="value").values
    assert 1.5 * one < two < 2 * one


def test_designs_are_all_combinations(tmp_path):
    """Lists and ranges, keys as one text, with dots or as tables: every combination is a design,
    the last key changing fastest.
    """
    axes = asked(
        tmp_path,
        """
[sweep]
"gearboxes.small.backlash" = ["0.5 arcmin", "1 arcmin ± 0.3 arcmin"]
payload.mass = { from = "1 kg", to = "3 kg", steps = 3 }
[sweep.joints.A.gearbox]
ratio = { from = 10, to = 1000, steps = 3, spacing = "log" }
""",
    )
    assert [axis.key for axis in axes] == [
        "gearboxes.small.backlash",
        "payload.mass",
        "joints.A.gearbox.ratio",
    ]
    assert axes[1].values == ("1 kg", "2 kg", "3 kg")
    assert axes[2].values == (10, 100, 1000)
    assert axes[1].quantities == ((1.0, 2.0, 3.0), "kg")
    assert axes[0].quantities is None
    assert designs(axes) == 18
    assert changes(axes, 0)["joints.A.gearbox.ratio"] == 10
    assert changes(axes, 4) == {
        "gearboxes.small.backlash": "0.5 arcmin",
        "payload.mass": "2 kg",
        "joints.A.gearbox.ratio": 100,
    }
    assert short_keys(axes) == ["backlash", "mass", "ratio"]
    assert short_keys((Axis(key="a.x.mass", values=(1,)), Axis(key="b.y.mass", values=(1,)))) == [
        "x mass",
        "y mass",
    ]


def test_a_design_is_the_file_with_other_values(tmp_path):
    """A design reads as the arm whose file says so itself; a joint's own key leaves the joints that
    share the part alone.
    """
    path, other = tmp_path / "tiny.toml", tmp_path / "other.toml"
    path.write_text(ARM, encoding="utf-8")
    other.write_text(
        ARM.replace("2 kg", "3 kg").replace("1 arcmin ± 0.3 arcmin", "2 arcmin"), encoding="utf-8"
    )
    stated = {"payload.mass": "3 kg", "gearboxes.small.backlash": "2 arcmin"}
    assert (
        read_design(path, None, stated).model_dump_json()
        == lostmotion.read(other).model_dump_json()
    )
    mine = read_design(
        path, None, {"joints.A.gearbox.backlash": "2 arcmin", "joints.B.limits.0": "-10 deg"}
    )
    arcmin = math.pi / 10800
    assert [round(joint.gearbox.backlash.nominal / arcmin, 9) for joint in mine.joints] == [2, 1]
    assert mine.joints[1].limits == pytest.approx((math.radians(-10), math.radians(60)))


def test_a_urdf_is_swept_by_the_keys_of_its_sidecar(tmp_path):
    """Of a URDF the sidecar's keys can be swept, and the run holds both files."""
    from pathlib import Path

    examples = Path(__file__).parents[2] / "examples"
    by = tmp_path / "by.toml"
    by.write_text('[sweep]\n"payload.mass" = ["1 kg", "2 kg"]\n', encoding="utf-8")
    found = lostmotion.sweep(
        examples / "ur5e.urdf", by, **{**SMALL, "robots": 4}, out=tmp_path / "run", workers=1
    )
    assert set(found.store.order.files) == {"ur5e.urdf", "ur5e.toml"}
    assert found.outcomes[1].figures["mean"].value > found.outcomes[0].figures["mean"].value


def test_every_mistake_is_reported_at_once(tmp_path):
    """Keys that lead nowhere, unknown keys, other units and wrong ranges come in one message, with
    what was probably meant.
    """
    with pytest.raises(lostmotion.InputError) as caught:
        asked(
            tmp_path,
            """
elsewhere = 1
[sweep]
"joints.AA.gearbox.backlash" = ["1 arcmin"]
"gearboxes.smal.ratio" = [3]
"gearboxes.small.backlsh" = ["1 arcmin", "2 arcmin"]
"gearboxes.small.stiffness" = ["1 N m", "2 N m/arcmin"]
"payload.mass" = { from = "1 kg", to = "2 g", steps = 1, step = 3 }
"tool.mass" = "1 kg"
"joints.B.limits" = [["10 deg", "-10 deg"]]
""",
        )
    keys = {problem.key: problem for problem in caught.value.problems}
    assert set(keys) == {
        "elsewhere",
        'sweep."joints.AA.gearbox.backlash"',
        'sweep."gearboxes.smal.ratio"',
        'sweep."gearboxes.small.backlsh"',
        'sweep."gearboxes.small.stiffness"[0]',
        'sweep."payload.mass".step',
        'sweep."payload.mass".steps',
        'sweep."payload.mass"',
        'sweep."tool.mass"',
        'sweep."joints.B.limits"[0]',
    }
    assert keys['sweep."gearboxes.small.backlsh"'].nearest == "backlash"
    assert keys['sweep."gearboxes.smal.ratio"'].nearest == "small"
    assert all(problem.file.rpartition(":")[0].endswith("by.toml") for problem in keys.values())
    assert not (tmp_path / "tiny-sweep").exists()


@pytest.mark.parametrize(
    "table",
    [
        "sweep = 3",
        "[sweep]",
        "[other]",
        '[sweep]\n"" = [1]',
        '[sweep]\n"payload..mass" = ["1 kg"]',
        '[sweep]\n"payload.mass" = []',
        '[sweep]\n"payload.mass" = [2020-01-01]',
        '[sweep]\n"payload.mass" = { from = "-1 kg", to = "1 kg", steps = 3, spacing = "log" }',
        '[sweep]\n"payload.mass" = { from = "1 kg", to = "2 kg", steps = 1001 }',
        f'[sweep]\n"gearboxes.small.ratio" = {{ from = 1, to = {"9" * 400}, steps = 3 }}',
        '[sweep]\n"payload.mass" = ["1 kg"]\npayload.mass = ["2 kg"]',
        '[sweep]\n"name.x" = ["1 kg"]',
        "[sweep]\n"
        + "\n".join(
            f'"gearboxes.small.k{k}" = {{ from = 1, to = 2, steps = 1000 }}' for k in range(5)
        ),
        "[sweep]\n" + "\n".join(f'"k{k}" = [1]' for k in range(50)),
        '[sweep]\n"' + "a." * 150 + 'b" = [1]',
    ],
)
def test_tables_that_cannot_be_are_refused(tmp_path, table):
    """Whatever stands under [sweep], what cannot be swept is a mistake with a key and an example,
    never a traceback.
    """
    with pytest.raises(lostmotion.InputError) as caught:
        asked(tmp_path, table)
    assert all(problem.expected for problem in caught.value.problems)
    # An angle is no example for a mass: an example of a range stands beside a key that takes it.
    assert all(
        '"gearboxes.' in problem.example
        for problem in caught.value.problems
        if "arcmin" in problem.example
    )


def test_combinations_that_do_not_fit_are_reported(tmp_path):
    """Values that each pass by themselves and not together are refused before anything runs, with
    the combination.
    """
    with pytest.raises(
        lostmotion.InputError, match=r"joints.B.limits.0 = '20 deg', joints.B.limits.1 = '15 deg'"
    ):
        asked(
            tmp_path,
            (
                '[sweep]\n"joints.B.limits.0" = ["-1 deg", "20 deg"]\n"joints.B.limits.1" = ["15 '
                'deg", "30 deg"]'
            ),
        )


def test_a_study_leaves_the_sweep_aside_with_a_word(arm):
    """An arm file with [sweep] is studied as it stands, and the study says so."""
    assert any("`lostmotion sweep`" in note for note in lostmotion.read(arm).notes)
    assert not any("sweep" in note for note in read_design(arm, None, {}).notes)


def test_outcomes_are_those_of_the_study_of_each_design(swept):
    """Each design's figures are those that the ordinary study finds for its arm."""
    for outcome in (swept.outcomes[0], swept.outcomes[3]):
        study = lostmotion.study(swept.store.order.read(outcome.design), 64, 20, 3, seed=1)
        table = study.sampled
        assert outcome.figures["mean"].value == pytest.approx(
            table.robot_means[:, :, 0].mean(), rel=1e-12
        )
        rows = {
            row.label: row
            for section in study.sheet.sections
            if section.key in {"error", "iso9283"}
            for row in section.rows
        }
        of_study = {
            name: rows[name].cells[0]
            for name in (
                "mean",
                "95th percentile",
                "AP, 95th percentile of robots",
                "RP, any approach, 95th percentile of robots",
            )
        }
        found = (outcome.figures["mean"], outcome.p95, outcome.ap, outcome.rp)
        for figure, estimate in zip(of_study.values(), found, strict=True):
            assert estimate.value == pytest.approx(figure.value, rel=1e-9)
            assert estimate.low == pytest.approx(figure.low, rel=1e-6)


def test_more_play_is_less_repeatable(swept):
    """Twice the play doubles RP at either payload, and the drawn comparison with the first design
    is more precise than the two intervals.
    """
    rp = swept.arrays()["rp_any_mean"].sel(end="value")
    assert rp.dims == ("gearboxes.small.backlash", "payload.mass")
    ratio = (rp[1] / rp[0]).to_numpy()
    assert ((ratio > 1.8) & (ratio < 2.4)).all()
    both, first = swept.outcomes[2], swept.outcomes[0]
    apart = both.lower.high - both.lower.low
    assert both.lower.high < 0
    assert apart < math.hypot(
        both.p95.high - both.p95.low,
        first.p95.high - first.p95.low,
    )


def test_arrays_have_one_axis_for_each_key(swept):
    """Quantities become numbers in the unit they are stated in, anything else stays text."""
    found = swept.arrays()
    assert dict(found.sizes) == {"gearboxes.small.backlash": 2, "payload.mass": 2, "end": 3}
    assert found["payload.mass"].to_numpy().tolist() == [1.0, 3.0]
    assert found["payload.mass"].attrs["units"] == "kg"
    assert found["gearboxes.small.backlash"].to_numpy().tolist() == [
        "0.5 arcmin",
        "1 arcmin ± 0.3 arcmin",
    ]
    assert found["p95"].sel(end="value").to_numpy()[1, 0] == swept.outcomes[2].p95.value
    assert np.isnan(found["p95_lower"].to_numpy()[0, 0]).all()


def test_the_report_says_what_was_found(swept):
    """The page and result.json hold every design, and the plots belong to sections of the page."""
    folder = swept.report()
    said = json.loads((folder / "result.json").read_text(encoding="utf-8"))
    assert [each["stated"]["payload.mass"] for each in said["designs"]] == [
        "1 kg",
        "3 kg",
        "1 kg",
        "3 kg",
    ]
    assert said["designs"][3]["p95"][0] == swept.outcomes[3].p95.value
    assert said["axes"][0]["values"] == ["0.5 arcmin", "1 arcmin ± 0.3 arcmin"]
    sheet = swept.sheet
    assert {plot.section for plot in sweep_plots(swept.store.order, swept.outcomes)} <= {
        section.key for section in sheet.sections
    }
    best = min(swept.outcomes, key=lambda each: each.p95.value)
    assert best.stated["gearboxes.small.backlash"] in sheet.verdict
    assert "Of 4 designs" in (folder / "report.html").read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("table", "shape"),
    [
        ("", ()),
        ('[sweep]\n"payload.mass" = ["3 kg", "1 kg"]', (2,)),
        (
            '[sweep]\n"payload.mass" = { from = "1 kg", to = "4 kg", steps = 3, spacing = "log" }',
            (3,),
        ),
        ('[sweep]\n"gearboxes.small.backlash" = ["1 arcmin", "1 arcmin ± 10 %"]', (2,)),
        (
            (
                '[sweep]\n"payload.mass" = ["1 kg", "2 kg"]\n"gearboxes.small.ratio" = [40, 50]\n'
                '"joints.A.gearbox.backlash" = ["1 arcmin", "2 arcmin"]'
            ),
            (2, 2, 2),
        ),
    ],
    ids=["none", "one key", "a range", "words", "three keys"],
)
@pytest.mark.usefixtures("unpainted")
def test_any_number_of_keys_is_shown(tmp_path, table, shape):
    """No key, one, or three: there is a sheet, a plot for it, and arrays of that shape; visits
    without a second give no AP and RP.
    """
    path = tmp_path / "tiny.toml"
    path.write_text(ARM + table, encoding="utf-8")
    found = lostmotion.sweep(path, poses=8, robots=4, visits=1, out=tmp_path / "run", workers=1)
    assert len(found.outcomes) == math.prod(shape)
    assert found.arrays()["largest"].shape == shape
    plots = sweep_plots(found.store.order, found.outcomes)
    assert plots[0].section == "designs"
    assert found.outcomes[0].rp is None
    json.dumps(found.result(), allow_nan=False)
    found.report()


def test_ranges_are_stated_in_units_that_read_back(tmp_path):
    """What a range lays out reads as evenly spaced quantities."""
    (axis,) = asked(
        tmp_path,
        (
            '[sweep]\n"gearboxes.small.backlash" = { from = "0.1 arcmin", to = "0.7 arcmin", '
            "steps = 7 }"
        ),
    )
    values = [read_quantity(value, "rad").nominal for value in axis.values]
    np.testing.assert_allclose(np.diff(values), math.radians(0.1 / 60), rtol=1e-9)


@pytest.mark.slow
def test_the_command_goes_on_where_it_was_stopped(arm, tmp_path):
    """Ctrl-C leaves a run that the same command goes on with; it says so, and the report is that of
    a run left alone.
    """
    words = [
        "sweep",
        arm.name,
        *COUNTS[:-1],
        "1",
        "--poses",
        "32",
        "--workers",
        "2",
        "--out",
        "stopped",
    ]
    child = subprocess.run(
        [sys.executable, "-c", INTERRUPTED, *words],
        cwd=tmp_path,
        stderr=subprocess.PIPE,
        text=True,
        timeout=120,
        check=False,
    )
    assert child.returncode == 130
    assert (
        "the blocks that are done are stored in 'stopped'; the same command continues"
        in child.stderr
    )
    assert "Traceback" not in child.stderr
    done = len(list((tmp_path / "stopped" / "ledger").glob("*.json")))
    assert 0 < done < 4 * 32
    found = lostmotion.sweep(
        arm, poses=32, robots=20, visits=3, block=1, out=tmp_path / "stopped", workers=1
    )
    assert len(tree(tmp_path / "stopped" / "ledger")) == 4 * 32
    assert len(found.outcomes) == 4


def test_mistakes_end_in_one_message(tmp_path):
    """A wrong file, count or address is refused with a word, with exit code 2 on the command line,
    and nothing is written.
    """
    path = tmp_path / "tiny.toml"
    path.write_text(ARM, encoding="utf-8")
    for file, options, said in (
        ("none.toml", {}, "no such file"),
        ("tiny.toml", {"dask": "local:none"}, "local:N"),
        ("tiny.toml", {"seed": -1}, "seed"),
        ("tiny.toml", {"workers": 0}, "workers"),
        ("tiny.toml", {"workers": 10**9}, "from 1 to 1024"),
    ):
        with pytest.raises(lostmotion.InputError, match=said):
            lostmotion.sweep(tmp_path / file, out=tmp_path / "run", **options)
    found = ran("sweep", "tiny.toml", "--block", "99999", "--out", "run", cwd=tmp_path)
    assert found.returncode == 2
    assert "from 1 to 8000 poses with 1000 robots" in found.stderr
    assert "Traceback" not in found.stderr
    assert not (tmp_path / "run").exists()


def test_an_arm_in_memory_is_not_swept(tmp_path):
    """A sweep changes keys of a file: text and Path are taken, an Arm is refused with the reason,
    and so is what is nothing of these.
    """
    path = tmp_path / "tiny.toml"
    path.write_text(ARM, encoding="utf-8")
    with pytest.raises(
        lostmotion.InputError,
        match="a sweep changes their keys, which an arm in memory no longer has",
    ) as caught:
        lostmotion.sweep(lostmotion.read(path), out=tmp_path / "run")
    assert caught.value.problems[0].found == "'an Arm, tiny'"
    with pytest.raises(lostmotion.InputError, match="path"):
        lostmotion.sweep(None, out=tmp_path / "run")
    assert not (tmp_path / "run").exists()
    assert lostmotion.sweep(str(path), poses=8, robots=4, visits=2, out=tmp_path / "run").outcomes


def test_designs_have_short_distinct_names(tmp_path):
    """Names omit what is the same in all designs and what is long; result.json has every key and
    value in full.
    """
    path = tmp_path / "tiny.toml"
    long = [f"{{ length = '{length} mm ± 50 µm', stiffness = '1 N' }}" for length in (300, 400)]
    axes = (
        Axis(key="gearboxes.small.backlash", values=("1 arcmin",)),
        Axis(key="joints.A.link.length", values=("0.3 m", "0.4 m")),
        Axis(key="joints.B.link.length", values=("0.2 m", "0.3 m", "0.2 m")),
        Axis(key="note", values=tuple(long)),
        Axis(key="x.a_b", values=(1, True)),
        Axis(key="x.a b", values=(1, 2)),
    )
    order = SimpleNamespace(axes=axes, stated=lambda design: changes(axes, design))
    names = [design_name(order.axes, design) for design in range(designs(axes))]
    assert len(set(names)) == designs(axes) == 48
    order.axes = axes = axes[:3]
    assert design_name(order.axes, 1) == "A length 0.3 m, B length 0.3 m"
    assert short_keys([Axis(key=key, values=(1,)) for key in ("a.b.x", "b.a.x", "x", "c.x")]) == [
        "b x",
        "a x",
        "x",
        "c x",
    ]
    assert short_labels(Axis(key="k", values=("1 mm ± 5 µm", "2 mm ± 5 µm"))) == ["1 mm", "2 mm"]
    assert short_labels(Axis(key="k", values=("1 mm ± 5 µm", "1 mm"))) == ["1 mm ± 5 µm", "1 mm"]
    assert short_labels(Axis(key="k", values=("1 mm ± 5 µm", "2 mm ± 9 µm"))) == [
        "1 mm ± 5 µm",
        "2 mm ± 9 µm",
    ]
    path.write_text(
        ARM + '[sweep]\n"payload.mass" = ["1 kg", "3 kg"]\n"gearboxes.small.ratio" = [50]',
        encoding="utf-8",
    )
    found = lostmotion.sweep(path, poses=8, robots=4, visits=2, out=tmp_path / "run")
    table = next(section for section in found.sheet.sections if section.key == "designs")
    assert [row.label for row in table.rows] == ["mass 1 kg", "mass 3 kg"]
    assert "gearboxes.small.ratio = 50 in all" in table.note
    plots = sweep_plots(found.store.order, found.outcomes)
    assert [plot.key for plot in plots] == ["designs", "iso9283", "spread"]
    assert plots[0].figure.axes[0].get_xlabel() == "mass [kg]"
    told = found.result()["designs"]
    assert [each["name"] for each in told] == ["mass 1 kg", "mass 3 kg"]
    assert told[1]["stated"] == {"payload.mass": "3 kg", "gearboxes.small.ratio": 50}
    assert (
        told[1]["standard_deviation"][0]
        == found.outcomes[1].figures["standard_deviation"].value
        == found.arrays()["standard_deviation"].values[1, 0, 0]
    )


def test_designs_are_compared_at_the_users_own_poses(tmp_path):
    """Poses from a CSV are visited by every design as the study visits them, kept with the run and
    replayed; limits that exclude one are refused.
    """
    path, poses = tmp_path / "tiny.toml", tmp_path / "poses.csv"
    path.write_text(ARM + '[sweep]\n"payload.mass" = ["1 kg", "3 kg"]', encoding="utf-8")
    poses.write_text("B [deg],A [deg]\n10,20\n-30,5\n50,-80\n", encoding="utf-8")
    found = lostmotion.sweep(
        path, poses=poses, robots=20, visits=3, block=2, out=tmp_path / "run", workers=2
    )
    q = np.radians([[20, 10], [5, -30], [-80, 50]])
    for outcome in found.outcomes:
        study = lostmotion.study(found.store.order.read(outcome.design), q, 20, 3, seed=1)
        assert outcome.figures["mean"].value == pytest.approx(
            study.sampled.robot_means[:, :, 0].mean(), rel=1e-12
        )
    poses.unlink()
    each = lostmotion.replay(tmp_path / "run")[0]
    assert each.kernel == each.found.error
    np.testing.assert_allclose(each.found.q, q[each.found.pose])
    poses.write_text("B [deg],A [deg]\n55,20\n", encoding="utf-8")
    path.write_text(ARM + '[sweep]\n"joints.B.limits.1" = ["60 deg", "40 deg"]', encoding="utf-8")
    with pytest.raises(lostmotion.InputError, match="line 2"):
        lostmotion.sweep(path, poses=poses, out=tmp_path / "other")
    assert not (tmp_path / "other").exists()


def test_labels_are_short_and_distinct():
    """Quantities of a range are labelled with four digits; those that four digits would not
    separate, and short ones, as they are stated.
    """
    assert Axis(key="k", values=("1.33333333333 kg", "2 kg")).labels == ("1.333 kg", "2 kg")
    assert Axis(key="k", values=("1.00000000001 kg", "1 kg")).labels == ("1.00000000001 kg", "1 kg")
    assert Axis(key="k", values=("12345.6 N", "1 N")).labels == ("12345.6 N", "1 N")
    assert Axis(key="k", values=("1 mm ± 5 µm", True, [1, 2])).labels == (
        "1 mm ± 5 µm",
        "True",
        "[1, 2]",
    )


def test_a_file_that_no_store_could_hold_is_not_read_whole(tmp_path):
    """Whatever an arm file names beside itself comes along: at most 20 MB of it are read, and more
    is a mistake.
    """
    (tmp_path / "arm.toml").write_text(
        (
            'name = "huge.csv"\n[[joints]]\nname = "A"\ntype = "revolute"\nlimits = ["-1 rad", "1 '
            'rad"]\nlink = { length = "0.3 m ± 1 mm" }\n'
        ),
        encoding="utf-8",
    )
    with (tmp_path / "huge.csv").open("wb") as huge:
        huge.truncate(21_000_000)
    with pytest.raises(lostmotion.InputError, match="more than 20 MB"):
        lostmotion.sweep(tmp_path / "arm.toml", poses=8, robots=2, visits=1, out=tmp_path / "run")
    assert not (tmp_path / "run").exists()


def test_the_sheet_names_the_largest_contributors_and_remedies(swept):
    """A column for each of the largest contributors, shares that add to 100 %, and the remedies
    named in the sheet of one arm.
    """
    sections = {section.key: section for section in swept.sheet.sections}
    parts = sections["parts"]
    assert parts.columns[-1] == "all others"
    for row, outcome in zip(parts.rows, swept.outcomes, strict=True):
        shares = {cost.part.removeprefix("joints."): cost.share for cost in outcome.costs}
        assert [figure.value for figure in row.cells[:-1]] == [
            shares[name] for name in parts.columns[:-1]
        ]
        assert sum(figure.value for figure in row.cells) == pytest.approx(1)
    note = sections["levels"].note
    assert all(remedy in note for remedy in REMEDIES)
    assert "constant" in note


def test_a_map_marks_what_is_not_distinguishable_from_the_smallest(swept):
    """Overlapping intervals are marked and explained; separate intervals are not."""
    order = swept.store.order
    near = [
        Estimate(1e-4 * value, 1e-4 * (value - 0.5), 1e-4 * (value + 0.5))
        for value in (1.0, 1.1, 1.2, 1.3)
    ]
    (on,) = over_two(order, near, "error").axes
    assert all(each.get_text().startswith("≈ ") for each in on.texts)
    assert "may be chance" in on.get_xlabel()
    apart = [
        *near[:2],
        *(Estimate(each.value + 1e-3, each.low + 1e-3, each.high + 1e-3) for each in near[2:]),
    ]
    (on,) = over_two(order, apart, "error").axes
    assert [each.get_text().startswith("≈ ") for each in on.texts] == [True, True, False, False]
    assert "may be as small" in on.get_xlabel()
    alone = [
        near[0],
        *(Estimate(each.value + 1e-3, each.low + 1e-3, each.high + 1e-3) for each in near[1:]),
    ]
    (on,) = over_two(order, alone, "error").axes
    assert not any("≈" in each.get_text() for each in on.texts)
    assert "≈" not in on.get_xlabel()


def test_classes_of_a_map_span_the_ends_of_the_intervals(swept):
    """Differences within the intervals are faint: the limits of the classes lie between the lowest
    and the highest end.
    """
    near = [
        Estimate(1e-4 * value, 1e-4 * (value - 0.5), 1e-4 * (value + 0.5))
        for value in (1.0, 1.1, 1.2, 1.3)
    ]
    (legend,) = over_two(swept.store.order, near, "error").legends
    limits = [
        float(number)
        for each in legend.get_texts()
        for number in re.findall(r"[\d.]+", each.get_text())
    ]
    assert min(limits) <= 0.05 + 0.02
    assert max(limits) >= 0.18 - 0.02
