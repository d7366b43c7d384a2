"""How good must each part be for the arm to keep a target? From the whole back to the parts: one at a time, and all together.

Every item (`items`) is a factor on its terms. Bias adds up along factors and variances along their squares, so the mean square is a quadratic form in
the factors: equal effects follow from it exactly. Distances that a share of positions stays within, and RP, are roots over the factor (`gauges`).
"""

from __future__ import annotations

import math
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, Literal

import numpy as np

from lostmotion.analyses.targets.allocation import NOTHING, Joint, equal_effect, equal_effect_within, mean_square_form, moving, parts_of
from lostmotion.analyses.targets.metrics import BySamples, ByVisits, Gauge, around, by_montecarlo, root
from lostmotion.analyses.targets.parameters import Item, alike, items
from lostmotion.analyses.targets.yield_ import MOST_ROBOTS, Judged, Yield, check_share, in_blocks, robot_figures, yield_of
from lostmotion.error_model.intervals import Estimate
from lostmotion.error_model.pose_matrix import screws
from lostmotion.errors import refuse_argument
from lostmotion.propagation.montecarlo.blocks import Plan
from lostmotion.propagation.montecarlo.common_random_numbers import scaled

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from numpy.typing import NDArray

    from lostmotion.analyses.targets.metrics import Missed
    from lostmotion.error_model.pose_matrix import Screws
    from lostmotion.error_model.poses import Poses
    from lostmotion.mechanism.arm import Arm
    from lostmotion.spatial import Floats

Kind = Literal["error", "repeatability"]
Verdict = Literal["sized", "usual", "any", "none"]
MOST_POSES: Final = 16_384
# The screws of so many poses x terms are kept, of 100 bytes each.
_MOST_CELLS: Final = 8_000_000
# The interval of a pooled distance counts robots: more visits tell little more.
_ENOUGH_VISITS: Final = 8
# Factors tried, in units of that at which an item alone is as large as target or error: closely where bias may cancel other bias, else a few.
_FINE: Final = (*(k / 16 for k in range(64)), 4.0, 6.0, 12.0, 40.0, 1000.0)
_FEW: Final = (0.0, 0.5, 2.0, 12.0, 1000.0)
# The part of the mean square that each item has is found to this share of itself.
_CLOSE: Final = 1e-4


@dataclass(frozen=True)
class Allowed:
    """How large one item may be, all else as it is.

    verdict   "sized": the factor at which the target is just met; "usual": it is met at every usual size, up to the factor; "any": it is met
              however large the item is; "none": not even without it
    factor    on the item's size (its stiffness: one over it) with its 95 % interval; infinite, NaN
    ranges    of factors that meet the target; more than one, or one that does not begin at zero, where the item cancels others
    without   the error or RP, m, where the item is zero
    verified  the same by Monte Carlo at the factor; None where there is none
    share     of the mean square (of what differs between visits, for repeatability) as things are
    """

    item: Item
    verdict: Verdict
    factor: Estimate
    ranges: tuple[tuple[float, float], ...]
    without: Estimate
    verified: Estimate | None
    share: float


@dataclass(frozen=True, repr=False)
class Targets:
    """What a target asks of every part.

    robots, visits      of the Monte Carlo; verified_visits of the one that verifies sizes
    solved_poses, solved_samples  with which the sizes were solved for; of repeatability the samples are robots x visits x poses
    now, now_by_gauge   error or RP as things are, m: by Monte Carlo, and by the samples with which the factors were solved for
    single, kinds       one item at a time, and one cause in all parts of a kind at a time
    form                (item, item) m^2: factors @ form @ factors is the mean square
    equal_factor, equal_effect  all items together; None where no such sizes exist
    yields              robots that keep the target as things are, by two figures
    """

    arm: Arm
    poses: Poses
    zone: str
    seed: int
    approach: float
    kind: Kind
    target: float
    share: float
    robots: int
    visits: int
    verified_visits: int
    solved_poses: int
    solved_samples: int
    now: Estimate
    now_by_gauge: Estimate
    items: tuple[Item, ...]
    single: tuple[Allowed, ...]
    kinds: tuple[Allowed, ...]
    form: Floats
    equal_factor: Joint | None
    equal_effect: Joint | None
    yields: tuple[Yield, ...]


def targets(  # noqa: PLR0913 - a target is these numbers
    arm: Arm,
    poses: Poses,
    kind: Kind,
    target: float,
    *,
    share: float = 0.95,
    robots: int = 1000,
    visits: int = 30,
    seed: int = 1,
    approach: float = 0.0,
    threads: int = 1,
    zone: str = "",
    progress: Callable[[str, int, int], None] | None = None,
) -> Targets:
    """How large may each item be, so that a share of all positions errs by no more than the target (m), or a share of the robots repeats within it?

    kind     "error": positions of all robots, poses and visits; "repeatability": robots, by their RP averaged over the poses
    robots, visits, seed, approach, threads, progress  of the Monte Carlo that verifies, as `montecarlo.run`
    zone     how the poses' part of the workspace is called; empty for all of it

    First order in the errors; loads and masses stay as they are. Raises InputError for numbers out of range.
    """
    check_target(target, share)
    if not 1 <= len(poses) <= MOST_POSES:
        raise refuse_argument("poses", len(poses), f"from 1 to {MOST_POSES}", "poses = 1024")
    if not 20 <= robots <= MOST_ROBOTS:  # noqa: PLR2004 - 95 % of fewer is all of them
        raise refuse_argument("robots", robots, f"from 20 to {MOST_ROBOTS}", "robots = 1000")
    if visits < 2:  # noqa: PLR2004 - a scatter needs two
        raise refuse_argument("visits", visits, "at least 2", "visits = 30")
    if threads < 1:
        raise refuse_argument("threads", threads, "at least 1", "threads = 2")
    plan = Plan.of(arm, poses, robots, visits, seed, approach)
    matrix = screws(arm, poses.q, approach=approach)
    if len(poses) * len(matrix.infos) > _MOST_CELLS:
        most = _MOST_CELLS // len(matrix.infos)
        raise refuse_argument("poses", len(poses), f"at most {most} with the {len(matrix.infos)} terms of this arm", f"poses = {most // 2}")
    return _Search(plan, matrix, kind, target, share, threads, progress or (lambda *_: None)).found(zone)


def check_target(target: float, share: float) -> None:
    """Refuse a target that is no length, or a share that means nothing; raises InputError."""
    if not (math.isfinite(target) and target > 0):
        raise refuse_argument("target", target, "a length above zero", 'error = "0.5 mm"')
    check_share(share)


class _Search:
    """All that the search for one target shares."""

    def __init__(
        self, plan: Plan, matrix: Screws, kind: Kind, target: float, share: float, threads: int, tell: Callable[[str, int, int], None]
    ) -> None:
        self.plan, self.matrix, self.kind, self.target, self.share, self.threads, self.tell = plan, matrix, kind, target, share, threads, tell
        self.items = items(plan.arm, matrix.infos)
        self.form = mean_square_form(matrix, self.items, visits_only=kind == "repeatability")
        sets = plan.poses.replicates
        of_error = kind == "error"
        self.gauge: Gauge = BySamples(matrix, sets, share, target, plan.seed) if of_error else ByVisits(matrix, sets, share, target, plan)
        self.checked = plan if kind == "repeatability" else Plan.of(plan.arm, plan.poses, plan.robots, _visits(plan), plan.seed, plan.approach)

    def found(self, zone: str) -> Targets:
        """Give the whole answer."""
        plan, ones = self.plan, np.ones(len(self.matrix.infos))
        now_by_gauge = self.gauge.value(ones)
        self.now_size = now_by_gauge.value
        together = alike(self.items)
        both = self._each((*self.items, *together))
        return Targets(
            arm=plan.arm,
            poses=plan.poses,
            zone=zone,
            seed=plan.seed,
            approach=plan.approach,
            kind=self.kind,
            target=self.target,
            share=self.share,
            robots=plan.robots,
            visits=plan.visits,
            verified_visits=self.checked.visits,
            solved_poses=self.gauge.poses,
            solved_samples=self.gauge.samples,
            now=self._verified(ones),
            now_by_gauge=now_by_gauge,
            items=self.items,
            single=tuple(both[: len(self.items)]),
            kinds=tuple(both[len(self.items) :]),
            form=self.form,
            equal_factor=self._together(np.where(moving(self.form), 1.0, np.nan)),
            equal_effect=self._equal_effect(),
            yields=self._yields(ones),
        )

    def _each(self, wanted: Sequence[Item]) -> list[Allowed]:
        out = []
        with ThreadPoolExecutor(self.threads) as pool:
            for done, one in enumerate(pool.map(self._allowed, wanted), 1):
                out.append(one)
                self.tell("sizing each item", done, len(wanted))
        return out

    def _alone(self, item: Item) -> tuple[float, float]:
        """Give the item's r.m.s. error alone, m, and its share of the mean square."""
        members = np.array([bool(set(each.columns) & set(item.columns)) for each in self.items], dtype=float)
        total = float(self.form.sum())
        return math.sqrt(max(float(members @ self.form @ members), 0.0)), float(members @ self.form.sum(axis=1)) / total if total else 0.0

    def _allowed(self, item: Item) -> Allowed:
        alone, share = self._alone(item)
        no = Estimate(math.nan, math.nan, math.nan)
        if alone**2 <= NOTHING * max(float(self.form.sum()), 0.0):
            met = self.now_size <= self.target
            if met:
                return Allowed(item, "any", Estimate(math.inf, math.nan, math.nan), ((0.0, math.inf),), no, None, share)
            return Allowed(item, "none", no, (), self.gauge.value(np.ones(len(self.matrix.infos))), None, share)
        size = max(self.target, self.now_size) / alone
        missed = self.gauge.along(item.columns)
        fine = self.kind == "error" and any(self.matrix.infos[column].level == "design" for column in item.columns)
        ranges = _ranges(missed, size * np.array(_FINE if fine else _FEW), search=fine)
        if not ranges:
            return Allowed(item, "none", no, (), self.gauge.without(item.columns), None, share)
        at = _nearest(ranges)
        if math.isinf(at):
            return Allowed(item, "any", Estimate(math.inf, math.nan, math.nan), ranges, no, None, share)
        if at > item.most and any(low <= 1 and item.most <= high for low, high in ranges):
            return Allowed(item, "usual", Estimate(item.most, math.nan, math.nan), ranges, no, None, share)
        return Allowed(item, "sized", around(missed, at), ranges, no, self._verified(self._factors(item, at)), share)

    def _factors(self, item: Item, factor: float) -> Floats:
        out = np.ones(len(self.matrix.infos))
        out[list(item.columns)] = factor
        return out

    def _verified(self, factors: Floats) -> Estimate:
        """Give the error or RP by Monte Carlo: the study's own draws, all the robots, all the poses."""
        error, repeatability = by_montecarlo(self.checked, scaled(self.matrix, factors), self.share)
        return error if self.kind == "error" else repeatability

    def _yields(self, factors: Floats) -> tuple[Yield, ...]:
        """Count the robots that keep the target with a factor on each term (term,), by the two figures of its kind."""
        figures = robot_figures(self.plan, in_blocks(scaled(self.matrix, factors), self.plan.robots), self.share)
        judged: tuple[Judged, Judged] = ("error", "worst accuracy") if self.kind == "error" else ("repeatability", "worst repeatability")
        return tuple(yield_of(figures, each, self.target) for each in judged)

    def _of_terms(self, factors: Floats) -> Floats:
        """Return the factor on each term (term,) for factors on the items (item,); NaN leaves an item as it is."""
        out = np.ones(len(self.matrix.infos))
        for item, factor in zip(self.items, factors, strict=True):
            out[list(item.columns)] = factor if np.isfinite(factor) else 1.0
        return out

    def _together(self, factors: Floats | None) -> Joint | None:
        """Scale factors (item,) all alike until the target is met: error and RP go along in proportion."""
        if factors is None or not np.isfinite(factors).any():
            return None
        value = self.gauge.value(self._of_terms(factors))
        if not value.value > 0:
            return None
        scale = self.target / value.value
        return self._joint(factors * scale, Estimate(self.target, value.low * scale, value.high * scale), np.zeros(len(factors), bool))

    def _joint(self, factors: Floats, value: Estimate, usual: NDArray[np.bool_]) -> Joint:
        of_terms = self._of_terms(factors)
        return Joint(factors, parts_of(self.form, factors), value, self._verified(of_terms), usual, self._yields(of_terms))

    def _equal_effect(self) -> Joint | None:
        """Return every item the same part, but none a larger size than a usual one: what such items leave free goes to the others."""
        from scipy.optimize import brentq

        factors = equal_effect(self.form)
        if factors is None:
            return None
        value = self.gauge.value(self._of_terms(factors)).value
        if not value > 0:
            return None
        scale = self.target / value
        most = np.array([item.most for item in self.items])
        if not (factors * scale > most).any():
            return self._together(factors)

        def allotted(part: float) -> tuple[Floats, NDArray[np.bool_]]:
            found = equal_effect_within(self.form, most, part)
            return (factors * math.sqrt(part), np.zeros(len(most), bool)) if found is None else found

        def missed(log_part: float) -> float:
            return self.gauge.value(self._of_terms(allotted(math.exp(log_part))[0])).value / self.target - 1

        low = high = 2 * math.log(scale)
        while missed(high) < 0 and not allotted(math.exp(high))[1][np.isfinite(factors)].all():
            high += 1.0
        while missed(low) > 0:
            low -= 1.0
        sized, usual = allotted(math.exp(float(brentq(missed, low, high, xtol=_CLOSE)) if missed(high) > 0 > missed(low) else high))
        return self._joint(sized, self.gauge.value(self._of_terms(sized)), usual)


def _ranges(missed: Callable[[float], Missed], tried: Floats, *, search: bool) -> tuple[tuple[float, float], ...]:
    """Between which factors is the target met? Tries these, and with `search` looks between them where none does; the last may reach to infinity."""
    at = sorted({*(float(each) for each in tried), 1.0})
    values = [missed(each).value for each in at]
    if search and min(values) > 0:
        at, values = _with_least(missed, at, values)
    out: list[list[float]] = []
    for k, here in enumerate(at):
        before = k > 0 and values[k - 1] <= 0
        if values[k] <= 0 and not before:
            out.append([0.0 if k == 0 else root(missed, at[k - 1], here), math.inf])
        elif values[k] > 0 and before:
            out[-1][1] = root(missed, at[k - 1], here)
    return tuple((low, high) for low, high in out)


def _with_least(missed: Callable[[float], Missed], at: list[float], values: list[float]) -> tuple[list[float], list[float]]:
    """Add the factor at which the target is missed by least."""
    from scipy.optimize import minimize_scalar

    k = int(np.argmin(values))
    low, high = at[max(k - 1, 0)], at[min(k + 1, len(at) - 1)]
    best = float(minimize_scalar(lambda factor: missed(factor).value, bounds=(low, high), method="bounded", options={"xatol": 1e-4 * high}).x)
    both = sorted([*zip(at, values, strict=True), (best, missed(best).value)])
    return [one for one, _ in both], [other for _, other in both]


def _nearest(ranges: tuple[tuple[float, float], ...]) -> float:
    """Which factor is just allowed? The upper end of the range that holds 1; where none does, the end that is nearest to 1."""
    for low, high in ranges:
        if low <= 1 <= high:
            return high
    return min((end for both in ranges for end in both), key=lambda end: abs(end - 1))


def _visits(plan: Plan) -> int:
    return min(plan.visits, _ENOUGH_VISITS)
