"""One study by one route, over the workspace, in zones, and its error budgets; of an arm without
any described error source, workspace and holding torques alone.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Final

from lostmotion.accuracy.answer import Answer, answer
from lostmotion.accuracy.drive_classes import class_figures
from lostmotion.analyses.accuracy.result import AnalyticStudy, Study
from lostmotion.analyses.arguments import chosen_poses
from lostmotion.analyses.result import Result
from lostmotion.error_model.budget import budget, costs
from lostmotion.error_model.few_poses import many_poses
from lostmotion.error_model.intervals import quantile
from lostmotion.error_model.pose_selection import among, one_pose, poses_in_zone
from lostmotion.error_model.poses import sample_poses
from lostmotion.error_model.provenance import states
from lostmotion.error_model.trust import with_figures
from lostmotion.errors import InputError, Problem
from lostmotion.mechanism.placed_terms import short_name
from lostmotion.mechanism.state import tool_points
from lostmotion.propagation.montecarlo.stopping import MOST_POSES
from lostmotion.reporting.sheet import several

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence
    from pathlib import Path

    from lostmotion.accuracy.drive_classes import ClassFigures
    from lostmotion.accuracy.route import FoundInZone, Route
    from lostmotion.accuracy.workspace import Workspace
    from lostmotion.error_model.pose_selection import InZone
    from lostmotion.error_model.poses import PoseLaw, Poses
    from lostmotion.error_model.provenance import States
    from lostmotion.mechanism.arm import Arm
    from lostmotion.mechanism.holding_torques import HoldingTorque
    from lostmotion.propagation.montecarlo.montecarlo import Sampled
    from lostmotion.reporting.plot import Plot
    from lostmotion.reporting.sheet import Lines, Sheet

# Of the largest quantile that a study reports.
_LARGEST_LEVEL: Final = 0.99


def carry_out(
    arm: Arm,
    chosen: Poses,
    law: PoseLaw | None,
    route: Route,
    at: Sequence[Any],
    zones: Sequence[Any],
    target: float | None,
) -> Study | AnalyticStudy:
    """Return the study of these poses by this route, with error budgets at the poses `at`, and the
    same figures in `zones`.

    `law` chooses more poses where the route continues until figures are precise; None where the
    poses were given. `target` (m): an error of which the share of positions within it is counted.
    Raises InputError for a pose that there is not, and a zone that no pose reaches, before anything
    is computed, and for errors so large that they are not counted.
    """
    chosen = with_figures(arm, chosen)
    for pose in at:
        one_pose(chosen.q, pose)
    rooms = [_Room.of(arm, chosen, each, law, route.seed) for each in zones]
    found = route.over(
        arm,
        chosen,
        None
        if law is None
        else lambda count: with_figures(arm, sample_poses(arm, count, law, route.seed)),
    )
    in_zones = tuple(room.studied(route) for room in rooms)
    study: Study | AnalyticStudy
    if found.sampled is not None:
        refuse_beyond_histogram(arm, found.sampled)
        whole = answer(
            arm,
            found.poses,
            found.sampled,
            route.seed,
            approach=route.approach,
            threads=route.threads,
            progress=route.progress,
        )
        besides = {
            "analytic": found.analytic,
            "pooled": found.pooled,
            "stopping": found.stopping,
            "zones": in_zones,
            "target": target,
        }
        kept = {name: getattr(whole, name) for name in Answer.__dataclass_fields__}
        study = Study(**kept | besides | {"classes": class_figures(arm, route.seed)})
    elif found.analytic is not None and found.pooled is not None:
        poses, many = found.poses, many_poses(arm, found.poses)
        every = budget(
            arm,
            poses.q,
            f"over {several(len(poses), 'pose')}",
            approach=route.approach,
            replicates=poses.replicates,
            many=many,
        )
        study = AnalyticStudy(
            arm,
            poses,
            route.approach,
            found.analytic,
            found.pooled,
            every,
            zones=in_zones,
            seed=route.seed,
            threads=route.threads,
            classes=class_figures(arm, route.seed),
        )
    else:
        raise ValueError("a study by no route")
    for pose in at:
        study = study.with_budget(at=pose)
    return study


def refuse_beyond_histogram(arm: Arm, sampled: Sampled) -> None:
    """Raise InputError where the 99th percentile lies beyond the lengths that are counted: some
    value is wrong, and no figure would mean anything.
    """
    if math.isfinite(quantile(sampled.group_hist.sum(axis=0), _LARGEST_LEVEL)):
        return
    largest = short_name(costs(sampled.tally)[0].part)
    raise InputError(
        [
            Problem(
                arm.name,
                largest,
                "the largest share of position errors of 16 m and more",
                "values whose errors are small beside the arm",
                'gearbox = { backlash = "1 arcmin" }',
            )
        ]
    )


@dataclass(frozen=True)
class _Room:
    """A zone to study: its first poses, and where poses are chosen by a law, how more of them are
    found.
    """

    arm: Arm
    zone: InZone
    more: Callable[[int], InZone] | None = None

    @classmethod
    def of(cls, arm: Arm, chosen: Poses, zone: Any, law: PoseLaw | None, seed: int) -> _Room:  # noqa: ANN401 - a mask, or ends by axis
        """Find the poses in a zone: by the law where there is one and the zone has ends, else those
        among the study's own.
        """
        if law is None or not isinstance(zone, dict):
            return cls(arm, among(chosen, tool_points(arm, chosen.q), zone))

        def more(count: int) -> InZone:
            found = poses_in_zone(arm, count, zone, seed, law)
            return replace(found, poses=with_figures(arm, found.poses))

        return cls(arm, more(len(chosen)), more)

    def studied(self, route: Route) -> FoundInZone:
        """Return the zone's figures by the study's route."""
        if self.more is None or route.tolerance is None:
            return route.within(self.arm, self.zone)
        more = self.more
        return route.within(
            self.arm, self.zone, lambda count: more(count).poses, len(more(MOST_POSES).poses)
        )


@dataclass(frozen=True, repr=False)
class Undescribed(Result):
    """The results for an arm without any error source: `summary()`, `report("out/")`,
    `result()`.
    """

    arm: Arm
    poses: Poses
    workspace: Workspace
    worst_torques: list[HoldingTorque]
    lines: Lines | None = None
    classes: tuple[ClassFigures, ...] = ()

    @property
    def states(self) -> States:
        """Return what is known of each joint: stated, assumed, or ideal, and the assumed values."""
        return states(self.arm)

    @property
    def sheet(self) -> Sheet:
        """Return every figure, as printed, reported and written."""
        from lostmotion.analyses.accuracy.page.arm import (
            undescribed_sheet,
            with_first_answer,
        )

        return with_first_answer(
            undescribed_sheet(self.arm, self.poses, self.workspace, self.worst_torques, self.lines),
            self.classes,
        )

    @property
    def plots(self) -> Sequence[Plot]:
        """Return none: there is no error to draw."""
        return ()


def undescribed(
    arm: Arm,
    poses: int | Poses,
    pose_law: PoseLaw,
    seed: int,
    file: Path | None = None,
    sidecar: Path | None = None,
) -> Undescribed:
    """Return workspace and holding torques of an arm, with the lines that would describe it where
    it was read from a file.

    The figures by class of drive stand for the accuracy that the file cannot state: for drives by
    effort limits, else static loads, else the reach.
    """
    from lostmotion.accuracy.drive_classes import first_figures
    from lostmotion.accuracy.workspace import workspace
    from lostmotion.io.drive_loads import drive_loads
    from lostmotion.io.first_sidecar import first_sidecar
    from lostmotion.io.sidecar import sidecar_place
    from lostmotion.io.skeleton import Skeleton, skeleton
    from lostmotion.io.urdf import effort_limits
    from lostmotion.mechanism.holding_torques import holding_torques
    from lostmotion.reporting.sheet import Lines

    efforts = {} if file is None or file.suffix.lower() == ".toml" else effort_limits(file, sidecar)
    drives = drive_loads(arm, efforts)
    lines = None
    if file is not None:
        begun = (
            sidecar is not None or file.suffix.lower() == ".toml" or sidecar_place(file).exists()
        )
        found = (
            skeleton(arm, file, drives, sidecar)
            if begun
            else Skeleton(sidecar_place(file).name, first_sidecar(file))
        )
        begin = "" if begun else f"; `lostmotion new --from {file}` writes them"
        lines = Lines(f"Lines for {found.file}, to start from{begin}:", found.text)
    visited = chosen_poses(arm, poses, pose_law, seed)
    classes = first_figures(arm, drives.of, drives.loads, seed)
    return Undescribed(
        arm, visited, workspace(arm, seed=seed), holding_torques(arm, visited.q)[1], lines, classes
    )
