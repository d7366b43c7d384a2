"""Error budgets of a study: over all its poses, at one of them, or in a zone."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any, Self, cast

from lostmotion.analyses.arguments import pose_of, zones_of
from lostmotion.error_model.budget import budget, costs, tally
from lostmotion.error_model.pose_selection import in_zone, one_pose
from lostmotion.error_model.poses import Poses
from lostmotion.error_model.provenance import states
from lostmotion.error_model.trust import refuse_untrusted
from lostmotion.errors import refuse_argument
from lostmotion.mechanism.state import tool_points
from lostmotion.reporting.sheet import several

if TYPE_CHECKING:
    from lostmotion.analyses.arguments import At, Zone
    from lostmotion.error_model.budget import Budget, By, Cost
    from lostmotion.error_model.provenance import States
    from lostmotion.mechanism.arm import Arm
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
