"""Solution for the allowances of one target: for one item at a time, and allocated to all items."""

from __future__ import annotations

import functools
import math
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final, Literal

import numpy as np

from lostmotion.error_model.allocation import (
    NOTHING,
    contributions,
    equal_effect,
    equal_effect_within,
    mean_square_form,
)
from lostmotion.error_model.intervals import Estimate
from lostmotion.error_model.items import Item, items
from lostmotion.propagation.excess_roots import nearest_end, ranges_within, root_interval
from lostmotion.propagation.factor_metrics import (
    ErrorMetric,
    Metric,
    RepeatabilityMetric,
    by_montecarlo,
)
from lostmotion.propagation.montecarlo.blocks import BlockPlan
from lostmotion.propagation.production_yield import (
    Criterion,
    Yield,
    robot_figures,
    split_blocks,
    yield_of,
)

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from numpy.typing import NDArray

    from lostmotion.error_model.pose_matrix import PoseMatrix
    from lostmotion.spatial import Floats

Kind = Literal["error", "repeatability"]
Verdict = Literal["sized", "usual", "any", "none"]
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


@dataclass(frozen=True)
class Allocation:
    """An allocation of the target to all items.

    factors        (item,), NaN for items that do not move the tool
    mean_squares   (item,) contributions to the mean square, m^2
    value          error or RP with these sizes, m, with the interval of the solution: the target,
                   or less where all items are `not_limiting`
    verified       the same by Monte Carlo
    not_limiting   (item,) items at their largest usual size, whose contribution is smaller than
                   that of the others
    yields         with these sizes, by the same criteria as those of the arm as stated
    """

    factors: Floats
    mean_squares: Floats
    value: Estimate
    verified: Estimate
    not_limiting: NDArray[np.bool_]
    yields: tuple[Yield, ...]


@dataclass
class Solver:
    """Plan, pose matrix and metric of one target."""

    plan: BlockPlan
    matrix: PoseMatrix
    kind: Kind
    target: float
    share: float
    threads: int
    progress: Callable[[str, int, int], None]

    def __post_init__(self) -> None:
        """Compute the items, their quadratic form, and the present figure."""
        plan, sets = self.plan, self.plan.poses.replicates
        of_error = self.kind == "error"
        self.items = items(plan.arm, self.matrix.infos)
        self.form = mean_square_form(self.matrix, self.items, visits_only=not of_error)
        self.metric: Metric = (
            ErrorMetric(self.matrix, sets, self.share, self.target, plan.seed)
            if of_error
            else RepeatabilityMetric(self.matrix, sets, self.share, self.target, plan)
        )
        visits = min(plan.visits, _ENOUGH_VISITS) if of_error else plan.visits
        self.verification = BlockPlan.of(
            plan.arm, plan.poses, plan.robots, visits, plan.seed, plan.approach
        )
        self.current = self.metric.value(np.ones(len(self.matrix.infos)))

    def allowances(self, chosen: Sequence[Item]) -> list[Allowance]:
        """Return the allowance for each of these items."""
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
        any_size = Allowance(
            item, "any", replace(unknown, value=math.inf), ((0.0, math.inf),), unknown, None, share
        )
        out_of_reach = replace(any_size, verdict="none", factor=unknown, ranges=())
        if alone**2 <= NOTHING * max(float(self.form.sum()), 0.0):
            if self.current.value <= self.target:
                return any_size
            return replace(out_of_reach, without=self.current)
        size = max(self.target, self.current.value) / alone
        excess = self.metric.along(item.columns)
        fine = self.kind == "error" and any(
            self.matrix.infos[column].level == "design" for column in item.columns
        )
        ranges = ranges_within(excess, size * np.array(_FINE if fine else _FEW), refine=fine)
        if not ranges:
            return replace(out_of_reach, without=self.metric.without(item.columns))
        at = nearest_end(ranges)
        if math.isinf(at):
            return replace(any_size, ranges=ranges)
        if at > item.most and any(low <= 1 and item.most <= high for low, high in ranges):
            return replace(
                any_size,
                verdict="usual",
                factor=replace(unknown, value=item.most),
                ranges=ranges,
            )
        return replace(
            any_size,
            verdict="sized",
            factor=root_interval(excess, at),
            ranges=ranges,
            verified=self.verified(self._factors(item, at)),
        )

    def _factors(self, item: Item, factor: float) -> Floats:
        out = np.ones(len(self.matrix.infos))
        out[list(item.columns)] = factor
        return out

    def verified(self, factors: Floats) -> Estimate:
        """Return the error or RP by Monte Carlo with all robots and poses of the study."""
        error, repeatability = by_montecarlo(
            self.verification, self.matrix.scaled(factors), self.share
        )
        return error if self.kind == "error" else repeatability

    def yields(self, factors: Floats) -> tuple[Yield, ...]:
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

    def scaled(self, factors: Floats | None) -> Allocation | None:
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
            self.verified(of_terms),
            not_limiting,
            self.yields(of_terms),
        )

    def equal_effect(self) -> Allocation | None:
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
            return self.scaled(factors)

        def allotted(part: float) -> tuple[Floats, NDArray[np.bool_]]:
            within = equal_effect_within(self.form, most, part)
            return (
                (factors * math.sqrt(part), np.zeros(len(most), bool)) if within is None else within
            )

        @functools.cache  # at both ends it is asked for thrice
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
