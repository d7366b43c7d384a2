"""An arm whose parts were chosen for a target on the tool: the search at a few poses, and a full study of what it found.

The search sums up mean and covariance of the error and takes it for normal, at fewer poses than the study. What the study then says beyond that goes
into the target that the search is given, once more, until the study's own 95 % error holds the target with the upper end of its interval.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.analyses.sizing.search import LEVEL, Choice, Rules, Search
from lostmotion.error_model.intervals import Estimate, pooled_quantile
from lostmotion.propagation.montecarlo import kernel
from lostmotion.propagation.montecarlo.common_random_numbers import thinned
from lostmotion.propagation.montecarlo.montecarlo import run
from lostmotion.propagation.montecarlo.sensitivity import halving

if TYPE_CHECKING:
    from collections.abc import Callable

    from lostmotion.analyses.sizing.candidates import Candidate, Slot, Worth
    from lostmotion.error_model.budget import Halving
    from lostmotion.error_model.poses import Poses
    from lostmotion.mechanism.arm import Arm

# The other targets of the trade-off, as shares of the one asked for, strict to loose.
SCALES: Final = (0.8, 0.9, 1.1, 1.25, 1.5)
# Full studies at most; a search that was given no less than the target over this is not given a looser one.
_TURNS: Final = 5
_SPARE: Final = 1.003
_AIM: Final = 0.999
# The smaller study of one part put back, and of other targets.
_POSES: Final = 1024
_ROBOTS: Final = 512
_VISITS: Final = 4


@dataclass(frozen=True, slots=True)
class Counts:
    """How large a study is: robots built and visits of each to each pose, from a seed, on so many threads."""

    robots: int = 1000
    visits: int = 30
    seed: int = 1
    threads: int = 1


@dataclass(frozen=True, slots=True)
class Bought:
    """One part as chosen, and what it buys: the cheapest way to make it, what that saves, and the 95 % error (m) that it would leave."""

    slot: Slot
    chosen: Candidate
    cheapest: Candidate
    saved: float
    without: Estimate | None


@dataclass(frozen=True, slots=True)
class Point:
    """One point of the trade-off: the target (m), what the allocation found for it costs, weighs (kg) and errs (m), whether the search held it."""

    target: float
    cost: float
    mass: float
    price: float
    error: Estimate
    holds: bool


@dataclass(frozen=True, repr=False)
class Aimed:
    """An arm whose parts were chosen for a target on the tool.

    arm, sized        as stated, and with the parts chosen
    poses             of the study; `searched` of the search
    error_before, error  the 95 % error by a full study each, m
    inner             the targets that the search was given, one after the other (m): what the study said beyond the search went into the next
    proven            all cheaper allocations were looked at, else no exchange of one or two parts was found cheaper
    looked_at, foreseen  allocations that were, and pairs whose error was foreseen only
    trade             other targets, strict to loose, the one asked for among them (out of reach: what was reached); one part exchanged at a time
    halving           what halving the errors of any part of the sized arm would buy
    torques           by joint, the most that a joint with a gearbox to choose holds, N m, over the poses of the search and the corners of the ranges
    small             (poses, robots, visits) of the smaller studies in `trade` and `bought`
    """

    arm: Arm
    sized: Arm
    target: float
    worth: Worth
    rules: Rules
    poses: Poses
    searched: int
    counts: Counts
    bought: tuple[Bought, ...]
    mass: float
    price: float
    mass_before: float
    price_before: float
    error_before: Estimate
    error: Estimate
    inner: tuple[float, ...]
    allowed: bool
    proven: bool
    allocations: int
    looked_at: int
    foreseen: int
    trade: tuple[Point, ...]
    halving: Halving
    torques: dict[str, float]
    small: tuple[int, int, int]

    @property
    def holds(self) -> bool:
        """Tell whether the study's 95 % error is within the target with the upper end of its interval, and all parts are allowed."""
        return self.allowed and self.error.high <= self.target


def aim(  # noqa: PLR0913 - a search is these
    arm: Arm,
    slots: tuple[Slot, ...],
    worth: Worth,
    target: float,
    searched: Poses,
    poses: Poses,
    *,
    rules: Rules | None = None,
    counts: Counts | None = None,
    progress: Callable[[str, int, int], None] | None = None,
) -> Aimed:
    """Which parts hold the target (m) on the tool at the least cost, and what do they buy?

    The target is the 95 % error over all `poses`, robots and visits. `searched` are the poses of the search. Where nothing reaches the target:
    the allocation that comes nearest (`Aimed.holds`).
    """
    size, allowed = counts or Counts(), rules or Rules()
    stages = _TURNS + len(SCALES) + 3
    stage = 0

    def tell() -> None:
        if progress is not None:
            progress(f"choosing parts, {len(search.looks)} allocations", stage, stages)

    search = Search(arm, slots, worth, searched.q, allowed, tell)
    before = _studied(arm, poses, size)
    choice, proven, inner, tried = search.solve(target, pairs=False), False, target, list[float]()
    best: tuple[Choice, bool, Estimate] | None = None
    for turn in range(1, _TURNS):
        error = _studied(search.made(choice), poses, size)
        held = search.look(choice).exceeded <= 0 and error.high <= target
        if tried and (best is None or (held, -search.look(choice).cost if held else -error.high) > _rank(search, best, target)):
            best = choice, proven, error
        # So much more than the search the study says.
        told = _AIM * target * (search.error(choice) / error.high if error.high > 0 and search.error(choice) > 0 else 1.0)
        if tried and ((held and told <= inner * _SPARE) or not search.holds(choice, inner)):
            break
        stage = turn
        inner = told if not tried or held else min(told, _AIM * inner)
        tried.append(inner)
        choice, proven = _chosen(search, inner, () if best is None else (best[0],))
    if best is None:
        raise ValueError("no allocation was studied")
    choice, proven, error = best
    stage = _TURNS + 1
    # Where the target is out of reach, the others are around what is within it.
    middle = target if search.look(choice).exceeded <= 0 and error.high <= target else error.high
    trade = _trade(search, choice, middle, middle * search.error(choice) / error.high if error.high > 0 else middle, poses, size, tell)
    stage = stages - 1
    tell()
    bought = tuple(_bought(search, choice, k, poses, size) for k in range(len(search.slots)))
    sized = search.made(choice)
    look = search.look(choice)
    some = thinned(poses, _POSES)
    return Aimed(
        arm=arm,
        sized=sized,
        target=target,
        worth=worth,
        rules=allowed,
        poses=poses,
        searched=len(searched),
        counts=size,
        bought=bought,
        mass=look.mass,
        price=look.price,
        mass_before=sum(slot.present.mass for slot in slots),
        price_before=sum(slot.present.price for slot in slots),
        error_before=before,
        error=error,
        inner=tuple(tried),
        allowed=look.exceeded <= 0,
        proven=proven,
        allocations=math.prod(len(slot.candidates) for slot in search.slots),
        looked_at=len(search.looks),
        foreseen=search.foreseen,
        trade=trade,
        halving=halving(sized, poses, size.robots, size.visits, size.seed),
        torques={
            joint.name: float(torque)
            for joint, torque in zip(sized.moving, search.torques(sized), strict=True)
            if any(slot.joint == joint.name and slot.what == "gearbox" for slot in slots)
        },
        small=(len(some), min(size.robots, _ROBOTS), min(size.visits, _VISITS)),
    )


def _rank(search: Search, best: tuple[Choice, bool, Estimate], target: float) -> tuple[bool, float]:
    """Give how good an allocation is: within the target the cheaper, else the more accurate."""
    held = search.look(best[0]).exceeded <= 0 and best[2].high <= target
    return held, -search.look(best[0]).cost if held else -best[2].high


def _chosen(search: Search, inner: float, starts: tuple[Choice, ...]) -> tuple[Choice, bool]:
    choice = search.solve(inner, starts)
    if not search.holds(choice, inner):
        return choice, False
    return search.prove(inner, search.refine(inner, choice))


def _studied(arm: Arm, poses: Poses, counts: Counts) -> Estimate:
    """Which 95 % error has this arm, by the study?"""
    sampled = run(arm, poses, counts.robots, counts.visits, counts.seed, threads=counts.threads)
    largest = float(sampled.per_pose[:, kernel.LARGEST].max())
    return pooled_quantile(sampled.group_hist, sampled.replicate_hist, LEVEL, largest)


def _roughly(search: Search, choice: Choice, poses: Poses, counts: Counts) -> Estimate:
    """Which 95 % error has an allocation, by a smaller study?"""
    few = Counts(min(counts.robots, _ROBOTS), min(counts.visits, _VISITS), counts.seed, counts.threads)
    return _studied(search.made(choice), thinned(poses, _POSES), few)


def _trade(search: Search, choice: Choice, target: float, inner: float, poses: Poses, counts: Counts, tell: Callable[[], None]) -> tuple[Point, ...]:
    """What would other targets cost? From the one asked for on to both sides, each from the one next to it and from the cheapest."""
    points: dict[float, Choice] = {1.0: choice}
    for scales in ([scale for scale in SCALES if scale > 1], [scale for scale in reversed(SCALES) if scale < 1]):
        here = choice
        for scale in scales:
            tell()
            found = [each for start in (here, search.cheapest()) if search.holds(each := search.near(scale * inner, start), scale * inner)]
            # Out of reach from both: perhaps not from the most accurate.
            here = min(found, key=lambda each: search.look(each).cost) if found else search.solve(scale * inner, (here,), pairs=False)
            points[scale] = here
    out = []
    for scale, each in sorted(points.items()):
        look = search.look(each)
        holds = look.exceeded <= 0 and (scale == 1 or search.holds(each, scale * inner))
        out.append(Point(scale * target, look.cost, look.mass, look.price, _roughly(search, each, poses, counts), holds))
    return tuple(out)


def _bought(search: Search, choice: Choice, k: int, poses: Poses, counts: Counts) -> Bought:
    slot = search.slots[k]
    costs = np.array([search.worth.of(each.mass, each.price) for each in slot.candidates])
    least = int(costs.argmin())
    saved = float(costs[choice[k]] - costs[least])
    without = None
    if saved > 0:
        without = _roughly(search, (*choice[:k], least, *choice[k + 1 :]), poses, counts)
    return Bought(slot, slot.candidates[choice[k]], slot.candidates[least], saved, without)
