"""Accuracy and repeatability of an arm with drives of its class and of the neighbouring classes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, Literal

from lostmotion.catalogue.drive_classes import neighbours
from lostmotion.error_model.expected_repeatability import expected_repeatability, visit_covariance
from lostmotion.error_model.pose_matrix import pose_matrix
from lostmotion.error_model.poses import sample_poses
from lostmotion.error_model.trust import with_figures
from lostmotion.io.drive_classes import class_of_arm, with_class

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from lostmotion.catalogue.drive_classes import DriveClass
    from lostmotion.mechanism.arm import Arm

# Poses of the figures of a class: enough for the one digit that is printed.
POSES: Final = 64
VISITS: Final = 30
ROBOTS: Final = 64
LEVEL: Final = 0.95


@dataclass(frozen=True)
class ClassFigures:
    """Figures of an arm with drives of one class.

    within         error that 95 % of positions of all robots stay within, m; NaN where it cannot be
                   found without sampling
    repeatability  RP_l of ISO 9283 over 30 visits, each joint arriving from one side, mean over
                   poses and robots, m
    any_approach   the same where joints arrive from either side at random, m
    default        whether it is the class of the arm itself
    beyond         factor by which arms of the class may be worse, where no next class shows it
    """

    name: str
    within: float
    repeatability: float
    any_approach: float
    default: bool
    beyond: float = 1.0

    @staticmethod
    def ends(
        figures: Sequence[ClassFigures], key: Literal["within", "repeatability"]
    ) -> tuple[float, float]:
        """Return the smallest and the largest figure (m) of these classes, the largest with what
        lies beyond its class.
        """
        return min(getattr(each, key) for each in figures), max(
            getattr(each, key) * each.beyond for each in figures
        )


def class_figures(arm: Arm, seed: int = 1) -> tuple[ClassFigures, ...]:
    """Return the figures of an arm with drives of its class and of the next smaller and larger
    ones, in order of size.

    Empty where the drive of any joint is not assumed from a class. The joints keep the loads of
    their drives.
    """
    of = class_of_arm(arm)
    return () if of is None else _figures(arm, of, None, seed)


def first_figures(
    arm: Arm, of: DriveClass, loads: Mapping[str, float], seed: int = 1
) -> tuple[ClassFigures, ...]:
    """Return the same for an arm that describes no drive: with these loads, N m or N by joint, and
    this class.
    """
    return _figures(arm, of, loads, seed)


def _figures(
    arm: Arm, of: DriveClass, loads: Mapping[str, float] | None, seed: int
) -> tuple[ClassFigures, ...]:
    return tuple(
        _of_class(arm, each, loads, seed, default=each is of) for each in neighbours(of.name)
    )


def _of_class(
    arm: Arm, each: DriveClass, loads: Mapping[str, float] | None, seed: int, *, default: bool
) -> ClassFigures:
    from lostmotion.propagation.analytic import analytic
    from lostmotion.propagation.montecarlo.montecarlo import run
    from lostmotion.propagation.pooled import pooled

    other = arm if default and loads is None else with_class(arm, each, loads)
    poses = with_figures(other, sample_poses(other, POSES, seed=seed), most=1.0)
    found = pooled(other, poses, analytic(other, poses))
    within = dict(zip(found.levels, found.quantiles, strict=True))[LEVEL].value
    visits = visit_covariance(pose_matrix(other, poses.q, approach=1.0))
    return ClassFigures(
        each.name,
        within,
        float(expected_repeatability(visits, VISITS)[0].mean()),
        float(run(other, poses, ROBOTS, VISITS, seed, compared=0).robot_means[:, :, 2].mean()),
        default,
        each.beyond,
    )
