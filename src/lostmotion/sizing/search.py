"""Search for the cheapest parts of an arm that meet a target on the tool: sections of links,
gearboxes and bearing clearances.

The search climbs from the cheapest selection (largest fall of the mean square per cost), descends
from the most accurate one (largest saving per rise of the error), and then exchanges one or two
parts while that is cheaper and within the target. The error of a pair of exchanges is predicted
from those of the single exchanges; only promising pairs are evaluated. Where few selections are
cheaper than the result, all of them are evaluated, which proves that it is optimal.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.errors import LostmotionError
from lostmotion.sizing.candidates import refined_candidates
from lostmotion.sizing.error_cache import BIAS, mean_square, share_within
from lostmotion.sizing.evaluation import EQUAL, LEVEL, Choice, Constraints, Evaluation, Evaluator

if TYPE_CHECKING:
    from collections.abc import Callable

    from lostmotion.mechanism.arm import Arm
    from lostmotion.sizing.candidates import Objective, Slot
    from lostmotion.sizing.error_cache import TargetOf
    from lostmotion.spatial import Floats

# A pair of exchanges is evaluated where the predicted error is at most this multiple of the target.
_PREDICTED: Final = 1.02
# A pair is not predicted further where its 95 % error would have to fall below this share of the
# present ratio to the r.m.s. error.
_LEAST_RATIO: Final = 0.92
# All cheaper selections are evaluated where they are no more than this.
MOST_PROVEN: Final = 300
# Relative fall of the error that counts as more accurate.
_BETTER: Final = 1e-4
_ROUNDS: Final = 100
_REFINEMENTS: Final = 3


# The number of the slot, and that of the candidate to install.
Swap = tuple[int, int]


class LazyGreedy:
    """Lazy greedy selection of the best exchange: only swaps whose last known rank exceeds the best
    new rank are ranked again (M. Minoux, Lecture Notes in Control and Information Sciences 7 (1978)
    234).
    """

    def __init__(self) -> None:
        """Begin without ranks."""
        self._ranks: dict[Swap, float] = {}
        self._phase = False

    def set_phase(self, phase: bool) -> None:  # noqa: FBT001 - one of two
        """Clear all ranks when the criterion changes."""
        if phase != self._phase:
            self._phase = phase
            self._ranks.clear()

    def best(self, swaps: list[Swap], rank: Callable[[Swap], float]) -> Swap | None:
        """Return the swap of the highest rank; None where all ranks are zero."""
        best, highest = None, 0.0
        for swap in sorted(swaps, key=lambda each: (-self._ranks.get(each, math.inf), each)):
            if best is not None and self._ranks.get(swap, math.inf) < highest:
                break
            self._ranks[swap] = rank(swap)
            if self._ranks[swap] > highest:
                best, highest = swap, self._ranks[swap]
        return best


class Search:
    """Search strategies over the selections of one arm; `predicted` counts the pairs of exchanges
    whose error was predicted.
    """

    def __init__(
        self,
        arm: Arm,
        slots: tuple[Slot, ...],
        objective: Objective,
        q: Floats,
        constraints: Constraints,
        on_evaluation: Callable[[], None] = lambda: None,
        of: TargetOf = "error",
    ) -> None:
        """Begin with the candidates of the slots; `refine` adds others. `on_evaluation` is called
        at every new evaluation.
        """
        self.evaluator = Evaluator(arm, slots, objective, q, constraints, on_evaluation, of)
        self.evaluate, self.error, self.meets = (
            self.evaluator.evaluate,
            self.evaluator.error,
            self.evaluator.meets,
        )
        self.predicted = 0

    @property
    def slots(self) -> tuple[Slot, ...]:
        """Return the slots with their candidates."""
        return self.evaluator.slots

    def solve(
        self, target: float, starts: tuple[Choice, ...] = (), *, pairs: bool = True
    ) -> Choice:
        """Return the cheapest selection found within the target (m), else the one of least
        violation and error.

        starts  further selections to begin from; pairs: whether two parts are exchanged together as
                well
        """
        climbed = self.climb(target)
        tried = list(dict.fromkeys([climbed, self.most_accurate(climbed), *starts]))
        within = [each for each in tried if self.meets(each, target)]
        if not within:
            return min(tried, key=lambda each: (self.evaluate(each).violation, self.error(each)))
        begun = min(
            (self.descend(target, each) for each in within),
            key=lambda each: (self.evaluate(each).cost, self.error(each), each),
        )
        return self.exchange(target, begun, pairs=pairs)

    def near(self, target: float, start: Choice) -> Choice:
        """Return a selection reached from this one: climbing until the target is met, then
        descending and exchanging single parts.
        """
        climbed = self.climb(target, start)
        return (
            self.exchange(target, self.descend(target, climbed), pairs=False)
            if self.meets(climbed, target)
            else climbed
        )

    def cheapest(self) -> Choice:
        """Return the selection of least cost, regardless of target and constraints."""
        cost = self.evaluator.cost_of_part
        return tuple(
            min(range(len(slot.candidates)), key=lambda k, slot=slot: cost(slot.candidates[k]))  # type: ignore[misc]
            for slot in self.slots
        )

    def climb(self, target: float, start: Choice | None = None) -> Choice:
        """Exchange the part of largest gain per cost, from the cheapest selection on, until the
        target is met or nothing helps.
        """
        now = self.cheapest() if start is None else start
        greedy = LazyGreedy()
        for _ in range(_ROUNDS):
            if self.meets(now, target):
                break
            here = self.evaluate(now)
            greedy.set_phase(here.violation > 0)

            def rank(swap: Swap, now: Choice = now, here: Evaluation = here) -> float:
                other = self.evaluate(_exchanged(now, *swap))
                # Constraints come before the error.
                gain = (
                    here.violation - other.violation
                    if here.violation > 0
                    else _log_ratio(here.rms, other.rms)
                    if other.violation <= 0
                    else 0.0
                )
                more = other.cost - here.cost
                return 0.0 if not gain > EQUAL else gain / more if more > 0 else math.inf

            best = greedy.best(self._swaps(now), rank)
            if best is None:
                break
            now = _exchanged(now, *best)
        return now

    def most_accurate(self, start: Choice) -> Choice:
        """Return the selection of least violation and error, by exchange of one part after the
        other until none helps.
        """

        def badness(choice: Choice) -> tuple[float, float]:
            evaluation = self.evaluate(choice)
            return evaluation.violation, evaluation.rms

        now = start
        for _ in range(_ROUNDS):
            before = now
            for k, slot in enumerate(self.slots):
                least = min(
                    (_exchanged(now, k, index) for index in range(len(slot.candidates))),
                    key=badness,
                )
                if badness(least) < badness(now):
                    now = least
            if now == before:
                break
        return now

    def descend(self, target: float, start: Choice) -> Choice:
        """Exchange the part of largest saving per rise of the error, from a selection within the
        target on, while the target is met.
        """
        now = start
        greedy = LazyGreedy()
        for _ in range(_ROUNDS):
            here = self.evaluate(now)

            def rank(swap: Swap, now: Choice = now, here: Evaluation = here) -> float:
                other = _exchanged(now, *swap)
                saving = here.cost - self.evaluator.cost(other)
                if not (saving > EQUAL * abs(here.cost) and self.meets(other, target)):
                    return 0.0
                rise = _log_ratio(self.evaluate(other).rms, here.rms)
                return saving / rise if rise > 0 else math.inf

            best = greedy.best(self._swaps(now), rank)
            if best is None:
                break
            now = _exchanged(now, *best)
        return now

    def exchange(self, target: float, start: Choice, *, pairs: bool = True) -> Choice:
        """Exchange one or two parts while that is cheaper and within the target, or as cheap and
        more accurate.
        """
        now = start
        for _ in range(_ROUNDS):
            better = self._better_by_one(target, now) or (
                self._better_by_two(target, now) if pairs else None
            )
            if better is None:
                break
            now = better
        return now

    def _better_by_one(self, target: float, now: Choice) -> Choice | None:
        limit, slack = self.evaluate(now).cost, EQUAL * abs(self.evaluate(now).cost)
        for cost, other in sorted(
            (self.evaluator.cost(other), other)
            for other in (_exchanged(now, *swap) for swap in self._swaps(now))
        ):
            if cost > limit + slack:
                break
            if self.meets(other, target) and (
                cost < limit - slack or self.error(other) < self.error(now) * (1 - _BETTER)
            ):
                return other
        return None

    def _better_by_two(self, target: float, now: Choice) -> Choice | None:
        """Return the cheapest pair of exchanges that is within the target, among cheaper pairs
        whose predicted error is near the target.
        """
        here = self.evaluate(now)
        sums_of = self.evaluator.cache.of
        base = sums_of(self.evaluator.arm_with(now))
        changes = {}
        for swap in self._swaps(now):
            try:
                changes[swap] = sums_of(self.evaluator.arm_with(_exchanged(now, *swap))) - base
            except LostmotionError:
                continue
        if not changes:
            return None
        swaps = list(changes)
        more = np.array([self.evaluator.cost(_exchanged(now, *swap)) for swap in swaps]) - here.cost
        rms = _predicted_rms(base, np.array(list(changes.values())))
        slots = np.array([k for k, _ in swaps])
        promising = (slots[:, None] < slots) & (
            here.cost + more[:, None] + more < here.cost * (1 - EQUAL)
        )
        # The r.m.s. error that corresponds to the target here, with a margin because the ratio of
        # the two may change.
        promising &= rms * self.error(now) * _LEAST_RATIO <= _PREDICTED * target * here.rms
        for i, j in np.argwhere(promising)[
            np.argsort((more[:, None] + more)[promising], kind="stable")
        ]:
            self.predicted += 1
            share = share_within(base + changes[swaps[i]] + changes[swaps[j]], _PREDICTED * target)
            both = _exchanged(_exchanged(now, *swaps[i]), *swaps[j])
            if not share < LEVEL and self.meets(both, target):  # a share that is NaN is evaluated
                return both
        return None

    def _swaps(self, choice: Choice) -> list[Swap]:
        return [
            (k, index)
            for k, slot in enumerate(self.slots)
            for index in range(len(slot.candidates))
            if index != choice[k]
        ]

    def refine(self, target: float, choice: Choice) -> Choice:
        """Add sections of the links' families between those of the grid, ever closer to the
        selected ones, and exchange again.
        """
        now = choice
        ratios = [math.sqrt(slot.spacing) for slot in self.slots]
        joints = {joint.name: joint for joint in self.evaluator.arm.joints}
        for _ in range(_REFINEMENTS):
            slots = []
            for slot, index, ratio in zip(self.slots, now, ratios, strict=True):
                more = refined_candidates(joints[slot.joint], slot, slot.candidates[index], ratio)
                slots.append(replace(slot, candidates=(*slot.candidates, *more)) if more else slot)
            self.evaluator.slots = tuple(slots)
            ratios = [math.sqrt(ratio) for ratio in ratios]
            now = self.exchange(target, now, pairs=False)
        return self.exchange(target, now)

    def prove(self, target: float, choice: Choice, most: int = MOST_PROVEN) -> tuple[Choice, bool]:
        """Return the cheapest selection within the target, and whether it is proven: all cheaper
        ones, at most `most`, were evaluated.
        """
        cheaper = self._cheaper(self.evaluate(choice).cost * (1 - EQUAL), most)
        if cheaper is None:
            return choice, False
        return next(
            (other for _, other in sorted(cheaper) if self.meets(other, target)), choice
        ), True

    def _cheaper(self, limit: float, most: int) -> list[tuple[float, Choice]] | None:
        """Return all selections below a cost, or None where they are more than `most`."""
        costs = [
            [self.evaluator.cost_of_part(each) for each in slot.candidates] for slot in self.slots
        ]
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


def _predicted_rms(base: Floats, changes: Floats) -> Floats:
    """Return the r.m.s. errors (swap, swap) if two of these changes (swap, ROWS, pose) add to the
    sums `base` (ROWS, pose).
    """
    poses = base.shape[1]
    bias, start = changes[:, BIAS].reshape(len(changes), -1), base[BIAS].ravel()
    alone = 2 * bias @ start + np.einsum("nc,nc->n", bias, bias) + changes[:, 3:6].sum(axis=(1, 2))
    total = mean_square(base) + (alone[:, None] + alone + 2 * bias @ bias.T) / poses
    return np.asarray(np.sqrt(np.maximum(total, 0.0)))


def _log_ratio(first: float, second: float) -> float:
    if first == second:
        return 0.0
    if first > 0 and second > 0 and math.isfinite(first) and math.isfinite(second):
        return math.log(first / second)
    return math.inf if first > second else -math.inf


def _exchanged(choice: Choice, k: int, index: int) -> Choice:
    return (*choice[:k], index, *choice[k + 1 :])
