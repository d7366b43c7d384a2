"""Which sections make an arm as light as its limits allow? The paper's condition (4), link by link from the tip inward, and what it costs.

Condition (4) of S. Strutynskyi, R. Semenchuk 2021: of each link the lightest section with a slope of no more than 0.5' and a deflection of no more
than length/2500, under load at the worst pose. A link carries what hangs outboard of it and itself, nothing inboard: sized from the tip inward every
link meets its final load, and one pass is exact. Nor would a heavier outboard link ever make an inboard one lighter, as long as its weight bends that
link the same way as the rest does where it bends most; `LinkSize.relieved_by` names the links of which that is not so.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.analyses.sizing.lightest import SLACK, Found, Limits, Task, lightest, with_section
from lostmotion.analyses.sizing.link_deflection import LinkLoads, Worst, across, bending_under
from lostmotion.error_model.budget import Tally
from lostmotion.error_model.pose_matrix import screws
from lostmotion.error_model.poses import Poses, sample_poses
from lostmotion.mechanism.load_causes import LinkBending, bending
from lostmotion.mechanism.serial import as_poses

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from lostmotion.mechanism.arm import Arm
    from lostmotion.parts.family import Family
    from lostmotion.parts.material import Material
    from lostmotion.parts.profile import Section
    from lostmotion.parts.section import Plain
    from lostmotion.spatial import Floats

# The paper's: 0.5' and length/2500.
PAPER: Final = Limits(0.5 * math.pi / 10800, 2500.0)
# The trade-off: both limits from four times as strict to four times as loose.
SCALES: Final = tuple(2.0 ** (k / 2) for k in range(-4, 5))
_MOST_CORNERS: Final = 4096
_ROUNDS: Final = 6
_SHARPENED: Final = 2
_WORSE: Final = 1e-6
_BLOCK: Final = 1024
_ERROR_POSES: Final = 512


@dataclass(frozen=True, slots=True)
class Wanted:
    """How one link may be made: a family of sections or a list of them, and of which material where not of its own."""

    choice: Family | tuple[Plain, ...]
    material: Material | None = None


@dataclass(frozen=True, slots=True)
class LinkSize:
    """One link that was sized; SI.

    before, section      its section as stated (None: rigid, or by a matrix) and as chosen, mass_before and mass what the link weighs then
    worst, worst_before  slope and deflection at worst over poses and tilts, with the chosen section under the new loads, and as stated (None: rigid)
    limits               slope, and deflection as a length
    holds                whether the chosen section holds them: where not, it is the one that misses them by least
    force, moment, own   across the link, N and N m, on its tip where the limit that binds is taken most, and its own weight across it there, N
    relieved_by          sized joints outboard whose links' weight bends this one the other way there: heavier they would relieve it
    """

    joint: str
    length: float
    before: Section | None
    section: Plain
    mass_before: float
    mass: float
    worst: Worst
    worst_before: Worst | None
    limits: tuple[float, float]
    holds: bool
    force: float
    moment: float
    own: float
    relieved_by: tuple[str, ...]

    @property
    def shares(self) -> tuple[float, float]:
        """Give how much of each limit is taken."""
        return self.worst.slope / self.limits[0], self.worst.deflection / self.limits[1]

    @property
    def binds(self) -> int:
        """Tell which limit is taken more: 0 slope, 1 deflection."""
        return int(self.shares[1] > self.shares[0])

    @property
    def index(self) -> int:
        """Give the pose where the limit that binds is taken most."""
        return self.worst.deflection_index if self.binds else self.worst.slope_index


@dataclass(frozen=True, slots=True)
class Trade:
    """One point of the trade-off: limits `scale` times as wide, the links' mass (kg), the r.m.s. tool error (m), whether all limits hold."""

    scale: float
    mass: float
    rms: float
    holds: bool


@dataclass(frozen=True, repr=False)
class Sizing:
    """An arm whose links were sized.

    arm, sized      as stated, and with the sections chosen
    q               (pose, joint) all poses looked at: those sampled, those given besides, corners of the joints' ranges, worse ones between
    links           one per link sized, base to tip; kept: joints whose links were left as they are
    rms, rms_before r.m.s. tool error over the sampled poses, m: exact sums over terms
    trade           the trade-off, strict to loose
    check           the sized arm looked at afresh, at other poses that the sizing did not see, and as it stands: `causes.bending` of each link
    """

    arm: Arm
    sized: Arm
    limits: Limits
    tilt: float | None
    poses: Poses
    given: int
    corners: int
    q: Floats
    links: tuple[LinkSize, ...]
    kept: tuple[str, ...]
    rms: float
    rms_before: float
    trade: tuple[Trade, ...]
    check: tuple[LinkBending, ...]
    check_poses: int

    @property
    def holds(self) -> bool:
        """Tell whether every link sized holds its limits."""
        return all(link.holds for link in self.links)

    @property
    def exceeded(self) -> float:
        """Give the largest share of a limit that a sized link takes when it is looked at afresh."""
        limits = {link.joint: link.limits for link in self.links}
        shares = [max(bent.slope / limits[bent.joint][0], bent.deflection / limits[bent.joint][1]) for bent in self.check if bent.joint in limits]
        return max(shares, default=0.0)


def size_links(  # noqa: PLR0913 - a sizing is these numbers
    arm: Arm,
    wanted: Mapping[str, Wanted],
    limits: Limits,
    poses: Poses,
    *,
    tilt: float | None = None,
    step: float = 1e-4,
    also: Floats | None = None,
    progress: Callable[[str, int, int], None] | None = None,
) -> Sizing:
    """Which sections are the lightest that hold these limits, link by link, and what would other limits cost?

    wanted   the links to size, by the name of their joint
    poses    to look at; corners of the joints' ranges are added, and from the worst poses worse ones are climbed to
    tilt     rad: by how much the base may lean from level, towards any side
    step     m: free sizes come in whole steps of this; 0: as they come
    also     (pose, joint) rad or m: more poses to look at

    A link that no section serves gets the one that misses its limits by least (`LinkSize.holds`).
    """
    tell = progress or (lambda *_: None)
    ends = corners(arm)
    given = np.zeros((0, ends.shape[1])) if also is None else as_poses(arm, also)
    q = np.vstack([poses.q, given, ends])
    sized = arm
    found: dict[str, Found] = {}
    for turn in range(_ROUNDS):
        tell("sizing links", turn, _ROUNDS)
        sized, found = _one_pass(arm, wanted, limits, q, tilt, step)
        worse = _worse_poses(sized, wanted, limits, q, tilt)
        if not len(worse):
            break
        q = np.vstack([q, worse])
    links = tuple(_told(arm, sized, name, limits, q, tilt, list(found)) for name in reversed(list(found)))
    few = sample_poses(arm, min(len(poses), _ERROR_POSES)).q if poses.law != "given" else poses.q
    trade = []
    for k, scale in enumerate(SCALES):
        tell("trading mass for error", k, len(SCALES))
        other, sections = (sized, found) if scale == 1 else _one_pass(arm, wanted, limits.scaled(scale), q, tilt, step)
        trade.append(Trade(scale, _mass(other, wanted), rms_error(other, few), all(each.holds for each in sections.values())))
    fresh = sample_poses(arm, len(poses), seed=2) if poses.law != "given" else poses
    check = bending(sized, fresh.q, np.zeros((len(fresh), 3)), 0.0)
    kept = tuple(joint.name for joint in arm.joints if joint.link.reach and joint.name not in wanted)
    return Sizing(
        arm,
        sized,
        limits,
        tilt,
        poses,
        len(given),
        len(ends),
        q,
        links,
        kept,
        rms_error(sized, few),
        rms_error(arm, few),
        tuple(trade),
        tuple(check),
        len(fresh),
    )


def rms_error(arm: Arm, q: Floats) -> float:
    """What is the r.m.s. tool error over these poses, m? The exact sum over terms of bias and variances, nothing drawn."""
    total = sum(Tally.of(screws(arm, q[start : start + _BLOCK])).total for start in range(0, len(q), _BLOCK))
    return math.sqrt(total / len(q))


def _mass(arm: Arm, wanted: Mapping[str, Wanted]) -> float:
    return sum(joint.link.total_mass for joint in arm.joints if joint.name in wanted)


def corners(arm: Arm, most: int = _MOST_CORNERS) -> Floats:
    """Where are the corners of the joints' ranges (pose, joint), rad or m? All, or at most so many: the last joints half way."""
    ends = arm.limits
    moving = min(len(ends), int(math.log2(most)))
    out = np.tile(ends.mean(axis=1), (2**moving, 1))
    for k in range(moving):
        out[:, k] = ends[k][(np.arange(2**moving) >> k) & 1]
    return out


def _with(arm: Arm, name: str, section: Plain, material: Material | None) -> Arm:
    joints = tuple(with_section(joint, section, material) if joint.name == name else joint for joint in arm.joints)
    return arm.model_copy(update={"joints": joints})


def _index(arm: Arm, name: str) -> int:
    return next(k for k, joint in enumerate(arm.joints) if joint.name == name)


def _one_pass(arm: Arm, wanted: Mapping[str, Wanted], limits: Limits, q: Floats, tilt: float | None, step: float) -> tuple[Arm, dict[str, Found]]:
    """Size every link once, from the tip inward; the links found in that order."""
    sized = arm
    found: dict[str, Found] = {}
    for k, joint in reversed(list(enumerate(arm.joints))):
        if joint.name in wanted:
            each = wanted[joint.name]
            task = Task(joint, LinkLoads.of(sized, k, q, tilt), limits, each.material)
            found[joint.name] = lightest(task, each.choice, step)
            sized = _with(sized, joint.name, found[joint.name].section, each.material)
    return sized, found


def _worse_poses(sized: Arm, wanted: Mapping[str, Wanted], limits: Limits, q: Floats, tilt: float | None) -> Floats:
    """Which poses near the worst ones bend a link more, beyond its limits? (pose, joint), none where no such pose is found."""
    found = []
    for k, joint in enumerate(sized.joints):
        if joint.name in wanted:
            task = Task(joint, LinkLoads.of(sized, k, q, tilt), limits)
            ratios = task.taken(joint.elastic_link, task.loads)
            for measure in range(2):
                if ratios[:, measure].max() < 1 / 2:
                    continue
                for start in np.argsort(-ratios[:, measure], kind="stable")[:_SHARPENED]:
                    at, share = _climbed(sized, k, q[start], limits, tilt, measure)
                    if share > max(1.0, float(ratios[:, measure].max())) * (1 + _WORSE):
                        found.append(at)
    return np.array(found).reshape(-1, q.shape[1])


def _climbed(arm: Arm, k: int, start: Floats, limits: Limits, tilt: float | None, measure: int) -> tuple[Floats, float]:
    """From a pose, which one nearby bends a link most, within the joints' limits, and by how much of its limit?"""
    from scipy.optimize import minimize

    joint = arm.joints[k]
    low, high = arm.limits.T
    width = high - low
    nudge = 1e-6

    def share(at: Floats) -> Floats:
        task = Task(joint, LinkLoads.of(arm, k, np.clip(low + at * width, low, high), tilt), limits)
        return np.asarray(task.taken(joint.elastic_link, task.loads)[:, measure])

    def less(at: Floats) -> tuple[float, Floats]:
        steps = nudge * np.eye(len(at))
        values = share(np.vstack([at, at + steps, at - steps]))
        inside = np.minimum(at + nudge, 1) - np.maximum(at - nudge, 0)
        return -float(values[0]), -(values[1 : 1 + len(at)] - values[1 + len(at) :]) / inside

    best = minimize(less, (start - low) / width, jac=True, bounds=[(0, 1)] * len(low), method="L-BFGS-B", options={"maxiter": 40})
    return np.clip(low + best.x * width, low, high), -float(best.fun)


def _told(arm: Arm, sized: Arm, name: str, limits: Limits, q: Floats, tilt: float | None, names: list[str]) -> LinkSize:
    k = _index(arm, name)
    stated, joint = arm.joints[k], sized.joints[k]
    loads = LinkLoads.of(sized, k, q, tilt)
    link = joint.elastic_link
    worst = loads.worst(link)
    before = None if stated.link.is_rigid else LinkLoads.of(arm, k, q, tilt).worst(stated.elastic_link)
    length = joint.link.reach
    allowed = limits.slope, length / limits.deflection
    binds = int(worst.deflection / allowed[1] > worst.slope / allowed[0])
    index = worst.deflection_index if binds else worst.slope_index
    gravity = loads.worst_gravity(link, index, binds)
    felt = loads.felt(index, gravity)
    moment, force, own = (float(np.linalg.norm(across(link) @ each)) for each in (felt[:3], felt[3:6], joint.link.total_mass * felt[6:]))
    return LinkSize(
        joint=name,
        length=length,
        before=stated.link.section,
        section=joint.link.section,  # type: ignore[arg-type]  # it was chosen from plain ones
        mass_before=stated.link.total_mass,
        mass=joint.link.total_mass,
        worst=worst,
        worst_before=before,
        limits=allowed,
        holds=worst.slope <= allowed[0] * (1 + _WORSE) and worst.deflection <= allowed[1] * (1 + _WORSE),
        force=force,
        moment=moment,
        own=own,
        relieved_by=_relieved(sized, k, q[[index]], gravity, binds, names),
    )


def _relieved(arm: Arm, k: int, q: Floats, gravity: Floats, measure: int, names: list[str]) -> tuple[str, ...]:
    """Which sized links outboard bend this one, by their weight, against its whole bending at this pose?"""
    link = arm.joints[k].elastic_link
    carried = arm.tree.outboard(arm.tree.joints[k].tip)

    def bends(some: Arm) -> Floats:
        loads = LinkLoads.of(some, k, q, math.pi)
        return bending_under(link, loads.felt(0, gravity), measure)

    whole = bends(arm)
    out = []
    for name in names:
        at = _index(arm, name)
        if arm.tree.joints[at].seat in carried:
            joint = arm.joints[at]
            weightless = joint.model_copy(update={"link": joint.link.model_copy(update={"mass": 0.0})})
            without = arm.model_copy(update={"joints": (*arm.joints[:at], weightless, *arm.joints[at + 1 :])})
            part = whole - bends(without)
            if part @ whole < -SLACK * (whole @ whole):
                out.append(name)
    return tuple(out)
