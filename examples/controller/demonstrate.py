"""What compensation and calibration take from the error of robots drawn one by one, beside what a
study of the same arm predicts.

    python examples/controller/demonstrate.py                      the paper's arm with drawn drives
    python examples/controller/demonstrate.py ARM --out FOLDER     another arm

Every robot has its own lengths, encoder zeros, stiffness, play and harmonics. It goes to the same
poses by the commanded joint values, and by those that its controller corrects. Where its tool
arrives follows from the exact composition of all its errors at the command that was sent, not from
the first-order sum with which the controller predicts.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import NamedTuple

import numpy as np

import lostmotion
from lostmotion.controller_model.controller import OPEN_PLAY
from lostmotion.error_model.draws import robot_draws
from lostmotion.error_model.pose_matrix import PoseMatrix, screws
from lostmotion.error_model.poses import sample_poses
from lostmotion.mechanism.state import state_of
from lostmotion.printed import factor_of
from lostmotion.propagation.exact import compose, draws_of
from lostmotion.propagation.montecarlo.waterfall import Waterfall, geometry_of, waterfall
from lostmotion.reporting.chart import label_axes, legend, one
from lostmotion.reporting.page.document import contents
from lostmotion.reporting.palette import LIGHT
from lostmotion.reporting.plot import Plot
from lostmotion.reporting.sheet import Card, Cell, Row, Section, Sheet, length

ARM = Path(__file__).parents[1] / "z-arm-drawn.toml"
POSES, ROBOTS, VISITS, SEED = 64, 48, 4, 2026
STUDY_ROBOTS = 512
RESAMPLED = 400
# What is sent, and the stage of the study's waterfall that it corresponds to.
STAGES = {
    "as commanded": "as manufactured",
    "calibrated": "calibrated",
    "compensated": "load compensated",
    "calibrated and compensated": "both",
    "each robot mapped": "both, and each robot mapped",
}


class Robot(NamedTuple):
    """A drawn robot: its number, and what an ideal identification finds: the draws of its geometry,
    and all draws that it keeps.
    """

    number: int
    geometry: lostmotion.Calibration
    whole: lostmotion.Calibration


class Demonstration(NamedTuple):
    """Result: for each of STAGES the errors of the tool (robot, pose, visit), m; what gravity moves
    the tool by, m (robot,), r.m.s. over poses.

    The latter is as commanded, compensated by the design, and compensated with each robot mapped.
    `opens`: some play is closed in some robots only.
    """

    errors: dict[str, np.ndarray]
    by_gravity: np.ndarray
    predicted: Waterfall
    opens: bool


def robots_of(arm: lostmotion.Arm, matrix: PoseMatrix) -> list[Robot]:
    """Return drawn robots, each with its true draws."""
    geometry, numbers = geometry_of(arm), np.arange(ROBOTS)
    found = {info.robot: info.name in geometry for info in matrix.infos if info.robot is not None}
    draws = np.stack([robot_draws(SEED, [stream], ROBOTS)[:, 0].ravel() for stream in found])

    def known(number: int, chosen: list[int]) -> lostmotion.Calibration:
        streams = tuple((list(found)[k].name, list(found)[k].law) for k in chosen)
        return lostmotion.Calibration(
            streams, draws[chosen, number], np.zeros((len(chosen), len(chosen)))
        )

    constant = [k for k, is_geometry in enumerate(found.values()) if is_geometry]
    return [
        Robot(number, known(number, constant), known(number, [*range(len(found))]))
        for number in numbers
    ]


def arrivals(
    arm: lostmotion.Arm, command: np.ndarray, robot: Robot, visits: int = VISITS
) -> np.ndarray:
    """Return where the tool of a robot arrives (pose, visit, 3), m; without visits where it arrives
    on average over them.
    """
    matrix, rows = screws(state_of(arm, command)), np.arange(len(command))
    row, visit = (
        each.ravel() for each in np.meshgrid(rows, np.arange(max(visits, 1)), indexing="ij")
    )
    draws = draws_of(matrix, row, SEED, row, np.full(len(row), robot.number), visit)
    if not visits:
        draws[[info.visit is not None for info in matrix.infos]] = 0.0
    return compose(matrix, rows, draws.reshape(len(draws), len(rows), -1).transpose(1, 0, 2))[
        :, :, :3, 3
    ]


def demonstrate(arm: lostmotion.Arm) -> Demonstration:
    """Send every robot to every pose with each command, and again without gravity."""
    poses = sample_poses(arm, POSES, seed=SEED)
    q, weightless, none = poses.q, arm.model_copy(update={"gravity": 0.0}), np.zeros(3)
    design, matrix = lostmotion.controller(arm), screws(state_of(arm, q))
    ideal, compensated = design.predict(q).point[:, None], design.compensate(q).command
    errors: dict[str, list[np.ndarray]] = {name: [] for name in STAGES}
    by_gravity = []
    for robot in robots_of(arm, matrix):
        calibrated, mapped = (
            lostmotion.controller(arm, calibration=each) for each in (robot.geometry, robot.whole)
        )
        both, best = calibrated.compensate(q).command, mapped.compensate(q).command
        for name, command in zip(
            STAGES, (q, q + both - compensated, compensated, both, best), strict=True
        ):
            errors[name].append(np.linalg.norm(arrivals(arm, command, robot) - ideal, axis=-1))
        pairs = (
            (q, q),
            *(
                (command, model.compensate(q, gravity=none).command)
                for command, model in ((compensated, design), (best, mapped))
            ),
        )
        by_gravity.append(
            [
                _rms(arrivals(arm, heavy, robot, 0) - arrivals(weightless, light, robot, 0))
                for heavy, light in pairs
            ]
        )
    predicted = waterfall(arm, poses, STUDY_ROBOTS, VISITS, SEED + 1)
    opens = bool((design.predict(q).flags & OPEN_PLAY).any())
    return Demonstration(
        {name: np.stack(each) for name, each in errors.items()},
        np.array(by_gravity).T,
        predicted,
        opens,
    )


def _rms(shift: np.ndarray) -> float:
    return float(np.sqrt((shift**2).sum(axis=-1).mean()))


def percentile(errors: np.ndarray) -> tuple[float, float, float]:
    """Return the 95th percentile over robots, poses and visits with its 95 % interval, by
    resampling robots and poses.
    """
    random = np.random.default_rng(SEED)
    robots, poses = errors.shape[:2]
    again = [
        np.quantile(
            errors[random.integers(robots, size=robots)][:, random.integers(poses, size=poses)],
            0.95,
        )
        for _ in range(RESAMPLED)
    ]
    return (
        float(np.quantile(errors, 0.95)),
        float(np.quantile(again, 0.025)),
        float(np.quantile(again, 0.975)),
    )


def sheet_of(arm: lostmotion.Arm, found: Demonstration) -> tuple[Sheet, list[Plot]]:
    """Lay the result out as the reports do."""
    counted = f"{ROBOTS} robots x {POSES} poses x {VISITS} visits"
    drawn = {name: length(*percentile(errors), counted) for name, errors in found.errors.items()}
    stages = {stage.name: stage.q95 for stage in found.predicted.stages}
    study = {
        name: length(stages[of].value, stages[of].low, stages[of].high)
        for name, of in STAGES.items()
    }
    rows = tuple(Row(name, (drawn[name], study[name])) for name in STAGES)
    whole = found.by_gravity[0]
    named = zip(
        ("as commanded", "compensated by the design", "compensated, each robot mapped"),
        found.by_gravity,
        strict=True,
    )
    gravity = tuple(
        Row(
            name,
            (
                length(_rms(moved[:, None]), samples=counted),
                Cell(100 * (1 - _rms(moved[:, None]) / _rms(whole[:, None])), "%"),
            ),
        )
        for name, moved in named
    )
    closes = (
        "most of the rest comes from poses at which the load hardly exceeds the friction, so that "
        "a play is closed in some robots only"
    )
    left = (
        "on average over visits. The design cannot know by how much play and stiffness of a robot "
        "differ from it"
    )
    if found.opens:
        left += f"; with these known, {closes}"
    sections = (
        Section(
            "stages",
            "95 % of all positions are within",
            ("drawn robots", "predicted by the study"),
            rows,
        ),
        Section("gravity", "Moved by gravity", ("r.m.s.", "taken away"), gravity, left),
    )
    both, first = drawn["calibrated and compensated"], drawn["as commanded"]
    by_design, mapped = (row.cells[1] for row in gravity[1:])
    verdict = (
        f"95 % of the positions of the drawn robots are within {first} as commanded, "
        f"{drawn['compensated']} compensated, {drawn['calibrated']} "
        f"calibrated, and {both} with both. Compensation by the design takes {by_design} of "
        "what gravity causes, "
        f"and {mapped} where each robot is mapped."
    )
    cards = tuple(
        Card(name, str(figure), f"study: {study[name]}") for name, figure in drawn.items()
    )
    source = (
        f"examples/controller/demonstrate.py, {counted}, seed {SEED}; the study drew "
        f"{found.predicted.robots} other robots at the same poses"
    )
    words = (
        (
            "compensated",
            (
                "the joint command is corrected by what the controller expects of any robot of "
                "this design, under this load"
            ),
        ),
        (
            "calibrated",
            (
                "the command is corrected by what is constant in the frames of this robot: "
                "lengths, encoder zeros, misalignments"
            ),
        ),
        (
            "mapped",
            (
                "all draws that the robot keeps are known: also harmonics, stiffness and the size "
                "of its plays"
            ),
        ),
    )
    sheet = Sheet(
        name=arm.name,
        subject="compensation and calibration",
        verdict=verdict,
        cards=cards,
        sections=sections,
        words=words,
        source=source,
        seed=SEED,
    )
    return sheet, [
        Plot(
            "stages",
            "stages",
            _bars(drawn, study),
            "95th percentile of the position error for each command, drawn and predicted",
        )
    ]


def _bars(drawn: dict[str, Cell], study: dict[str, Cell]) -> object:
    unit = drawn["as commanded"].shown
    figure, on = one("95th percentile of the position error", 90)
    for k, (title, figures, colour) in enumerate(
        (("drawn robots", drawn, LIGHT["robot"]), ("study", study, LIGHT["visit"]))
    ):
        values, low, high = (
            np.array([getattr(each, end) for each in figures.values()]) * factor_of(unit)
            for end in ("value", "low", "high")
        )
        at = np.arange(len(figures)) + 0.4 * (k - 0.5)
        on.bar(
            at,
            values,
            0.38,
            yerr=np.nan_to_num([values - low, high - values]),
            color=colour,
            ecolor=LIGHT["ink"],
            label=title,
        )
    on.set_xticks(range(len(drawn)), [name.replace(" ", "\n") for name in drawn])
    label_axes(on, y=f"95th percentile [{unit}]")
    legend(figure)
    return figure


def main() -> None:
    """Print the result and write the page."""
    asked = argparse.ArgumentParser(
        description="What compensation and calibration take from the error of drawn robots."
    )
    asked.add_argument("arm", nargs="?", type=Path, default=ARM)
    asked.add_argument("--out", type=Path, default=Path("controller-demonstration"))
    given = asked.parse_args()
    arm = lostmotion.read(given.arm)
    sheet, plots = sheet_of(arm, demonstrate(arm))
    print(sheet.verdict)
    for section in sheet.sections:
        print(f"\n{section.title}")
        for row in section.rows:
            print(
                f"  {row.label:36}"
                + "".join(f"{figure!s:>14} {figure.between:>22}" for figure in row.cells)
            )
    given.out.mkdir(parents=True, exist_ok=True)
    for name, content in contents(sheet, plots).items():
        (given.out / name).write_bytes(content)
    print(f"\nReport: {given.out / 'report.html'}")


if __name__ == "__main__":
    main()
