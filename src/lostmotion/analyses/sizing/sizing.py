"""Lightest sections of an arm's links that meet limits of slope and deflection, and the trade-off
between mass and tool error.

Condition (4) of S. Strutynskyi, R. Semenchuk 2021: the lightest section of each link with a slope
of at most 0.5' and a deflection of at most length/2500 under load at the worst pose. A link carries
only itself and what is outboard of it, so links sized from the tip inward have their final loads,
and one pass is exact; where loops share loads, passes are repeated until the sections repeat. A
heavier outboard link could make an inboard one lighter only where its weight relieves that link;
`LinkSize.relieved_by` names such links.
"""

from __future__ import annotations

import math
from abc import abstractmethod
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.analyses.result import Result
from lostmotion.error_model.budget import Tally
from lostmotion.error_model.pose_matrix import screws
from lostmotion.error_model.poses import Poses, sample_poses
from lostmotion.error_model.provenance import States, states
from lostmotion.error_model.trust import with_figures
from lostmotion.io.arm_writer import NewParts, reads_back, sized_text
from lostmotion.mechanism.even_poses import corners
from lostmotion.mechanism.load_causes import LinkBending, bending
from lostmotion.mechanism.standing import standing_if_soft
from lostmotion.mechanism.state import as_poses, states_of
from lostmotion.sizing.links import LinkSize, link_size, one_pass, worse_poses

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping
    from pathlib import Path

    from lostmotion.mechanism.arm import Arm
    from lostmotion.sizing.candidates import LinkOptions
    from lostmotion.sizing.lightest import (
        Limits,
        SizedSection,
    )
    from lostmotion.spatial import Floats

# Factors on both limits in the trade-off, from a quarter to four.
SCALES: Final = tuple(2.0 ** (k / 2) for k in range(-4, 5))
_ROUNDS: Final = 6
_BLOCK: Final = 1024
_ERROR_POSES: Final = 512


@dataclass(frozen=True, slots=True)
class TradeOffPoint:
    """One point of the trade-off: factor on both limits, mass of the links (kg), r.m.s. tool error
    (m), and whether all limits are met.
    """

    scale: float
    mass: float
    rms_error: float
    meets_limits: bool


class SizedArmResult(Result):
    """Base of both results, an arm as stated and with its new parts. `source` and `sidecar` are the
    files of the arm; None where it was passed as an object.
    """

    arm: Arm
    sized: Arm
    source: Path | None
    sidecar: Path | None

    @property
    @abstractmethod
    def is_met(self) -> bool:
        """Return whether limits or target are met."""

    @property
    @abstractmethod
    def new_parts(self) -> list[NewParts]:
        """Return the new parts, by joint."""

    @property
    def states(self) -> States:
        """Return what is known of each joint of the sized arm: stated, assumed, or ideal, and the
        assumed values.
        """
        return states(self.sized)

    @property
    def failure(self) -> str:
        """Return the verdict where limits or target are not met; empty where they are."""
        return "" if self.is_met else self.sheet.verdict

    def files(self) -> dict[str, bytes]:
        """Return the sized arm as sized.toml: its file with the new parts, where limits or target
        are met and the file is known.
        """
        if self.source is None or not self.is_met:
            return {}
        return {"sized.toml": sized_text(self.source, self.sidecar, self).encode()}

    def further_files(self, folder: Path) -> Iterable[str]:
        """Return where the sized arm is, and what differs when it is read from there."""
        if self.source is not None and self.is_met:
            doubt = reads_back(self.source, folder / "sized.toml", self)
            yield f"Sized arm: {folder / 'sized.toml'}" + (f"; {doubt}" if doubt else "")


@dataclass(frozen=True, repr=False)
class Size(SizedArmResult):
    """An arm with links sized by limits.

    arm, sized    as stated, and with the selected sections
    q             (pose, joint) all poses: sampled, `given`, `corners` of the joint ranges, and
                  worse ones found by local search
    links         sized links, base to tip; unchanged: joints whose links were not sized
    rms_error, rms_error_before  r.m.s. tool error over the sampled poses, m, by exact sums over
                                 terms
    trade_off     from strict to loose limits
    validation    deflection of each link of the sized arm at `validation_poses` other poses, with
                  the base as stated: `load_causes.bending`
    """

    arm: Arm
    sized: Arm
    limits: Limits
    tilt: float | None
    poses: Poses
    given: int
    corners: int
    q: Floats
    links: tuple[LinkSize, ...]
    unchanged: tuple[str, ...]
    rms_error: float
    rms_error_before: float
    trade_off: tuple[TradeOffPoint, ...]
    validation: tuple[LinkBending, ...]
    validation_poses: int
    source: Path | None = None
    sidecar: Path | None = None

    @property
    def meets_limits(self) -> bool:
        """Return whether every sized link meets its limits."""
        return all(link.meets_limits for link in self.links)

    @property
    def is_met(self) -> bool:
        """Return whether every sized link meets its limits."""
        return self.meets_limits

    @property
    def new_parts(self) -> list[NewParts]:
        """Return the section of each sized link."""
        return [NewParts(link.joint, link.section) for link in self.links]

    @property
    def validated_utilisation(self) -> float:
        """Return the largest utilisation of a limit at the validation poses."""
        limits = {link.joint: link.limits for link in self.links}
        links = [link for link in self.validation if link.joint in limits]
        return max(
            (
                max(link.slope / limits[link.joint][0], link.deflection / limits[link.joint][1])
                for link in links
            ),
            default=0.0,
        )


def size_links(  # noqa: PLR0913 - a sizing is these numbers
    arm: Arm,
    options: Mapping[str, LinkOptions],
    limits: Limits,
    poses: Poses,
    *,
    tilt: float | None = None,
    step: float | None = 1e-4,
    also: Floats | None = None,
    progress: Callable[[str, int, int], None] | None = None,
) -> Size:
    """Return the arm with the lightest sections that meet the limits, and the trade-off for other
    limits.

    options  of the links to size, by the name of their joint
    poses    corners of the joint ranges are added, and worse poses found by local search from the
             worst ones
    tilt     rad, largest tilt of the base from level, towards any side
    step     m, step of free sizes; 0: continuous, None: usual sizes of tubes and bars
    also     (pose, joint) rad or m, additional poses

    A link for which no section meets the limits gets the one of least utilisation
    (`LinkSize.meets_limits`).
    """
    report = progress or (lambda *_: None)
    ends = corners(arm)
    given = np.zeros((0, ends.shape[1])) if also is None else as_poses(arm, also)
    q = np.vstack([poses.q, given, ends])
    start = sized = arm
    sections: dict[str, SizedSection] = {}
    for turn in range(_ROUNDS):
        report("sizing links", turn, _ROUNDS)
        before = {name: each.section for name, each in sections.items()}
        sized, sections = one_pass(start, options, limits, q, tilt, step)
        if not arm.tree.loads_are_outboard:
            start = sized
        worse = worse_poses(sized, options, limits, q, tilt)
        repeat = before == {name: each.section for name, each in sections.items()}
        if not len(worse) and (repeat or start is arm):
            break
        q = np.vstack([q, worse])
    links = tuple(
        link_size(arm, sized, name, limits, q, tilt, list(sections))
        for name in [joint.name for joint in arm.joints if joint.name in sections]
    )
    of_error = poses
    if poses.law != "given":
        of_error = with_figures(arm, sample_poses(arm, min(len(poses), _ERROR_POSES)))
    few = of_error.q
    trade_off = []
    for k, scale in enumerate(SCALES):
        report("trade-off of mass and error", k, len(SCALES))
        other, chosen = (
            (sized, sections)
            if scale == 1
            else one_pass(start, options, limits.scaled(scale), q, tilt, step)
        )
        trade_off.append(
            TradeOffPoint(
                scale,
                _mass(other, options),
                rms_error(other, few),
                all(each.meets_limits for each in chosen.values()),
            )
        )
    other_poses = sample_poses(arm, len(poses), seed=2) if poses.law != "given" else poses
    validation = bending(sized, other_poses.q, np.zeros((len(other_poses), 3)), 0.0)
    unchanged = tuple(
        joint.name for joint in arm.joints if joint.link.reach and joint.name not in options
    )
    return Size(
        arm,
        sized,
        limits,
        tilt,
        poses,
        len(given),
        len(ends),
        q,
        links,
        unchanged,
        rms_error(sized, few),
        rms_error(arm, few),
        tuple(trade_off),
        tuple(validation),
        len(other_poses),
    )


def rms_error(arm: Arm, q: Floats) -> float:
    """Return the r.m.s. tool error over these poses, m, by exact sums over terms; of a soft arm
    where it stands.
    """
    total = sum(
        Tally.of(screws(standing_if_soft(state))).total for _, state in states_of(arm, q, _BLOCK)
    )
    return math.sqrt(total / len(q))


def _mass(arm: Arm, options: Mapping[str, LinkOptions]) -> float:
    return sum(joint.link.total_mass for joint in arm.joints if joint.name in options)
