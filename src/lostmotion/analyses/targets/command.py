"""Ask what a target asks of an arm's parts, and how many robots keep it."""

from __future__ import annotations

import os
from dataclasses import dataclass
from numbers import Integral
from typing import TYPE_CHECKING, Final

from lostmotion.analyses.arguments import an_arm, chosen_poses, sign_of, whole_seed, zone_of
from lostmotion.analyses.quantities import amounts
from lostmotion.analyses.result import Shown
from lostmotion.error_model.provenance import refuse_undescribed, states
from lostmotion.errors import InputError, Problem, refuse_argument
from lostmotion.propagation.first_order import refuse_large_errors
from lostmotion.units import Quantity

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from lostmotion.analyses.accuracy.answer import Answer
    from lostmotion.analyses.arguments import Ends
    from lostmotion.analyses.quantities import Amount
    from lostmotion.analyses.targets.targets import Kind, Targets
    from lostmotion.analyses.targets.yield_ import Judged, Yield
    from lostmotion.error_model.poses import Poses
    from lostmotion.error_model.provenance import States
    from lostmotion.mechanism.arm import Arm
    from lostmotion.reporting.sheet import Sheet
    from lostmotion.spatial import Floats

DEFAULT_TARGET_POSES: Final = 1024
DEFAULT_TARGET_ROBOTS: Final = 1000
LENGTH: Final = Quantity("m", "0.5 mm", above=0, high=100)
SHARE: Final = Quantity("", "95 %", low=0.5, high=0.999)


def target(  # noqa: PLR0913 - a target is these numbers
    arm: Arm,
    *,
    error: Amount | None = None,
    repeatability: Amount | None = None,
    share: Amount = 0.95,
    poses: int | Floats | Poses = DEFAULT_TARGET_POSES,
    zone: Ends | None = None,
    robots: int = DEFAULT_TARGET_ROBOTS,
    visits: int = 30,
    seed: int = 1,
    approach: str = "random",
    threads: int | None = None,
    progress: Callable[[str, int, int], None] | None = None,
) -> Target:
    """How large may the errors of each part be, for this arm to keep a target, and how many robots keep it as things are?

    error          an amount, "0.5 mm" or 0.0005 m: a share of all positions over the workspace errs by no more
    repeatability  instead: a share of the robots repeats (RP, averaged over the poses) within it
    share          0.95: of positions, or of robots
    poses          how many, chosen by a Sobol sequence, or an array q (pose, joint) in rad and m
    zone           only poses with the tool in it: "x 0.2..0.5 m, z 0..300 mm" in the base's axes, or ends in m, {"x": (0.2, 0.5)}
    robots, visits of the Monte Carlo that verifies every answer and counts the robots

    Raises InputError with every mistake in what is asked.
    """
    from lostmotion.analyses.targets.targets import targets
    from lostmotion.error_model.pose_selection import poses_in_zone

    kind, value, of = _asked(error, repeatability, share)
    arm, sign, seed = an_arm(arm), sign_of(approach), whole_seed(seed)
    refuse_undescribed(arm)
    refuse_large_errors(arm)
    workers = threads or os.cpu_count() or 1
    name = ""
    if zone is None:
        chosen = chosen_poses(arm, poses, "sobol", seed)
    elif isinstance(poses, Integral):
        inside = poses_in_zone(arm, len(chosen_poses(arm, poses, "sobol", seed)), zone_of(zone), seed)
        chosen, name = inside.poses, inside.name
    else:
        raise refuse_argument("zone", "with poses that are given", "a zone, or poses", 'zone = "x 0.2..0.5 m"')
    found = targets(
        arm,
        chosen,
        kind,
        value,
        share=of,
        robots=robots,
        visits=visits,
        seed=seed,
        approach=sign,
        threads=workers,
        zone=name,
        progress=progress,
    )
    return Target(found)


@dataclass(frozen=True)
class Target(Shown):
    """What a target asks of an arm's parts: `summary()`, `report("out/")`, `result()`; `found` holds every number, `found.yields` the yield."""

    found: Targets

    @property
    def states(self) -> States:
        """Return what is known of each joint: stated, assumed, or ideal, and the assumed values."""
        return states(self.found.arm)

    @property
    def sheet(self) -> Sheet:
        """Give every figure, as printed, reported and written."""
        from lostmotion.analyses.targets.tables.targets import targets_sheet

        return targets_sheet(self.found)

    def report(self, out: str | Path, *, force: bool = False) -> Path:
        """Write report.html and result.json into the folder `out`, whole or not at all; gives the folder.

        Raises OutputExistsError where the folder exists and `force` is not set.
        """
        from lostmotion.analyses.targets.report import write_targets

        return write_targets(self.sheet, self.found, out, force=force)


def production_yield(  # noqa: PLR0913 - a production is these numbers
    subject: Arm | Answer,
    target: Amount,
    *,
    judged: Judged = "error",
    share: Amount = 0.95,
    poses: int | Floats | Poses = DEFAULT_TARGET_POSES,
    robots: int = DEFAULT_TARGET_ROBOTS,
    visits: int = 30,
    seed: int = 1,
) -> Yield:
    """Which share of the robots built keeps a target, with an exact interval that counts robots?

    subject  an arm, or a study of one: then its poses, robots, visits, seed and approach count, and none of those here
    target   "0.5 mm", or m
    judged   each robot by: "error", the distance that `share` of its own positions stay within; "worst accuracy", its AP at its worst pose;
             "repeatability", its RP averaged over the poses; "worst repeatability", its RP at its worst pose

    Gives a `Yield`: `share`, `interval`, `curve()` of yield against target. Raises InputError for what cannot be asked.
    """
    from lostmotion.analyses.accuracy.answer import Answer
    from lostmotion.analyses.targets.yield_ import production_of
    from lostmotion.mechanism.arm import Arm

    read = amounts({"target": target, "share": share}, {"target": LENGTH, "share": SHARE}, needed=True)
    value, of = read["target"], read["share"]
    if isinstance(subject, Arm):
        seed = whole_seed(seed)
        refuse_undescribed(subject)
        refuse_large_errors(subject)
        chosen = chosen_poses(subject, poses, "sobol", seed)
        return production_of(subject, chosen, value, judged=judged, share=of, robots=robots, visits=visits, seed=seed)
    if not isinstance(subject, Answer):
        raise refuse_argument("subject", subject, "an arm, or a study of one", "lostmotion.production_yield(arm, target)")
    built = subject.sampled
    return production_of(
        subject.arm,
        subject.poses,
        value,
        judged=judged,
        share=of,
        robots=built.robots,
        visits=built.visits,
        seed=subject.seed,
        approach=subject.approach,
    )


def _asked(error: Amount | None, repeatability: Amount | None, share: Amount) -> tuple[Kind, float, float]:
    """Which of the two is the target, how large is it, m, and of which share? All mistakes at once."""
    problems: list[Problem] = []
    stated: dict[Kind, Amount] = {}
    if error is not None:
        stated["error"] = error
    if repeatability is not None:
        stated["repeatability"] = repeatability
    if len(stated) != 1:
        both = "both error and repeatability" if stated else "neither error nor repeatability"
        problems.append(Problem("", "target", both, "one of the two", f'error = "{LENGTH.example}"'))
    read: dict[str, float] = {}
    try:
        read = amounts({**stated, "share": share}, {"error": LENGTH, "repeatability": LENGTH, "share": SHARE})
    except InputError as mistake:
        problems += mistake.problems
    if problems:
        raise InputError(problems)
    kind = next(iter(stated))
    return kind, read[kind], read["share"]
