"""Accuracy of an arm over its workspace, sampled or by sums over terms, with its tables, plots and
arrays.
"""

from __future__ import annotations

import functools
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Final, Literal, Self, cast

from lostmotion.accuracy.answer import Answer
from lostmotion.analyses.arguments import pose_of, zones_of
from lostmotion.analyses.result import Result, frame_of
from lostmotion.error_model.arrival import rp_key, undescribed_scatter
from lostmotion.error_model.budget import budget, costs, tally
from lostmotion.error_model.pose_selection import in_zone, one_pose
from lostmotion.error_model.poses import Poses
from lostmotion.error_model.provenance import states
from lostmotion.error_model.trust import refuse_untrusted
from lostmotion.error_model.upper_limits import with_limits
from lostmotion.errors import nearest, refuse_argument
from lostmotion.mechanism.state import tool_points
from lostmotion.reporting.arm_sheet import sign_of
from lostmotion.reporting.sheet import several

if TYPE_CHECKING:
    from collections.abc import Sequence

    import pandas as pd
    import xarray

    from lostmotion.accuracy.drive_classes import ClassFigures
    from lostmotion.accuracy.route import FoundInZone
    from lostmotion.analyses.arguments import At, Zone
    from lostmotion.error_model.budget import Budget, By, Cost, Halving
    from lostmotion.error_model.intervals import Estimate
    from lostmotion.error_model.provenance import States
    from lostmotion.mechanism.arm import Arm
    from lostmotion.propagation.analytic import Analytic
    from lostmotion.propagation.error_samples import Errors, Summed
    from lostmotion.propagation.figures import Figure
    from lostmotion.propagation.pooled import Pooled
    from lostmotion.reporting.labelled_arrays import LabelledArrays
    from lostmotion.reporting.plot import Plot
    from lostmotion.reporting.sheet import Sheet
    from lostmotion.spatial import Floats


class Attributed:
    """A study, sampled or not, of which part is to blame; a dataclass that has these six gains the
    two questions below.
    """

    if TYPE_CHECKING:
        arm: Arm
        poses: Poses
        seed: int
        approach: float
        threads: int
        budgets: tuple[Budget, ...]

    @property
    def states(self) -> States:
        """Return what is known of each joint: stated, assumed, or ideal, and the assumed values."""
        return states(self.arm)

    def costs(
        self, by: By = "part", *, at: At | None = None, zone: Zone | None = None
    ) -> list[Cost]:
        """Return the error budget by part, cause, level or term, largest first: over all poses, at
        one of them, or in a zone. Exact, no sampling.

        at    a pose: its number in the study, "A=30deg B=-10deg", or joint values (joint,), text
              with a unit or rad and m
        zone  "x 0.2..0.5 m" in the base's axes, ends as quantities, {"x": ("200 mm", 0.5)}, or
              which poses are in it (pose,)

        Shares add to one. Raises InputError for a pose that there is not or a zone that no pose
        reaches.
        """
        q, _ = self._where(at, zone)
        return costs(tally(self.arm, q, by, approach=self.approach))

    def with_budget(self, *, at: At | None = None, zone: Zone | None = None) -> Self:
        """Return the same study with the error budget at a pose or in a zone, and the effect of
        halving; arguments and errors as `costs`.
        """
        from lostmotion.propagation.montecarlo.sensitivity import halving_at

        q, where = self._where(at, zone)
        gains = halving_at(
            self.arm, Poses(q, "given"), self.seed, approach=self.approach, threads=self.threads
        )
        found = replace(budget(self.arm, q, where, approach=self.approach), halving=gains)
        return cast("Self", replace(cast("Any", self), budgets=(*self.budgets, found)))

    def _where(self, at: At | None, zone: Zone | None) -> tuple[Floats, str]:
        if at is not None and zone is not None:
            raise refuse_argument("at, zone", "both", "one of them, or none for all poses", at=0)
        if at is not None:
            q, name = one_pose(self.poses.q, pose_of("at", at, {"arm": self.arm}))
            from lostmotion.reporting.joint_values import joint_values

            refuse_untrusted(self.arm, q, 0.0)
            return q, f"{name}, {joint_values(self.arm, q[0])}"
        if zone is not None:
            mask, name = in_zone(tool_points(self.arm, self.poses.q), zones_of("zone", zone)[0])
            return self.poses.q[mask], f"{name}, {int(mask.sum())} of {len(mask)} poses"
        return self.poses.q, f"over {several(len(self.poses), 'pose')}"


# Short names of the figures that are asked for first.
_SHORT: Final = {"ap": "ap_p95", "rp": "rp_iso_p95"}


class Figured:
    """A study with figures of the error: as attributes by key, as a mapping and as a table."""

    if TYPE_CHECKING:
        arm: Arm
        poses: Poses
        approach: float

        @property
        def errors(self) -> Errors:
            """Return what the figures are estimated from."""

    @functools.cached_property
    def figures(self) -> dict[str, Estimate]:
        """Return every figure of the error by key, in SI with its interval; with the bound that it
        is where kinds of error, or the scatter of friction, are not described.
        """
        from lostmotion.propagation.figures import figures_of

        known = with_limits(states(self.arm), self.arm, self.poses.q, self.approach)
        missing = sign_of(known)
        one_sided = "lower" if undescribed_scatter(self.arm) else missing

        def bound(figure: Figure) -> Literal["", "lower"]:
            if figure.key.startswith(rp_key(1.0)):
                return one_sided
            return missing if figure.group != "levels" else ""

        return {
            key: replace(each.of(self.errors), bound=bound(each))
            for key, each in figures_of(self.errors).items()
        }

    def __getattr__(self, name: str) -> Estimate:
        """Return a figure of the error by its key: `study.p95.value`, `.low` and `.high` in SI;
        `ap` and `rp` are those that 95 % of robots stay within, RP in the cycle of ISO 9283.
        """
        if name.startswith("_"):
            raise AttributeError(name)
        key = _SHORT.get(name, name)
        if key not in self.figures:
            near = nearest(name, [*self.figures, *_SHORT])
            raise AttributeError(
                f"a study has no attribute '{name}'" + (f"; did you mean '{near}'?" if near else "")
            )
        return self.figures[key]

    def frame(self) -> pd.DataFrame:
        """Return the figures of the error as a table: one row for each key, with name, value, ends
        of the 95 % interval, SI unit, bound and definition.
        """
        from lostmotion.propagation.figures import figures_of

        return frame_of(
            (key, each.name, self.figures[key], each.definition)
            for key, each in figures_of(self.errors).items()
        )


class Study(Answer, Figured, Attributed, Result):
    """Accuracy of an arm by a Monte Carlo run: every attribute of `Answer`."""

    figures = Figured.figures  # those of `Answer`, which knows nothing of bounds, come first

    @functools.cached_property
    def sheet(self) -> Sheet:
        """Return workspace, error, AP and RP, error budget and torques, each figure with its
        interval and sample.
        """
        from lostmotion.analyses.accuracy.page import sheet

        return sheet(self)

    @property
    def plots(self) -> Sequence[Plot]:
        """Return the plots of the report."""
        from lostmotion.analyses.accuracy.page.plots import plots

        return plots(self)

    def _first_plot(self) -> Plot:
        from lostmotion.analyses.accuracy.page.arm_plots import arm_in_workspace
        from lostmotion.analyses.accuracy.page.plots import pose_errors

        return next(arm_in_workspace(pose_errors(self)))

    def arrays(self) -> xarray.Dataset:
        """Return every result per pose and per robot with its name, unit and coordinates."""
        return self._arrays().dataset()

    def files(self) -> dict[str, bytes]:
        """Return the arrays as arrays.nc."""
        return {"arrays.nc": self._arrays().netcdf()}

    def _arrays(self) -> LabelledArrays:
        from lostmotion.analyses.accuracy.page.arrays import arrays_of_study

        return arrays_of_study(self)

    def __repr__(self) -> str:
        """Return the main figures, one a line."""
        from lostmotion.analyses.accuracy.page import sections
        from lostmotion.reporting.provenance import missing_clause

        wanted = {"error": 4, "iso9283": 4, "budget": 3}
        lines = [
            (
                f"<Study of '{self.arm.name}': {len(self.poses)} poses x {self.sampled.robots} "
                f"robots x {self.sampled.visits} visits, seed {self.seed}"
            )
        ]
        for section in sections(self):
            for row in section.rows[: wanted.get(section.key, 0)]:
                interval = f"  ({row.cells[0].interval})" if row.cells[0].interval else ""
                share = f", {row.cells[1]} of the mean square" if section.key == "budget" else ""
                lines.append(f"  {row.label:32} {row.cells[0]}{interval}{share}")
        missing = missing_clause(self.states)
        return "\n".join([*lines, *([f"  at least: {missing}"] if missing else [])]) + ">"


@dataclass(frozen=True, repr=False)
class AnalyticStudy(Figured, Attributed, Result):
    """Accuracy of an arm by sums over terms: `analytic` at every pose, `pooled` over all, `budget`
    by part and kind, `budgets` of poses and zones.
    """

    arm: Arm
    poses: Poses
    approach: float
    analytic: Analytic
    pooled: Pooled
    budget: Budget
    budgets: tuple[Budget, ...] = ()
    zones: tuple[FoundInZone, ...] = ()
    seed: int = 1
    threads: int = 1
    classes: tuple[ClassFigures, ...] = ()

    @functools.cached_property
    def errors(self) -> Summed:
        """Return what the figures of the error are estimated from."""
        from lostmotion.propagation.error_samples import Summed

        return Summed.of(self.pooled, self.budget.squares)

    @functools.cached_property
    def halving(self) -> Halving:
        """Return what halving each part's errors, or each kind of error, takes off the 95 % error,
        by common random numbers.
        """
        from lostmotion.propagation.montecarlo.sensitivity import halving_at

        return halving_at(
            self.arm, self.poses, self.seed, approach=self.approach, threads=self.threads
        )

    @functools.cached_property
    def remedied(self) -> dict[str, Estimate]:
        """Return the r.m.s. error that each remedy leaves, m, by its name."""
        from lostmotion.error_model.few_poses import many_poses
        from lostmotion.error_model.remedies import remaining_rms

        return remaining_rms(
            self.arm, self.poses, approach=self.approach, many=many_poses(self.arm, self.poses)
        )

    @property
    def places(self) -> tuple[Budget, ...]:
        """Return the error budgets of poses and zones."""
        return (*self.budgets, *(zone.budget for zone in self.zones))

    @functools.cached_property
    def sheet(self) -> Sheet:
        """Return every figure, as printed, reported and written."""
        from lostmotion.analyses.accuracy.page.analytic import analytic_sheet
        from lostmotion.analyses.accuracy.page.headline import with_classes, with_presets

        blame = replace(self.budget, halving=self.halving)
        sheet = analytic_sheet(
            self.arm,
            self.poses,
            self.analytic,
            self.errors,
            blame,
            self.places,
            self.zones,
            remedied=self.remedied,
            approach=self.approach,
        )
        if self.classes:
            return with_classes(sheet, self.classes, self.states)
        within = self.figures["p95"].value
        return with_presets(sheet, within, self.states)

    @property
    def plots(self) -> Sequence[Plot]:
        """Return the plots of the report."""
        from lostmotion.analyses.accuracy.page.arm_plots import PicturedErrors, arm_in_workspace
        from lostmotion.analyses.accuracy.page.budget_plots import of_budget
        from lostmotion.error_model.poses import reachable_points
        from lostmotion.mechanism.state import tool_points

        within = self.analytic.quantiles[:, self.analytic.levels.index(0.95)]
        reachable = reachable_points(self.arm, self.seed)
        tool = tool_points(self.arm, self.poses.q)
        pictures = arm_in_workspace(
            PicturedErrors(
                self.arm, self.poses.q, self.approach, tool, self.analytic.mean, within, reachable
            )
        )
        return [*pictures, *of_budget(self.budget, self.places)]

    def arrays(self) -> xarray.Dataset:
        """Return every figure per pose with its uncertainty, name, unit and coordinates."""
        return self._arrays().dataset()

    def files(self) -> dict[str, bytes]:
        """Return the arrays as arrays.nc."""
        return {"arrays.nc": self._arrays().netcdf()}

    def _arrays(self) -> LabelledArrays:
        from lostmotion.analyses.accuracy.page.arrays import arrays_without_sampling

        return arrays_without_sampling(self.arm, self.poses, self.analytic, self.zones)

    def __repr__(self) -> str:
        """Return what was studied, in a line."""
        return (
            f"<AnalyticStudy of '{self.arm.name}': {len(self.poses)} poses; mean "
            f"{self.pooled.mean.value:.4g} m>"
        )
