"""Allowances for the parts of an arm that meet a target on the tool: for one item at a time, and
allocated to all items together.

Each item of `parameters` has a factor on its terms. Bias is linear in the factors and variance
quadratic, so the mean square error is a quadratic form from which allocations of equal effect
follow exactly. Error quantiles and RP are solved for the factor numerically (`metrics`).
"""

from __future__ import annotations

import math
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, Literal

import numpy as np

from lostmotion.analyses.targets.allocation import (
    NOTHING,
    Allocation,
    contributions,
    equal_effect,
    equal_effect_within,
    mean_square_form,
    moving,
)
from lostmotion.analyses.targets.metrics import (
    ErrorMetric,
    Metric,
    RepeatabilityMetric,
    by_montecarlo,
    root,
    root_interval,
)
from lostmotion.analyses.targets.parameters import Item, items, shared_items
from lostmotion.analyses.targets.yield_ import (
    MOST_ROBOTS,
    Criterion,
    Yield,
    check_share,
    robot_figures,
    split_blocks,
    yield_of,
)
from lostmotion.error_model.intervals import Estimate
from lostmotion.error_model.pose_matrix import screws
from lostmotion.errors import refuse_argument
from lostmotion.mechanism.state import state_of
from lostmotion.propagation.montecarlo.blocks import BlockPlan

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from numpy.typing import NDArray

    from lostmotion.analyses.targets.metrics import Excess
    from lostmotion.error_model.pose_matrix import PoseMatrix
    from lostmotion.error_model.poses import Poses
    from lostmotion.mechanism.arm import Arm
    from lostmotion.spatial import Floats

Kind = Literal["error", "repeatability"]
Verdict = Literal["sized", "usual", "any", "none"]
MOST_POSES: Final = 16_384
# Largest pose matrix, poses x terms, of 100 bytes each.
_MOST_CELLS: Final = 8_000_000
# The interval of a pooled quantile counts robots: more visits hardly narrow it.
_ENOUGH_VISITS: Final = 8
# Factors to try, in units of that at which the item alone reaches the target or the error: a fine
# grid where its bias may cancel other bias.
_FINE: Final = (*(k / 16 for k in range(64)), 4.0, 6.0, 12.0, 40.0, 1000.0)
_FEW: Final = (0.0, 0.5, 2.0, 12.0, 1000.0)
# Relative tolerance of the mean square per item.
_CLOSE: Final = 1e-4


@dataclass(frozen=True)
class Allowance:
    """Allowance for one item, all others unchanged.

    verdict   "sized": the target is just met at the factor; "usual": it is met at every usual size,
              up to the factor; "any": at every size; "none": not even without the item
    factor    on the item's size (on its inverse for a stiffness) with its 95 % interval; infinite
              for "any", NaN for "none"
    ranges    factors that meet the target; several, or one that does not begin at zero, where the
              item cancels others
    without   error or RP, m, without the item
    verified  error or RP, m, by Monte Carlo at the factor; None where there is none
    share     of the present mean square (for repeatability, of its part that differs between
              visits)
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
    """Allowances and allocations that meet a target.

    zone                name of the poses' part of the workspace; empty for all of it
    kind                "error" (m, quantile `share` over positions) or "repeatability" (m, quantile
                        `share` over robots of RP)
    robots, visits      of the Monte Carlo study; `verified_visits` of the one that verifies
                        allowances
    solved_poses, solved_samples  of the solution; for repeatability the samples are robots x visits
                                  x poses
    current             error or RP of the arm as stated, m, by Monte Carlo
    current_by_solver   the same from the samples that the allowances were solved with
    allowances          one item at a time
    shared_allowances   one cause at a time, in all parts of a kind
    form                (item, item) m^2: factors @ form @ factors is the mean square
    equal_factor, equal_effect  allocations to all items; None where none exists
    yields              of the arm as stated, by two criteria
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
    current: Estimate
    current_by_solver: Estimate
    items: tuple[Item, ...]
    allowances: tuple[Allowance, ...]
    shared_allowances: tuple[Allowance, ...]
    form: Floats
    equal_factor: Allocation | None
    equal_effect: Allocation | None
    yields: tuple[Yield, ...]


def targets(  # noqa: PLR0913 - arguments of a target
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
    """Return the allowances with which a share of all positions, or of the robots, is within the
    target (m).

    kind     "error": position error over all robots, poses and visits; "repeatability": RP of each
             robot, averaged over the poses, of joints that arrive as `approach` states: ISO cycle
             or any approach
    robots, visits, seed, approach, threads, progress  of the Monte Carlo study that verifies, as
                                                       for `montecarlo.run`
    zone     name of the poses' part of the workspace; empty for all of it

    First order in the errors, at constant loads and masses. Raises InputError for numbers out of
    range.
    """
    check_target(target, share)
    if not 1 <= len(poses) <= MOST_POSES:
        raise refuse_argument("poses", len(poses), f"from 1 to {MOST_POSES}", poses=1024)
    if not 20 <= robots <= MOST_ROBOTS:  # noqa: PLR2004 - 95 % of fewer is all of them
        raise refuse_argument("robots", robots, f"from 20 to {MOST_ROBOTS}", robots=1000)
    if visits < 2:  # noqa: PLR2004 - a scatter needs two
        raise refuse_argument("visits", visits, "at least 2", visits=30)
    if threads < 1:
        raise refuse_argument("threads", threads, "at least 1", threads=2)
    plan = BlockPlan.of(arm, poses, robots, visits, seed, approach)
    matrix = screws(state_of(arm, poses.q), approach=approach)
    if len(poses) * len(matrix.infos) > _MOST_CELLS:
        most = _MOST_CELLS // len(matrix.infos)
        raise refuse_argument(
            "poses",
            len(poses),
            f"at most {most} with the {len(matrix.infos)} terms of this arm",
            poses=most // 2,
        )
    return _Solver(plan, matrix, kind, target, share, threads, progress or (lambda *_: None)).solve(
        zone
    )


def check_target(target: float, share: float) -> None:
    """Raise InputError for a target that is no positive length, or a share out of range."""
    if not (math.isfinite(target) and target > 0):
        raise refuse_argument("target", target, "a length above zero", error="0.5 mm")
    check_share(share)


class _Solver:
    """Plan, pose matrix and metric of one target."""

    def __init__(
        self,
        plan: BlockPlan,
        matrix: PoseMatrix,
        kind: Kind,
        target: float,
        share: float,
        threads: int,
        progress: Callable[[str, int, int], None],
    ) -> None:
        self.plan, self.matrix, self.kind, self.target, self.share, self.threads, self.progress = (
            plan,
            matrix,
            kind,
            target,
            share,
            threads,
            progress,
        )
        self.items = items(plan.arm, matrix.infos)
        self.form = mean_square_form(matrix, self.items, visits_only=kind == "repeatability")
        sets = plan.poses.replicates
        of_error = kind == "error"
        self.metric: Metric = (
            ErrorMetric(matrix, sets, share, target, plan.seed)
            if of_error
            else RepeatabilityMetric(matrix, sets, share, target, plan)
        )
        self.verification = (
            plan
            if kind == "repeatability"
            else BlockPlan.of(
                plan.arm, plan.poses, plan.robots, _visits(plan), plan.seed, plan.approach
            )
        )

    def solve(self, zone: str) -> Targets:
        """Return all allowances and allocations."""
        plan, ones = self.plan, np.ones(len(self.matrix.infos))
        current_by_solver = self.metric.value(ones)
        self.current = current_by_solver.value
        both = self._each((*self.items, *shared_items(self.items)))
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
            verified_visits=self.verification.visits,
            solved_poses=self.metric.poses,
            solved_samples=self.metric.samples,
            current=self._verified(ones),
            current_by_solver=current_by_solver,
            items=self.items,
            allowances=tuple(both[: len(self.items)]),
            shared_allowances=tuple(both[len(self.items) :]),
            form=self.form,
            equal_factor=self._scaled(np.where(moving(self.form), 1.0, np.nan)),
            equal_effect=self._equal_effect(),
            yields=self._yields(ones),
        )

    def _each(self, chosen: Sequence[Item]) -> list[Allowance]:
        out = []
        with ThreadPoolExecutor(self.threads) as pool:
            for done, one in enumerate(pool.map(self._allowance, chosen), 1):
                out.append(one)
                self.progress("solving for each item", done, len(chosen))
        return out

    def _alone(self, item: Item) -> tuple[float, float]:
        """Return the item's own r.m.s. error, m, and its share of the mean square."""
        members = np.array(
            [bool(set(each.columns) & set(item.columns)) for each in self.items], dtype=float
        )
        total = float(self.form.sum())
        return math.sqrt(max(float(members @ self.form @ members), 0.0)), float(
            members @ self.form.sum(axis=1)
        ) / total if total else 0.0

    def _allowance(self, item: Item) -> Allowance:
        alone, share = self._alone(item)
        unknown = Estimate(math.nan, math.nan, math.nan)
        if alone**2 <= NOTHING * max(float(self.form.sum()), 0.0):
            if self.current <= self.target:
                return Allowance(
                    item,
                    "any",
                    Estimate(math.inf, math.nan, math.nan),
                    ((0.0, math.inf),),
                    unknown,
                    None,
                    share,
                )
            return Allowance(
                item,
                "none",
                unknown,
                (),
                self.metric.value(np.ones(len(self.matrix.infos))),
                None,
                share,
            )
        size = max(self.target, self.current) / alone
        excess = self.metric.along(item.columns)
        fine = self.kind == "error" and any(
            self.matrix.infos[column].level == "design" for column in item.columns
        )
        ranges = _ranges(excess, size * np.array(_FINE if fine else _FEW), refine=fine)
        if not ranges:
            return Allowance(
                item, "none", unknown, (), self.metric.without(item.columns), None, share
            )
        at = _nearest(ranges)
        if math.isinf(at):
            return Allowance(
                item, "any", Estimate(math.inf, math.nan, math.nan), ranges, unknown, None, share
            )
        if at > item.most and any(low <= 1 and item.most <= high for low, high in ranges):
            return Allowance(
                item, "usual", Estimate(item.most, math.nan, math.nan), ranges, unknown, None, share
            )
        return Allowance(
            item,
            "sized",
            root_interval(excess, at),
            ranges,
            unknown,
            self._verified(self._factors(item, at)),
            share,
        )

    def _factors(self, item: Item, factor: float) -> Floats:
        out = np.ones(len(self.matrix.infos))
        out[list(item.columns)] = factor
        return out

    def _verified(self, factors: Floats) -> Estimate:
        """Return the error or RP by Monte Carlo with all robots and poses of the study."""
        error, repeatability = by_montecarlo(
            self.verification, self.matrix.scaled(factors), self.share
        )
        return error if self.kind == "error" else repeatability

    def _yields(self, factors: Floats) -> tuple[Yield, ...]:
        """Return the yields with a factor on each term (term,), by the two criteria of the kind of
        target.
        """
        figures = robot_figures(
            self.plan, split_blocks(self.matrix.scaled(factors), self.plan.robots), self.share
        )
        criterion: tuple[Criterion, Criterion] = (
            ("error", "worst accuracy")
            if self.kind == "error"
            else ("repeatability", "worst repeatability")
        )
        return tuple(yield_of(figures, each, self.target, self.plan.approach) for each in criterion)

    def _of_terms(self, factors: Floats) -> Floats:
        """Return the factor on each term (term,) for factors on the items (item,); NaN leaves an
        item unchanged.
        """
        out = np.ones(len(self.matrix.infos))
        for item, factor in zip(self.items, factors, strict=True):
            out[list(item.columns)] = factor if np.isfinite(factor) else 1.0
        return out

    def _scaled(self, factors: Floats | None) -> Allocation | None:
        """Return factors (item,) scaled in common to meet the target, to which error and RP are
        proportional.
        """
        if factors is None or not np.isfinite(factors).any():
            return None
        value = self.metric.value(self._of_terms(factors))
        if not value.value > 0:
            return None
        scale = self.target / value.value
        return self._allocation(
            factors * scale,
            Estimate(self.target, value.low * scale, value.high * scale),
            np.zeros(len(factors), bool),
        )

    def _allocation(
        self, factors: Floats, value: Estimate, not_limiting: NDArray[np.bool_]
    ) -> Allocation:
        of_terms = self._of_terms(factors)
        return Allocation(
            factors,
            contributions(self.form, factors),
            value,
            self._verified(of_terms),
            not_limiting,
            self._yields(of_terms),
        )

    def _equal_effect(self) -> Allocation | None:
        """Return equal effects with no item above its largest usual size; what such items do not
        use is allocated to the others.
        """
        from scipy.optimize import brentq

        factors = equal_effect(self.form)
        if factors is None:
            return None
        value = self.metric.value(self._of_terms(factors)).value
        if not value > 0:
            return None
        scale = self.target / value
        most = np.array([item.most for item in self.items])
        if not (factors * scale > most).any():
            return self._scaled(factors)

        def allotted(part: float) -> tuple[Floats, NDArray[np.bool_]]:
            within = equal_effect_within(self.form, most, part)
            return (
                (factors * math.sqrt(part), np.zeros(len(most), bool)) if within is None else within
            )

        def excess(log_part: float) -> float:
            return (
                self.metric.value(self._of_terms(allotted(math.exp(log_part))[0])).value
                / self.target
                - 1
            )

        low = high = 2 * math.log(scale)
        while excess(high) < 0 and not allotted(math.exp(high))[1][np.isfinite(factors)].all():
            high += 1.0
        while excess(low) > 0:
            low -= 1.0
        sized, not_limiting = allotted(
            math.exp(
                float(brentq(excess, low, high, xtol=_CLOSE))
                if excess(high) > 0 > excess(low)
                else high
            )
        )
        return self._allocation(sized, self.metric.value(self._of_terms(sized)), not_limiting)


def _ranges(
    excess: Callable[[float], Excess], tried: Floats, *, refine: bool
) -> tuple[tuple[float, float], ...]:
    """Return the ranges of factors that meet the target among those tried, and with `refine`
    between them; the last may extend to infinity.
    """
    at = sorted({*(float(each) for each in tried), 1.0})
    values = [excess(each).value for each in at]
    if refine and min(values) > 0:
        at, values = _with_least(excess, at, values)
    out: list[list[float]] = []
    for k, here in enumerate(at):
        before = k > 0 and values[k - 1] <= 0
        if values[k] <= 0 and not before:
            out.append([0.0 if k == 0 else root(excess, at[k - 1], here), math.inf])
        elif values[k] > 0 and before:
            out[-1][1] = root(excess, at[k - 1], here)
    return tuple((low, high) for low, high in out)


def _with_least(
    excess: Callable[[float], Excess], at: list[float], values: list[float]
) -> tuple[list[float], list[float]]:
    """Add the factor with the least excess."""
    from scipy.optimize import minimize_scalar

    k = int(np.argmin(values))
    low, high = at[max(k - 1, 0)], at[min(k + 1, len(at) - 1)]
    best = float(
        minimize_scalar(
            lambda factor: excess(factor).value,
            bounds=(low, high),
            method="bounded",
            options={"xatol": 1e-4 * high},
        ).x
    )
    both = sorted([*zip(at, values, strict=True), (best, excess(best).value)])
    return [one for one, _ in both], [other for _, other in both]


def _nearest(ranges: tuple[tuple[float, float], ...]) -> float:
    """Return the upper end of the range that contains 1, else the end nearest to 1."""
    for low, high in ranges:
        if low <= 1 <= high:
            return high
    return min((end for both in ranges for end in both), key=lambda end: abs(end - 1))


def _visits(plan: BlockPlan) -> int:
    return min(plan.visits, _ENOUGH_VISITS)
