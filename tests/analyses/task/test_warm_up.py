"""Drift of the tool over a task by the own heat of joints."""

from __future__ import annotations

import math

import numpy as np
import pytest

import lostmotion
from lostmotion.error_model.task import program_of
from lostmotion.io.task_file import read_task
from lostmotion.mechanism.state import state_of
from lostmotion.mechanism.warm_up import link_growth
from lostmotion.propagation.task_success import judged, shares

VALIDATES = (
    (
        "drift of the tool over a task by the own heat of joints",
        (
            "an outstretched arm in closed form; the exact kinematics of a two-joint arm with "
            "lengthened links, and a simulation of its own; a soft arm with longer links settled "
            "again"
        ),
        "1e-9; within the intervals of both; 1e-3 of the drift",
        "mechanism/warm_up.py propagation/task_success.py propagation/task_drift.py",
    ),
)
EXPANSION, LINKS, RISES, CONSTANTS = 23e-6, (0.5, 0.3), (20.0, 8.0), (1800.0, 600.0)
DURATION, OVER = 300.0, 7200.0
HEAT = {
    "duration": DURATION,
    "over": OVER,
    "joints": [
        {"joint": name, "rise": rise, "time_constant": constant}
        for name, rise, constant in zip("AB", RISES, CONSTANTS, strict=True)
    ],
}
TURNING = {"type": "revolute", "limits": ("-170 deg", "170 deg")}


def arm_of(tolerance=0.0, axis="z", **more):
    """Return an arm of two joints whose links expand."""
    joints = [
        {
            **TURNING,
            "axis": axis,
            "name": name,
            "link": {"length": size, "expansion": EXPANSION, "rigid": True}
            | ({"length_tolerance": tolerance} if tolerance else {}),
            **more,
        }
        for name, size in zip("AB", LINKS, strict=True)
    ]
    return lostmotion.Arm.model_validate({"name": "two", "joints": joints})


def program(folder, arm, q, **warm_up):
    """Return the program of a task that visits these joint values, and its keys."""
    text = "A [rad],B [rad]\n" + "".join(f"{a:.15g},{b:.15g}\n" for a, b in q)
    (folder / "q.csv").write_text(text, encoding="utf-8")
    heat = "\n".join(f"{key} = {value!r}" for key, value in warm_up.items() if key != "joints")
    joints = "\n".join(
        f'[[warm_up.joints]]\njoint = "{each["joint"]}"\nrise = "{each["rise"]} K"\n'
        f'time_constant = "{each["time_constant"]} s"'
        for each in warm_up["joints"]
    )
    file = folder / "task.toml"
    stated = f'poses = "q.csv"\n[[tolerances]]\nsphere = "0.5 mm"\n[warm_up]\n{heat}\n{joints}\n'
    file.write_text(stated.replace("'", '"'), encoding="utf-8")
    return program_of(arm, read_task(file, arm)), file


def stated(**more):
    """Return the keys of the warm-up as in a file."""
    return HEAT | {"duration": f"{DURATION} s", "over": f"{OVER} s"} | more


def reach(q, lengths):
    """Return the tool point (..., 2) of a planar arm by the cosines of its angles."""
    a, b = q[..., 0], q[..., 0] + q[..., 1]
    return np.stack(
        [
            lengths[0] * np.cos(a) + lengths[1] * np.cos(b),
            lengths[0] * np.sin(a) + lengths[1] * np.sin(b),
        ],
        axis=-1,
    )


def lengths_at(time):
    """Return the lengths of both links after these times, by their own exponentials."""
    return [
        length * (1 + EXPANSION * rise * (1 - np.exp(-time / constant)))
        for length, rise, constant in zip(LINKS, RISES, CONSTANTS, strict=True)
    ]


def test_an_outstretched_arm_grows_along_itself(tmp_path):
    """Displacement is expansion x rise x (1 - exp(-t / T)) x length of each link, at the times of
    three places in a run of five minutes, repeated over two hours.
    """
    made, _ = program(tmp_path, arm_of(), np.zeros((3, 2)), **stated())
    found = made.grown(4)
    for run in range(4):
        for place in range(3):
            time = (OVER - DURATION) * (run + 0.5) / 4 + DURATION * place / 2
            whole = sum(
                EXPANSION * rise * (1 - math.exp(-time / constant)) * length
                for length, rise, constant in zip(LINKS, RISES, CONSTANTS, strict=True)
            )
            expected = [0, 0, 0, whole, 0, 0]
            np.testing.assert_allclose(found.sum(axis=0)[place, :, run], expected, atol=1e-15)
    warm, _ = program(tmp_path, arm_of(), np.zeros((3, 2)), **stated(start="warm"))
    full = EXPANSION * sum(a * b for a, b in zip(LINKS, RISES, strict=True))
    np.testing.assert_allclose(warm.grown(4).sum(axis=0)[:, 3], full, rtol=1e-12)


def test_a_task_drifts_out_of_its_tolerance(tmp_path):
    """The probability over a shift against robots of its own with lengthened links: as many hold
    as hold the tolerance of 0.25 mm about the point, and the first run does better than the last.
    """
    arm, robots, runs = arm_of(tolerance="0.35 mm"), 3000, 6
    q = np.array([[0.3, 0.9], [-0.5, 1.4], [0.8, -0.6]])
    _, file = program(tmp_path, arm, q, **stated())
    rng = np.random.default_rng(4)
    draws = rng.standard_normal((robots * 2, 2)) / 3
    draws = draws[(np.abs(draws) < 1).all(axis=1)][:robots] * 0.35e-3
    begins = (OVER - DURATION) * (np.arange(runs) + 0.5) / runs
    held = np.ones((robots, runs), dtype=bool)
    for place, time in enumerate(np.array([0, 0.5, 1])[:, None] * DURATION + begins):
        grown = [length + draws[:, k, None] for k, length in enumerate(lengths_at(time))]
        at = np.broadcast_to(q[place], (robots, runs, 2))
        off = reach(at, grown) - reach(q[place], LINKS)
        held &= np.linalg.norm(off, axis=-1) <= 0.25e-3
    found = lostmotion.task(arm, file, robots=robots, runs=runs, seed=2)
    spread = held.mean(axis=1).std() / math.sqrt(robots)
    assert 0.1 < held.mean() < 0.9
    error = math.hypot(spread, (found.success.high - found.success.low) / 4)
    assert abs(found.success.value - held.mean()) < 3 * error
    assert found.drift.last.value < found.drift.first.value
    assert found.drift.first.value == pytest.approx(held[:, 0].mean(), abs=0.04)
    # the largest displacement is the exact one of the last run but for second order
    last = [
        np.linalg.norm(reach(q[k], lengths_at(begins[-1] + DURATION * k / 2)) - reach(q[k], LINKS))
        for k in range(3)
    ]
    assert found.drift.largest == pytest.approx(max(last), rel=1e-9)
    assert found.drift.place == int(np.argmax(last))
    # taught warm it is as if nothing grew
    by_name = {each.name: each.success.value for each in found.helps.stages}
    assert by_name["warmed up before, taught warm"] > by_name["warmed up before"]


def test_own_heat_is_a_contributor(tmp_path):
    """Its share is that of the samples: the mean product of the growth with the whole error, in
    the direction of the tolerance; growth of one link may oppose that of another.
    """
    arm = arm_of("0.1 mm", "-y", servo={"stiffness": "9000 N m/rad"}, mass="2 kg")
    q, runs = np.array([[0.2, 2.6]]), 5
    made, _ = program(tmp_path, arm, q, **stated())
    matrix = made.matrix()
    operator = np.zeros((2, 1, 6))
    operator[0, 0, 3] = operator[1, 0, 5] = 1
    found = shares(made, matrix, operator, "part", runs)
    assert sum(found.values()) == pytest.approx(1)
    grown = made.grown(runs)[:, 0, 3::2]
    bias = matrix.bias[0, 3::2]
    drawn = sum(
        (matrix.tool[0, 3::2, k] ** 2).sum() for k, each in enumerate(matrix.infos) if each.draws
    )
    whole = bias[:, None] + grown.sum(axis=0)
    square = (whole**2).sum(axis=0).mean() + drawn
    for k, name in enumerate("AB"):
        expected = (grown[k] * whole).sum(axis=0).mean() / square
        assert found[f"own heat of {name}"] == pytest.approx(expected, rel=1e-9)
    assert np.abs(bias).max() > 1e-5
    sampled = judged(made, matrix, 4000, runs, 1).used[0] * 0.25e-3
    assert (sampled**2).mean() == pytest.approx(square, rel=0.01)


def test_a_soft_arm_follows_the_growth():
    """Longer links load the springs more: the drift of a soft arm is the difference between both
    arms where they stand.
    """

    def built(grown=0.0):
        joints = [
            {
                **TURNING,
                "axis": "-y",
                "name": name,
                "servo": {"stiffness": "12 N m/rad"},
                "link": {
                    "length": length * (1 + grown),
                    "expansion": EXPANSION,
                    "rigid": True,
                    "mass": "0 kg",
                },
            }
            for name, length in zip("AB", LINKS, strict=True)
        ]
        return lostmotion.Arm.model_validate(
            {"name": "soft", "joints": joints, "payload": {"mass": "0.4 kg"}}
        )

    q = np.array([[0.2, 0.5], [0.9, -1.1]])
    cold, warm = (state_of(built(g), q).settled() for g in (0.0, 1e-4))
    assert cold.arm.soft_freedoms
    found = link_growth(cold, dict.fromkeys("AB", 1e-4 / EXPANSION)).sum(axis=0)[:, 3:]
    expected = (warm.frames[-1] - cold.frames[-1])[:, :3, 3]
    rigid = state_of(built(1e-4), q).frames[-1] - state_of(built(), q).frames[-1]
    assert np.abs(rigid[:, :3, 3] - expected).max() > 0.02 * np.abs(expected).max()
    np.testing.assert_allclose(found, expected, atol=1e-3 * np.abs(expected).max())
