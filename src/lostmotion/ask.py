"""The front door's verbs: read an arm, study it, size its links; look at one gearbox."""

from __future__ import annotations

import os
from numbers import Integral
from typing import TYPE_CHECKING, Any, Literal, overload

import numpy as np

from lostmotion.errors import refuse_argument
from lostmotion.shown import AnalyticStudy, Gear, Size, Study
from lostmotion.studies.answer import Answer, answer
from lostmotion.studies.poses import PoseLaw, Poses, sample_poses

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from lostmotion.arm import Arm
    from lostmotion.spatial import Floats

Approach = Literal["random", "up", "down"]
Method = Literal["montecarlo", "analytic", "both"]
_METHODS: tuple[Method, ...] = ("montecarlo", "analytic", "both")
_SIGNS: dict[str, float] = {"random": 0.0, "up": 1.0, "down": -1.0}
DEFAULT_POSES = 2048
DEFAULT_ROBOTS = 1000
DEFAULT_VISITS = 30
DEFAULT_GEARBOXES = 1000
DEFAULT_SIZING_POSES = 1024


def gear(path: str | Path, joint: str | None = None, torque: float | None = None, gearboxes: int = DEFAULT_GEARBOXES, seed: int = 1) -> Gear:
    """What does the gearbox in this file do: play, lost motion, wind-up and through what, hysteresis, transmission error?

    path      a file about a gearbox, or an arm with the `joint` whose gearbox is meant
    torque    N m at the output; left out: the rated one
    gearboxes how many are built of a drawing
    seed      same seed, same bits

    Raises InputError with every mistake in the file, and as `studies.gear.gear`.
    """
    from lostmotion.formats.part_file import read_gearbox
    from lostmotion.studies.gear import gear as look_at

    found = read_gearbox(path, joint)
    return Gear(found.name, found.notes, look_at(found.part, torque, gearboxes, seed))


def size(
    arm: Arm,
    by: str | Path | None = None,
    poses: int = DEFAULT_SIZING_POSES,
    seed: int = 1,
    *,
    also: Floats | None = None,
    progress: Callable[[str, int, int], None] | None = None,
    **asked: Any,  # noqa: ANN401 - keys of a file's table
) -> Size:
    """Which sections make the links of this arm as light as their limits allow, and what would other limits cost?

    by      a TOML that says how (`formats.sizing`); left out: the paper's condition (4), each link among sections like its own
    poses   how many to look at, by a Sobol sequence; corners of the joints' ranges are looked at besides, and `also` (pose, joint), rad and m
    asked   keys of its table as in the file, slope="0.5 arcmin", deflection=2500, tilt="10 deg", family={"kind": "tube", ...}

    Raises InputError with every mistake in file and keys.
    """
    from pathlib import Path

    from lostmotion.formats.sizing import read_sizing
    from lostmotion.studies.sizing import size_links

    plan, wanted = read_sizing(None if by is None else Path(by), asked, arm)
    chosen = sample_poses(arm, poses, seed=seed)
    return Size(size_links(arm, wanted, plan.limits, chosen, tilt=plan.tilt, step=plan.step, also=also, progress=progress))


def read(path: str | Path, sidecar: str | Path | None = None) -> Arm:
    """Which arm does this file describe? Native TOML or URDF, by its ending.

    `sidecar` is the TOML that says what a URDF cannot (gearboxes, bearings, sections, tolerances). Raises InputError with every mistake in the file.
    """
    from lostmotion.formats import read as read_file

    return read_file(path, sidecar)


@overload
def study(
    arm: Arm,
    poses: int | Floats | Poses = DEFAULT_POSES,
    robots: int = DEFAULT_ROBOTS,
    visits: int = DEFAULT_VISITS,
    seed: int = 1,
    *,
    pose_law: PoseLaw = "sobol",
    approach: Approach = "random",
    method: Literal["montecarlo", "both"] = "montecarlo",
    threads: int | None = None,
    tile: int = 1,
    progress: Callable[[str, int, int], None] | None = None,
) -> Study: ...


@overload
def study(
    arm: Arm,
    poses: int | Floats | Poses = DEFAULT_POSES,
    robots: int = DEFAULT_ROBOTS,
    visits: int = DEFAULT_VISITS,
    seed: int = 1,
    *,
    pose_law: PoseLaw = "sobol",
    approach: Approach = "random",
    method: Literal["analytic"],
    threads: int | None = None,
    tile: int = 1,
    progress: Callable[[str, int, int], None] | None = None,
) -> AnalyticStudy: ...


@overload
def study(
    arm: Arm,
    poses: int | Floats | Poses = DEFAULT_POSES,
    robots: int = DEFAULT_ROBOTS,
    visits: int = DEFAULT_VISITS,
    seed: int = 1,
    *,
    pose_law: PoseLaw = "sobol",
    approach: Approach = "random",
    method: Method,
    threads: int | None = None,
    tile: int = 1,
    progress: Callable[[str, int, int], None] | None = None,
) -> Study | AnalyticStudy: ...


def study(  # noqa: PLR0913 - a study is these numbers
    arm: Arm,
    poses: int | Floats | Poses = DEFAULT_POSES,
    robots: int = DEFAULT_ROBOTS,
    visits: int = DEFAULT_VISITS,
    seed: int = 1,
    *,
    pose_law: PoseLaw = "sobol",
    approach: Approach = "random",
    method: Method = "montecarlo",
    threads: int | None = None,
    tile: int = 1,
    progress: Callable[[str, int, int], None] | None = None,
) -> Study | AnalyticStudy:
    """How accurate is this arm before it is built, where in its workspace, and which part is to blame?

    poses     how many to choose by `pose_law` within the joint limits, or an array q (pose, joint) in rad and m
    robots    how many are built; each is drawn once and visits every pose
    visits    how often each returns to each pose (ISO 9283 asks for 30)
    seed      same seed, same bits, whatever the threads
    approach  how every joint's last motion before it stops goes: "up", "down", or "random", either way from visit to visit
    method    "montecarlo": samples; "analytic": sums over terms and quadrature, milliseconds, no robots or visits drawn, gives an `AnalyticStudy`;
              "both": all of the first, the figures of the second, and how far the two differ
    threads   left out: one per processor

    Raises InputError (a ValueError) for counts out of range, an unknown law or approach, and for q of another shape or not finite.
    """
    if approach not in _SIGNS:
        raise refuse_argument("approach", approach, "one of " + ", ".join(_SIGNS), 'approach = "random"')
    if not isinstance(seed, Integral) or seed < 0:
        raise refuse_argument("seed", seed, "a whole number, zero or more", "seed = 1")
    if method not in _METHODS:
        raise refuse_argument("method", method, "one of " + ", ".join(_METHODS), 'method = "both"')
    chosen = _chosen(arm, poses, pose_law, int(seed))
    workers = threads or os.cpu_count() or 1
    without: dict[str, Any] = {}
    if method != "montecarlo":
        from lostmotion.studies.analytic import analytic, pooled

        every = analytic(arm, chosen, approach=_SIGNS[approach], threads=workers, progress=progress)
        without = {"analytic": every, "pooled": pooled(every, chosen.replicates, workers)}
        if method == "analytic":
            return AnalyticStudy(arm, chosen, **without)
    found = answer(
        arm,
        chosen,
        robots=robots,
        visits=visits,
        seed=int(seed),
        approach=_SIGNS[approach],
        threads=workers,
        tile=tile,
        progress=progress,
    )
    return Study(**{name: getattr(found, name) for name in Answer.__dataclass_fields__} | without)


def _chosen(arm: Arm, poses: int | Floats | Poses, law: PoseLaw, seed: int) -> Poses:
    if isinstance(poses, Integral):
        return sample_poses(arm, int(poses), law, seed)
    if isinstance(poses, Poses):
        return poses
    from lostmotion.arm import as_poses

    return Poses(as_poses(arm, np.asarray(poses)), "given")
