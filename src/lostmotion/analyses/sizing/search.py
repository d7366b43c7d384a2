"""Which of the allowed parts make an arm hold a target on the tool at the least cost? A search over links, gearboxes and clearances.

Every allocation looked at is the real arm at the real poses: its loads are walked anew and every part answers to its own, so a heavier part outboard
costs all parts inboard what it does. Nothing is fitted. A gearbox whose rated torque is below what its joint holds is not admitted.

The search climbs from the cheapest allocation (best fall of the mean square per cost), descends from the most accurate one (best saving per rise),
and then exchanges one or two parts until no exchange is cheaper and within the target. Which pairs are tried is foreseen from what both exchanges do
one by one; the arm itself decides. Where few allocations are cheaper than the one found, all are looked at, and it is the cheapest of all.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.analyses.sizing.candidates import finer
from lostmotion.analyses.sizing.error_cache import BIAS, Ledger, error_at, mean_square, share_within
from lostmotion.analyses.sizing.lazy_greedy import Stale, Swap
from lostmotion.analyses.sizing.lightest import Task
from lostmotion.analyses.sizing.link_deflection import LinkLoads
from lostmotion.analyses.sizing.sizing import corners
from lostmotion.errors import LostmotionError
from lostmotion.mechanism.serial import joint_torques, worst_torques_over_tilts

if TYPE_CHECKING:
    from collections.abc import Callable

    from lostmotion.analyses.sizing.candidates import Candidate, Slot, Worth
    from lostmotion.analyses.sizing.lightest import Limits
    from lostmotion.mechanism.arm import Arm
    from lostmotion.parts.joint import Joint
    from lostmotion.spatial import Floats

LEVEL: Final = 0.95
Choice = tuple[int, ...]
# A pair of exchanges is tried where both one by one foresee an error of at most so many times the target.
_FORESEEN: Final = 1.02
# A pair is not foreseen further where its 95 % error would have to be less than this share of as many r.m.s. errors as it is before.
_FEWEST: Final = 0.92
# All allocations that are cheaper are looked at where they are no more than this.
MOST_PROVEN: Final = 300
_MOST_CORNERS: Final = 256
_EQUAL: Final = 1e-9
_BETTER: Final = 1e-4
_ROUNDS: Final = 100
_FINER: Final = 3


@dataclass(frozen=True, slots=True)
class Look:
    """What one allocation comes to: cost, mass (kg) and price of the chosen parts, r.m.s. error (m), by how much torques and limits are exceeded.

    `exceeded` is a sum of logarithms of what is asked over what is allowed, 0 where all is.
    """

    cost: float
    mass: float
    price: float
    rms: float
    exceeded: float


@dataclass(frozen=True, slots=True)
class Rules:
    """What is allowed besides the target: limits on each chosen link (None: none), and how far the base may lean (rad; None: as it stands)."""

    limits: Limits | None = None
    tilt: float | None = None


class Search:
    """The allocations of one arm at some poses; each is looked at once.

    `looks` holds every allocation looked at, `foreseen` counts the pairs whose error was foreseen and not looked at further.
    """

    def __init__(self, arm: Arm, slots: tuple[Slot, ...], worth: Worth, q: Floats, rules: Rules, tell: Callable[[], None] = lambda: None) -> None:
        """Begin with the candidates of the slots; `refine` adds others. `tell` is called at every allocation looked at."""
        self.arm, self.slots, self.worth, self.rules, self.tell = arm, slots, worth, rules, tell
        self.ledger = Ledger(arm, q)
        self.worst_q = np.vstack([q, corners(arm, _MOST_CORNERS)])
        self.looks: dict[Choice, Look] = {}
        self.foreseen = 0
        self._errors: dict[Choice, float] = {}
        self._joints: dict[tuple[tuple[int, int], ...], Joint] = {}
        self._torques: dict[tuple[tuple[float, ...], ...], Floats] = {}
        self._bent: dict[tuple[object, ...], float] = {}

    # ---- one allocation

    def parts(self, choice: Choice) -> tuple[Candidate, ...]:
        """Give the candidates chosen."""
        return tuple(slot.candidates[k] for slot, k in zip(self.slots, choice, strict=True))

    def made(self, choice: Choice) -> Arm:
        """Give the arm with these parts. The same joint with the same parts is the same object, so that what it adds is known."""
        joints = []
        for joint in self.arm.joints:
            mine = tuple((k, choice[k]) for k, slot in enumerate(self.slots) if slot.joint == joint.name)
            if mine and mine not in self._joints:
                made = joint
                for k, index in mine:
                    made = self.slots[k].put(made, self.slots[k].candidates[index])
                self._joints[mine] = made
            joints.append(self._joints[mine] if mine else joint)
        return self.arm.model_copy(update={"joints": tuple(joints)})

    def look(self, choice: Choice) -> Look:
        """What does this allocation come to? One in which a part has no answer errs without bounds."""
        found = self.looks.get(choice)
        if found is None:
            parts = self.parts(choice)
            mass, price = sum(each.mass for each in parts), sum(each.price for each in parts)
            try:
                arm = self.made(choice)
                rms = math.sqrt(mean_square(self.ledger.of(arm)))
                exceeded = self._exceeded(arm, choice)
            except LostmotionError:
                rms = exceeded = math.inf
            found = self.looks[choice] = Look(sum(map(self._cost, parts)), mass, price, rms, exceeded)
            self.tell()
        return found

    def error(self, choice: Choice) -> float:
        """Which 95 % error (m) has this allocation?"""
        if choice not in self._errors:
            rms = self.look(choice).rms
            found = error_at(self.ledger.of(self.made(choice)), LEVEL) if math.isfinite(rms) else math.inf
            self._errors[choice] = found
        return self._errors[choice]

    def holds(self, choice: Choice, target: float) -> bool:
        """Tell whether an allocation is within a target (m), and all in it is allowed."""
        return self.look(choice).exceeded <= 0 and self.error(choice) <= target

    def _misses(self, look: Look) -> tuple[float, float]:
        return look.exceeded, look.rms

    def _cost(self, candidate: Candidate) -> float:
        return self.worth.of(candidate.mass, candidate.price)

    def _exceeded(self, arm: Arm, choice: Choice) -> float:
        return self._torque_exceeded(arm) + (self._limits_exceeded(arm, choice, self.rules.limits) if self.rules.limits is not None else 0.0)

    def torques(self, arm: Arm) -> Floats:
        """What must each moving joint hold at worst (joint,), N m or N, over the poses and the corners of the joints' ranges?"""
        key = _weights(arm)
        if key not in self._torques:
            if self.rules.tilt is None:
                held = np.abs(joint_torques(arm, self.worst_q))
            else:
                held = worst_torques_over_tilts(arm, self.worst_q, within=self.rules.tilt)
            self._torques[key] = held.max(axis=0)
        return self._torques[key]

    def _torque_exceeded(self, arm: Arm) -> float:
        chosen = {slot.joint for slot in self.slots if slot.what == "gearbox"}
        out = 0.0
        for joint, torque in zip(arm.moving, self.torques(arm) if chosen else (), strict=bool(chosen)):
            rated = joint.gearbox.rated_torque if joint.gearbox is not None else None
            if joint.name in chosen and rated is not None and torque > rated * (1 + _EQUAL):
                out += math.log(torque / rated) if rated > 0 else math.inf
        return out

    def _limits_exceeded(self, arm: Arm, choice: Choice, limits: Limits) -> float:
        out = 0.0
        weights = _weights(arm)
        for k, slot in enumerate(self.slots):
            if slot.what == "link":
                at = next(n for n, joint in enumerate(arm.joints) if joint.name == slot.joint)
                carried = arm.tree.outboard(arm.tree.joints[at].tip)
                key = (k, choice[k], tuple(weight for weight, places in zip(weights, arm.tree.joints, strict=True) if places.seat in carried))
                if key not in self._bent:
                    joint = arm.joints[at]
                    task = Task(joint, LinkLoads.of(arm, at, self.worst_q, self.rules.tilt), limits)
                    self._bent[key] = 0.0 if joint.link.is_rigid else float(task.taken(joint.elastic_link, task.loads).max())
                out += math.log(self._bent[key]) if self._bent[key] > 1 + _EQUAL else 0.0
        return out

    # ---- the search

    def solve(self, target: float, starts: tuple[Choice, ...] = (), *, pairs: bool = True) -> Choice:
        """Which allocation is the cheapest that was found within the target? Where there is none: the one that errs least of those allowed.

        starts  allocations to begin from besides; pairs: whether two parts are exchanged together too
        """
        climbed = self.climb(target)
        tried = list(dict.fromkeys([climbed, self.most_accurate(climbed), *starts]))
        within = [each for each in tried if self.holds(each, target)]
        if not within:
            return min(tried, key=lambda each: (self.look(each).exceeded, self.error(each)))
        begun = min((self.descend(target, each) for each in within), key=lambda each: (self.look(each).cost, self.error(each), each))
        return self.exchange(target, begun, pairs=pairs)

    def near(self, target: float, start: Choice) -> Choice:
        """Which allocation does one come to from this one, up until the target holds and down as far as it does?"""
        climbed = self.climb(target, start)
        return self.exchange(target, self.descend(target, climbed), pairs=False) if self.holds(climbed, target) else climbed

    def cheapest(self) -> Choice:
        """Which allocation costs least, whatever it does?"""
        return tuple(min(range(len(slot.candidates)), key=lambda k, slot=slot: self._cost(slot.candidates[k])) for slot in self.slots)  # type: ignore[misc]

    def climb(self, target: float, start: Choice | None = None) -> Choice:
        """From the cheapest allocation up: exchange the part that does most per cost, until the target is met or nothing helps."""
        now = self.cheapest() if start is None else start
        stale = Stale()
        for _ in range(_ROUNDS):
            if self.holds(now, target):
                break
            here = self.look(now)
            stale.of_phase(here.exceeded > 0)

            def rank(swap: Swap, now: Choice = now, here: Look = here) -> float:
                found = self.look(_exchanged(now, *swap))
                # What is not allowed goes before what errs.
                gain = here.exceeded - found.exceeded if here.exceeded > 0 else _log_ratio(here.rms, found.rms) if found.exceeded <= 0 else 0.0
                more = found.cost - here.cost
                return 0.0 if not gain > _EQUAL else gain / more if more > 0 else math.inf

            best = stale.best(self._swaps(now), rank)
            if best is None:
                break
            now = _exchanged(now, *best)
        return now

    def most_accurate(self, start: Choice) -> Choice:
        """Which allocation errs least, of those allowed? By exchange of one part after the other, until none helps."""
        now = start
        for _ in range(_ROUNDS):
            before = now
            for k, slot in enumerate(self.slots):
                others = [_exchanged(now, k, index) for index in range(len(slot.candidates))]
                least = min(others, key=lambda each: self._misses(self.look(each)))
                if self._misses(self.look(least)) < self._misses(self.look(now)):
                    now = least
            if now == before:
                break
        return now

    def descend(self, target: float, start: Choice) -> Choice:
        """From an allocation within the target down: exchange the part that saves most per rise of the error, as long as the target holds."""
        now = start
        stale = Stale()
        for _ in range(_ROUNDS):
            here = self.look(now)

            def rank(swap: Swap, now: Choice = now, here: Look = here) -> float:
                other = _exchanged(now, *swap)
                saved = here.cost - self._cost_of(other)
                if not (saved > _EQUAL * abs(here.cost) and self.holds(other, target)):
                    return 0.0
                rise = _log_ratio(self.look(other).rms, here.rms)
                return saved / rise if rise > 0 else math.inf

            best = stale.best(self._swaps(now), rank)
            if best is None:
                break
            now = _exchanged(now, *best)
        return now

    def exchange(self, target: float, start: Choice, *, pairs: bool = True) -> Choice:
        """Exchange one or two parts as long as that is cheaper and within the target (or as cheap and more accurate)."""
        now = start
        for _ in range(_ROUNDS):
            better = self._better_by_one(target, now) or (self._better_by_two(target, now) if pairs else None)
            if better is None:
                break
            now = better
        return now

    def _better_by_one(self, target: float, now: Choice) -> Choice | None:
        limit, slack = self.look(now).cost, _EQUAL * abs(self.look(now).cost)
        for cost, other in sorted((self._cost_of(other), other) for other in (_exchanged(now, *swap) for swap in self._swaps(now))):
            if cost > limit + slack:
                break
            if self.holds(other, target) and (cost < limit - slack or self.error(other) < self.error(now) * (1 - _BETTER)):
                return other
        return None

    def _better_by_two(self, target: float, now: Choice) -> Choice | None:
        """Try the pairs that are cheaper, the cheapest first, where both exchanges one by one foresee that the target may hold."""
        limit = self.look(now).cost * (1 - _EQUAL)
        base = self.ledger.of(self.made(now))
        changes = {}
        for swap in self._swaps(now):
            try:
                changes[swap] = self.ledger.of(self.made(_exchanged(now, *swap))) - base
            except LostmotionError:
                continue
        if not changes:
            return None
        swaps = list(changes)
        more = np.array([self._cost_of(_exchanged(now, *swap)) for swap in swaps]) - self.look(now).cost
        rms = _foreseen_rms(base, np.array(list(changes.values())))
        slots = np.array([k for k, _ in swaps])
        may = (slots[:, None] < slots) & (self.look(now).cost + more[:, None] + more < limit)
        # The r.m.s. error that goes with the target here, and some more: elsewhere it may go with others.
        may &= rms * self.error(now) * _FEWEST <= _FORESEEN * target * self.look(now).rms
        pairs = np.argwhere(may)
        for i, j in pairs[np.argsort((more[:, None] + more)[may], kind="stable")]:
            self.foreseen += 1
            share = share_within(base + changes[swaps[i]] + changes[swaps[j]], _FORESEEN * target)
            both = _exchanged(_exchanged(now, *swaps[i]), *swaps[j])
            if not share < LEVEL and self.holds(both, target):  # what cannot be foreseen is tried
                return both
        return None

    def _swaps(self, choice: Choice) -> list[Swap]:
        """Give all exchanges of one part: the slot, and the candidate to come."""
        return [(k, index) for k, slot in enumerate(self.slots) for index in range(len(slot.candidates)) if index != choice[k]]

    def _cost_of(self, choice: Choice) -> float:
        return sum(map(self._cost, self.parts(choice)))

    def refine(self, target: float, choice: Choice) -> Choice:
        """Try sections of the links' families between those of the grid, nearer and nearer to the ones chosen."""
        now = choice
        ratios = [math.sqrt(slot.spacing) for slot in self.slots]
        joints = {joint.name: joint for joint in self.arm.joints}
        for _ in range(_FINER):
            slots = []
            for slot, index, ratio in zip(self.slots, now, ratios, strict=True):
                more = finer(joints[slot.joint], slot, slot.candidates[index], ratio)
                slots.append(replace(slot, candidates=(*slot.candidates, *more)) if more else slot)
            self.slots = tuple(slots)
            ratios = [math.sqrt(ratio) for ratio in ratios]
            now = self.exchange(target, now, pairs=False)
        return self.exchange(target, now)

    def prove(self, target: float, choice: Choice, most: int = MOST_PROVEN) -> tuple[Choice, bool]:
        """Is any allocation within the target cheaper? The cheapest, and whether that is sure: all cheaper ones, at most so many, were looked at."""
        cheaper = self._cheaper(self.look(choice).cost * (1 - _EQUAL), most)
        if cheaper is None:
            return choice, False
        return next((other for _, other in sorted(cheaper) if self.holds(other, target)), choice), True

    def _cheaper(self, limit: float, most: int) -> list[tuple[float, Choice]] | None:
        """Give all allocations that cost less, or None where they are too many."""
        costs = [[self._cost(each) for each in slot.candidates] for slot in self.slots]
        least = np.cumsum([0.0, *(min(row) for row in reversed(costs))])[::-1]
        out: list[tuple[float, Choice]] = []
        waiting: list[tuple[float, Choice]] = [(0.0, ())]
        while waiting:
            cost, head = waiting.pop()
            if len(head) == len(costs):
                out.append((cost, head))
                if len(out) > most:
                    return None
                continue
            for index, more in enumerate(costs[len(head)]):
                if cost + more + float(least[len(head) + 1]) < limit:
                    waiting.append((cost + more, (*head, index)))
        return out


def _foreseen_rms(base: Floats, changes: Floats) -> Floats:
    """Which r.m.s. errors (swap, swap) follow from sums (ROWS, pose) when two of these changes (swap, ROWS, pose) come together?"""
    poses = base.shape[1]
    bias, start = changes[:, BIAS].reshape(len(changes), -1), base[BIAS].ravel()
    alone = 2 * bias @ start + np.einsum("nc,nc->n", bias, bias) + changes[:, 3:6].sum(axis=(1, 2))
    whole = mean_square(base) + (alone[:, None] + alone + 2 * bias @ bias.T) / poses
    return np.asarray(np.sqrt(np.maximum(whole, 0.0)))


def _log_ratio(first: float, second: float) -> float:
    if first == second:
        return 0.0
    return (
        math.log(first / second)
        if first > 0 and second > 0 and math.isfinite(first) and math.isfinite(second)
        else math.inf
        if first > second
        else -math.inf
    )


def _weights(arm: Arm) -> tuple[tuple[float, ...], ...]:
    """Return for each joint the weights that an allocation may change: of the joint and of its link, and where the link's mass is."""
    return tuple((joint.total_mass, joint.link.total_mass, *(float(x) for x in joint.link.mass_centre)) for joint in arm.joints)


def _exchanged(choice: Choice, k: int, index: int) -> Choice:
    return (*choice[:k], index, *choice[k + 1 :])
