"""Soft arms that fall at some of the sampled poses: the share is in the headline, and figures are
of the poses where they stand.
"""

from __future__ import annotations

import functools

import numpy as np
import pytest
from scipy.optimize import brentq

import lostmotion
from lostmotion.mechanism.standing import falls_at
from tests.arms import JOINT

MASS, LENGTH, GRAVITY = 0.5, 0.3, 9.80665


def upright(ratio, reach="60 deg", **more):
    """Return a pendulum that turns from upright to either side, on a spring of this share of the
    stiffness with which it stands upright.
    """
    joint = {
        "type": "revolute",
        "axis": "-y",
        "name": "A",
        "limits": (f"-{reach}", reach),
        "servo": {"stiffness": ratio * MASS * GRAVITY * LENGTH},
        "link": {"length": LENGTH, "direction": "z", "rigid": True, "mass": "0 kg"},
        **more,
    }
    return lostmotion.Arm.model_validate(
        {"name": "pendulum", "joints": [joint], "payload": {"mass": MASS}}
    )


def stands(ratio, command):
    """Return the angle from upright at which spring and weight are in equilibrium on the side of
    the command, by its own root: a = c + sin(a) / ratio.
    """
    return brentq(lambda a: a - command - np.sin(a) / ratio, command, np.pi)


def test_a_pendulum_falls_upright_alone():
    """On a spring of 0.9 m g l it falls where it is commanded upright, and droops elsewhere; on
    one of 1.1 m g l it stands everywhere.
    """
    law = {"poses": 9, "pose_law": "grid", "robots": 20, "visits": 2}
    q = np.linspace(-np.pi / 3, np.pi / 3, 9)[:, None]
    np.testing.assert_array_equal(falls_at(upright(0.9), q) >= 0, np.abs(q[:, 0]) < 1e-9)
    found = lostmotion.study(upright(0.9), **law)
    assert len(found.poses) == 8
    moved = [2 * LENGTH * np.sin((stands(0.9, c) - c) / 2) for c in np.abs(found.poses.q[:, 0])]
    np.testing.assert_allclose(found.sampled.per_pose[:, 0], moved, rtol=1e-9)
    whole = lostmotion.study(upright(1.1), **law)
    assert len(whole.poses) == 9
    assert "falls" not in whole.sheet.verdict


@functools.cache  # where an arm stands is kept with it
def two(stiffness):
    """Return two links in the vertical plane on equal springs."""
    joints = [
        {
            **JOINT,
            "name": name,
            "axis": "-y",
            "limits": ("-170 deg", "170 deg"),
            "servo": {"stiffness": f"{stiffness} N m/rad"},
            "link": {"length": LENGTH, "rigid": True, "mass": "0.5 kg"},
        }
        for name in "AB"
    ]
    return lostmotion.Arm.model_validate(
        {"name": "two", "joints": joints, "payload": {"mass": MASS}}
    )


def begins_with_its_falls(sheet):
    """Return whether a headline begins with the poses at which joint A cannot hold."""
    found = sheet.verdict
    return found.startswith("The arm falls at ") and "the springs at joint A cannot hold" in found


def test_statics_states_where_it_falls():
    """The compliance is that of the poses where the arm stands, as many of each set, and the
    headline begins with the share of the others and the joint.
    """
    arm = two(0.5)
    falling = falls_at(arm, lostmotion.sample_poses(arm, 64).q) >= 0
    assert 0 < falling.sum() < 8
    found = lostmotion.statics(arm, poses=64)
    assert len(found.poses) == 8 * (~falling).reshape(8, -1).sum(axis=1).min()
    assert not (falls_at(arm, found.poses.q) >= 0).any()
    assert begins_with_its_falls(found.sheet)


@pytest.mark.slow
@pytest.mark.few_counts
@pytest.mark.parametrize("more", [{"method": "analytic"}, {"robots": 8, "visits": 2}])
def test_a_study_states_where_it_falls(more):
    """With and without sampling, over the poses where the arm stands."""
    found = lostmotion.study(two(0.5), 16, **more)
    assert len(found.poses) < 16
    assert begins_with_its_falls(found.sheet)


@pytest.mark.slow
@pytest.mark.few_counts
def test_a_comparison_and_a_target_state_where_an_arm_falls():
    """The headline begins with the poses of the arm that falls, by its name among several."""
    counts = {"poses": 16, "robots": 20, "visits": 2}
    found = lostmotion.target(two(0.5), error="1 m", **counts).sheet
    assert begins_with_its_falls(found)
    found = lostmotion.compare(two(50.0), two(0.5), **counts).sheet
    assert found.verdict.startswith("two (2) falls at ")


def test_too_many_falls_are_refused():
    """An arm that falls at more than half of its poses has no figure; given poses are not thinned
    out.
    """
    arm = upright(0.9, "1e-9 deg")
    with pytest.raises(lostmotion.InputError, match=r"no stable equilibrium at .* joint A"):
        lostmotion.study(arm, 8, robots=4, visits=2)
    with pytest.raises(lostmotion.InputError, match="no stable equilibrium at 1 of 2 poses"):
        lostmotion.study(upright(0.9), np.array([[0.0], [0.5]]), robots=4, visits=2)


def swept(ratios, folder, **more):
    """Return a sweep of the pendulum over its servo's stiffness, as shares of that with which it
    stands upright.
    """
    stated = {
        "name": "pendulum",
        "joints": [
            {
                "type": "revolute",
                "axis": "-y",
                "name": "A",
                "limits": ["-60 deg", "60 deg"],
                "servo": {"stiffness": "1 N m/rad"},
                "link": {"length": "300 mm", "direction": "z", "rigid": True, "mass": "0 kg"},
            }
        ],
        "payload": {"mass": "0.5 kg"},
    }
    values = [f"{each * MASS * GRAVITY * LENGTH} N m/rad" for each in ratios]
    return lostmotion.sweep(
        stated,
        {"joints.A.servo.stiffness": values},
        poses=9,
        pose_law="grid",
        robots=4,
        visits=2,
        out=folder,
        **more,
    )


@pytest.mark.parametrize("ratios", [(0.9, 2.0, 5.0), (2.0, 0.9, 5.0)])
def test_a_sweep_marks_the_designs_that_fall(ratios, tmp_path):
    """A pendulum that falls upright has no figures, wherever it stands in the list; the others have
    those of a sweep without it, and the headline, a row of the table and result.json name it.
    """
    found = swept(ratios, tmp_path / "three")
    fallen = ratios.index(0.9)
    falls = found.outcomes[fallen].falls
    assert (falls.count, falls.poses, falls.place) == (1, 9, "joint A")
    assert not found.outcomes[fallen].figures
    without = swept((2.0, 5.0), tmp_path / "two").outcomes
    standing = [each for each in found.outcomes if each.falls is None]
    assert [each.p95.value for each in standing] == [each.p95.value for each in without]
    words = "at 1 of 9 poses the springs at joint A cannot hold the load"
    assert found.sheet.verdict.startswith("1 of 3 designs fall at some poses")
    assert words in found.sheet.verdict
    rows = next(each for each in found.sheet.sections if each.key == "designs").rows
    assert [row.note for row in rows if row.note] == [words]
    assert found.sheet.facts["designs"][fallen]["falls"] == {
        "count": 1,
        "poses": 9,
        "place": "joint A",
    }
    assert np.isnan(found.arrays()["p95"].values[fallen]).all()
    found.report()


def test_a_replay_excludes_the_designs_that_fall(tmp_path):
    """The softest spring has the largest errors at the poses where it stands, and no figures: the
    replay is of the next one, names the excluded one, and refuses it where it is asked for.
    """
    found = swept((0.9, 2.0, 5.0), tmp_path / "three", block=3)
    assert np.isfinite(found.store.read(0, 0).poses).any()
    (replayed,) = lostmotion.replay(tmp_path / "three")
    assert replayed.found.design == 1
    assert any("excluded: 0" in note for note in replayed.sheet.notes)
    with pytest.raises(lostmotion.InputError, match="stands at all"):
        lostmotion.replay(tmp_path / "three", design=0)


def test_a_sweep_of_designs_that_all_fall_is_refused(tmp_path):
    """Without a design that stands there is no answer; the message names the joint."""
    with pytest.raises(lostmotion.InputError, match=r"no stable equilibrium at 1 of 9 .* joint A"):
        swept((0.8, 0.9), tmp_path / "none")


def test_a_size_refuses_a_selection_that_falls_before_any_study(monkeypatch):
    """Where the selected arm falls at a pose of the study the joint is named, and no study has
    begun.
    """
    from lostmotion.analyses.sizing import selection
    from lostmotion.mechanism import standing

    link = {
        "length": "300 mm",
        "direction": "z",
        "section": {"kind": "tube", "outer": "20 mm", "wall": "1 mm"},
        "material": "aluminium",
    }
    joint = {"name": "A", "type": "revolute", "axis": "-y", "limits": ["-60 deg", "60 deg"]}
    parts = {"servo": {"stiffness": "9 N m/rad"}, "encoder": {"zero": "6 arcmin"}, "link": link}
    arm = {"name": "soft", "joints": [joint | parts], "payload": {"mass": "0.5 kg"}}
    monkeypatch.setattr(selection, "_studied", None)
    monkeypatch.setattr(standing, "falls_at", lambda _arm, q: np.where(np.arange(len(q)), -1, 2))
    with pytest.raises(lostmotion.InputError, match="joint A cannot hold"):
        lostmotion.size(
            arm, target="200 mm", family="tube", outer="30 mm .. 40 mm", wall="3 mm .. 4 mm"
        )
