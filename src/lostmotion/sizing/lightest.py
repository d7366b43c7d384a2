"""Lightest section of one link, from a family or a list, that meets limits of slope and deflection
under given loads.
"""

from __future__ import annotations

import functools
import itertools
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from lostmotion.sizing.size_steps import SizeSteps

if TYPE_CHECKING:
    from lostmotion.parts.elastic_link import ElasticLink
    from lostmotion.parts.family import Family
    from lostmotion.parts.joint import Joint
    from lostmotion.parts.material import Material
    from lostmotion.parts.section import Plain, Sized
    from lostmotion.sizing.link_deflection import LinkLoads
    from lostmotion.spatial import Floats

# A utilisation above 1 by no more than this is rounding.
SLACK: Final = 1e-9
# Poses at first, the worst of either limit; poses at which the result is worse are added.
_ACTIVE: Final = 32
_ROUNDS: Final = 50
# Values of one free size before the root is bracketed; values of each of several free sizes.
_SCAN: Final = 13
_GRID: Final = {2: 8, 3: 5, 4: 4}
_STARTS: Final = 3
_IMPOSSIBLE: Final = 20.0
_LEAST: Final = 1e-300
# Allowed values on each side of the continuous optimum that are tried; more where none of them is
# within the limits.
_AROUND: Final = (2, 4)


@dataclass(frozen=True, slots=True)
class Limits:
    """Limits of a link's tip: slope (rad), and deflection as the length over this number; 0.5' and
    2500 in the paper's condition (4).
    """

    slope: float
    deflection: float

    def scaled(self, factor: float) -> Limits:
        """Return both limits multiplied by a factor."""
        return Limits(self.slope * factor, self.deflection / factor)


# Limits of the paper: 0.5' and length/2500.
PAPER: Final = Limits(0.5 * math.pi / 10800, 2500.0)


@dataclass(frozen=True, slots=True)
class SizedSection:
    """A section and its utilisation: the larger of slope and deflection over their limits. Above 1,
    no section of the choice is within them.
    """

    section: Plain
    utilisation: float

    @property
    def meets_limits(self) -> bool:
        """Return whether the section meets the limits."""
        return self.utilisation <= 1 + SLACK


def with_section(joint: Joint, section: Plain, material: Material | None = None) -> Joint:
    """Return the joint with another uniform section of its link.

    A stated mass of the link above that of its section remains as additional mass; for a link
    without a section, all of the stated mass remains.
    """
    link = joint.link
    changed: dict[str, object] = {
        "section": section,
        "material": material or link.material,
        "mass": None,
    }
    changed |= {"compliance": None, "measured": None, "rigid": False}
    out = link.model_copy(update=changed)
    if link.mass is not None:
        own = link.model_copy(update={"mass": None}).total_mass
        out = out.model_copy(update={"mass": out.total_mass + max(link.mass - own, 0.0)})
    return joint.model_copy(update={"link": out})


@dataclass(frozen=True)
class LinkTask:
    """One link to size: its joint, loads and limits, and its new material (None: its own)."""

    joint: Joint
    loads: LinkLoads
    limits: Limits
    material: Material | None = None

    def link(self, section: Plain) -> ElasticLink:
        """Return the link with this section."""
        return with_section(self.joint, section, self.material).elastic_link

    def mass(self, section: Plain) -> float:
        """Return the mass of the link with this section, kg."""
        return self.link(section).link.total_mass

    def section_utilisation(self, section: Plain) -> Floats:
        """Return slope and deflection with a section over their limits (pose, 2)."""
        return self.utilisation(self.link(section), self.loads)

    def utilisation(self, link: ElasticLink, loads: LinkLoads) -> Floats:
        """Return slope and deflection of a link under some loads over their limits (pose, 2)."""
        limits = np.array([self.limits.slope, link.link.reach / self.limits.deflection])
        return np.asarray(loads.deflections(link) / limits)


def lightest(
    task: LinkTask, choice: Family | tuple[Plain, ...], step: float | None = 0.0
) -> SizedSection:
    """Return the lightest section of a family or list that meets the limits, else the one of least
    utilisation.

    Free sizes are multiples of `step` (m), 0: continuous, None: usual sizes of tubes and bars; of
    those near the continuous optimum the lightest that meets the limits. One free size is solved by
    bracketing and Brent's method, several by SLSQP from
    several starts in the logarithms of the sizes, in which mass and deflection of thin sections are
    convex. The search uses the worst poses only, and adds poses at which the result exceeds the
    limits until it is valid for all of them.
    """
    if isinstance(choice, tuple):
        return _of_list(task, choice)
    seed = choice.section(
        tuple(math.sqrt(span.low * span.high) for span in choice.spans)
    ) or choice.section(tuple(span.high for span in choice.spans))
    if seed is None:
        raise ValueError("a family of no section")
    active = _worst_poses(task.section_utilisation(seed))
    best = SizedSection(seed, math.inf)
    for _ in range(_ROUNDS):
        best = _FamilySearch(task, choice, task.loads.at(active), SizeSteps(step)).best()
        ratios = task.section_utilisation(best.section)
        at_all_poses = SizedSection(best.section, float(ratios.max()))
        if at_all_poses.utilisation <= max(best.utilisation, 1.0) + SLACK:
            return at_all_poses
        active = np.union1d(active, _worst_poses(ratios))
    return SizedSection(best.section, float(task.section_utilisation(best.section).max()))


def _worst_poses(ratios: Floats) -> np.ndarray:
    return np.unique(np.argsort(-ratios, axis=0, kind="stable")[:_ACTIVE])


def _of_list(task: LinkTask, stock: tuple[Plain, ...]) -> SizedSection:
    """Return the first section that meets the limits, in the order of mass."""
    least: SizedSection | None = None
    for section in sorted(stock, key=task.mass):
        tried = SizedSection(section, float(task.section_utilisation(section).max()))
        if tried.meets_limits:
            return tried
        least = tried if least is None or tried.utilisation < least.utilisation else least
    if least is None:
        raise ValueError("an empty list of sections")
    return least


class _FamilySearch:
    """The search in one family at the active poses."""

    def __init__(self, task: LinkTask, family: Family, loads: LinkLoads, steps: SizeSteps) -> None:
        self.task, self.family, self.loads, self.steps = task, family, loads, steps
        self.free = family.free
        self.fixed = tuple(span.low for span in family.spans)
        self.ends = [(family.spans[k].low, family.spans[k].high) for k in self.free]
        self.evaluate = functools.lru_cache(maxsize=20_000)(self._evaluate)

    def _values(self, free: tuple[float, ...]) -> tuple[float, ...]:
        values = list(self.fixed)
        for k, value in zip(self.free, free, strict=True):
            values[k] = value
        return tuple(values)

    def section(self, free: tuple[float, ...]) -> Sized | None:
        return self.family.section(self._values(free))

    def allowed(self, free: tuple[float, ...]) -> Sized | None:
        """Return the section with these sizes, in which those that follow the leading one are
        allowed too.
        """
        return self.steps.section(self.family, self._values(free))

    def _evaluate(
        self, free: tuple[float, ...], *, in_steps: bool = False
    ) -> tuple[float, float, float]:
        """Return mass, and the utilisation of slope and deflection; infinite where there is no such
        section.
        """
        section = self.allowed(free) if in_steps else self.section(free)
        if section is None:
            return math.inf, math.inf, math.inf
        link = self.task.link(section)
        slope, deflection = self.task.utilisation(link, self.loads).max(axis=0)
        return link.link.total_mass, float(slope), float(deflection)

    def utilisation(self, free: tuple[float, ...]) -> float:
        return max(self.evaluate(free)[1:])

    def best(self) -> SizedSection:
        if not self.free:
            chosen: tuple[float, ...] = ()
        elif len(self.free) == 1:
            chosen = self._of_one()
        else:
            chosen = self._of_several()
        section = self.allowed(chosen) or self.section(chosen)
        if section is None:
            raise ValueError("a family of no section")
        return SizedSection(
            section, float(self.task.utilisation(self.task.link(section), self.loads).max())
        )

    def _of_one(self) -> tuple[float, ...]:
        """Return the smallest size within the limits. Deflection may rise again at large sizes,
        where the link's own weight dominates.
        """
        from scipy.optimize import brentq, minimize_scalar

        low, high = self.ends[0]
        scan = [float(x) for x in np.geomspace(low, high, _SCAN)]
        scan[0], scan[-1] = low, high
        over = [
            math.log(utilisation)
            if 0 < (utilisation := self.utilisation((x,))) < math.inf
            else _sign(utilisation) * _IMPOSSIBLE
            for x in scan
        ]
        first = next((k for k, value in enumerate(over) if value <= 0), None)
        if first is None:
            least = int(np.argmin(over))
            ends = scan[max(least - 1, 0)], scan[min(least + 1, len(scan) - 1)]
            best = minimize_scalar(
                lambda x: min(math.log(self.utilisation((float(x),))), _IMPOSSIBLE),
                bounds=ends,
                method="bounded",
                options={"xatol": 1e-9},
            )
            size = float(best.x) if best.fun < over[least] else scan[least]
            if self.utilisation((size,)) > 1:
                return self._stiffest(size)
            scan, first = [ends[0], size], 1
        if first == 0:
            return self._in_steps((low,))
        root = float(
            brentq(
                lambda x: _clipped(math.log(self.utilisation((float(x),)))),
                scan[first - 1],
                scan[first],
                xtol=1e-12,
                rtol=1e-12,
            )
        )
        nudge = 1e-12
        while self.utilisation((root,)) > 1:  # on the other side of the root by rounding
            root = min(root * (1 + nudge), scan[first])
            nudge *= 2
        return self._in_steps((root,))

    def _stiffest(self, size: float) -> tuple[float, ...]:
        return min(self._near((size,)), key=self._stepped_utilisation, default=(size,))

    def _of_several(self) -> tuple[float, ...]:
        from scipy.optimize import minimize

        grid = [
            tuple(float(x) for x in point)
            for point in itertools.product(
                *(np.geomspace(low, high, _GRID[len(self.ends)]) for low, high in self.ends)
            )
        ]
        grid = [self._clip(point) for point in grid]
        within = sorted(
            (point for point in grid if self.utilisation(point) <= 1),
            key=lambda point: self.evaluate(point)[0],
        )
        bounds = [(math.log(low), math.log(high)) for low, high in self.ends]
        if not within:
            start = min(grid, key=self.utilisation)
            best = minimize(self._log_utilisation, _logs(start), method="L-BFGS-B", bounds=bounds)
            least = min((self._point(best.x), start), key=self.utilisation)
            if self.utilisation(least) > 1:
                return min([*self._near(least), least], key=self._stepped_utilisation)
            within = [least]
        points = list(within[:1])
        constraints: Any = [
            {"type": "ineq", "fun": self._log_margin, "args": (which,)} for which in (1, 2)
        ]
        for start in _starts(within):
            best = minimize(
                self._log_mass,
                _logs(start),
                method="SLSQP",
                bounds=bounds,
                constraints=constraints,
                options={"maxiter": 60, "ftol": 1e-9},
            )
            points.append(self._moved_within(self._point(best.x), start))
        return self._in_steps(min(points, key=lambda point: self.evaluate(point)[0]))

    def _log_mass(self, x: Floats) -> float:
        return _clipped(math.log(max(self.evaluate(self._point(x))[0], _LEAST)))

    def _log_utilisation(self, x: Floats) -> float:
        return _clipped(math.log(max(self.utilisation(self._point(x)), _LEAST)))

    def _log_margin(self, x: Floats, which: int) -> float:
        return -_clipped(math.log(max(self.evaluate(self._point(x))[which], _LEAST)))

    def _point(self, x: Floats) -> tuple[float, ...]:
        return self._clip(tuple(float(each) for each in np.exp(x)))

    def _clip(self, point: tuple[float, ...]) -> tuple[float, ...]:
        return tuple(
            min(max(x, low), high) for x, (low, high) in zip(point, self.ends, strict=True)
        )

    def _moved_within(
        self, point: tuple[float, ...], within: tuple[float, ...]
    ) -> tuple[float, ...]:
        """Return the point nearest to `point`, on the line to a point within the limits, that is
        within them.
        """
        if self.utilisation(point) <= 1:
            return point
        near, far = _logs(within), _logs(point)
        good, bad = 0.0, 1.0
        for _ in range(50):
            share = (good + bad) / 2
            good, bad = (
                (share, bad)
                if self.utilisation(self._point(near + share * (far - near))) <= 1
                else (good, share)
            )
        return self._point(near + good * (far - near))

    def _stepped_utilisation(self, free: tuple[float, ...]) -> float:
        return max(self.evaluate(free, in_steps=True)[1:])

    def _in_steps(self, point: tuple[float, ...]) -> tuple[float, ...]:
        """Return the lightest allowed sizes near a point within the limits; the point itself where
        there are none.
        """
        if self.steps.exact:
            return point
        for around in _AROUND:
            within = [
                each for each in self._near(point, around) if self._stepped_utilisation(each) <= 1
            ]
            if within:
                return min(within, key=lambda each: self.evaluate(each, in_steps=True)[0])
        return point

    def _near(self, point: tuple[float, ...], around: int = _AROUND[0]) -> list[tuple[float, ...]]:
        if self.steps.exact:
            return [point]
        axes = [
            self.steps.near(self.family, k, value, around)
            for k, value in zip(self.free, point, strict=True)
        ]
        return list(itertools.product(*axes))


def _starts(points: list[tuple[float, ...]]) -> list[tuple[float, ...]]:
    """Return the first few points and the middle one."""
    return list(dict.fromkeys([*points[: _STARTS - 1], points[len(points) // 2]]))


def _clipped(value: float) -> float:
    return min(max(value, -_IMPOSSIBLE), _IMPOSSIBLE)


def _logs(point: tuple[float, ...]) -> Floats:
    return np.array([math.log(x) for x in point])


def _sign(value: float) -> float:
    return 1.0 if value > 1 else -1.0
