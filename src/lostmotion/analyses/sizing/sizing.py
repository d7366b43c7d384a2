"""Lightest sections of an arm's links that meet limits of slope and deflection, and the trade-off
between mass and tool error.

Condition (4) of S. Strutynskyi, R. Semenchuk 2021: the lightest section of each link with a slope
of at most 0.5' and a deflection of at most length/2500 under load at the worst pose. A link carries
only itself and what is outboard of it, so links sized from the tip inward have their final loads,
and one pass is exact. A heavier outboard link could make an inboard one lighter only where its
weight relieves that link; `LinkSize.relieved_by` names such links.
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
from lostmotion.io.arm_writer import NewParts, reads_back, sized_text
from lostmotion.mechanism.even_poses import corners
from lostmotion.mechanism.load_causes import LinkBending, bending
from lostmotion.mechanism.state import as_poses, states_of
from lostmotion.sizing.lightest import (
    SLACK,
    Limits,
    LinkTask,
    SizedSection,
    lightest,
    with_section,
)
from lostmotion.sizing.link_deflection import (
    LinkLoads,
    WorstDeflection,
    across,
    deflection_under,
)

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping
    from pathlib import Path

    from lostmotion.mechanism.arm import Arm
    from lostmotion.parts.material import Material
    from lostmotion.parts.profile import Section
    from lostmotion.parts.section import Plain
    from lostmotion.sizing.candidates import LinkOptions
    from lostmotion.spatial import Floats

# Factors on both limits in the trade-off, from a quarter to four.
SCALES: Final = tuple(2.0 ** (k / 2) for k in range(-4, 5))
_ROUNDS: Final = 6
_SHARPENED: Final = 2
_EXCESS: Final = 1e-6
_BLOCK: Final = 1024
_ERROR_POSES: Final = 512


@dataclass(frozen=True, slots=True)
class LinkSize:
    """One sized link; SI.

    before, section      section as stated (None: rigid, or by a matrix) and as selected, with
                         mass_before and mass of the link
    worst, worst_before  largest slope and deflection over poses and tilts, as sized under the new
                         loads, and as stated (None: rigid)
    limits               slope (rad) and deflection (m)
    meets_limits         where not, the section is the one of least utilisation
    force, moment        across the link on its tip, N and N m, at the worst pose of the governing
                         limit
    own_weight           N, component across the link there
    relieved_by          joints outboard whose sized links relieve this one there by their weight
    """

    joint: str
    length: float
    before: Section | None
    section: Plain
    mass_before: float
    mass: float
    worst: WorstDeflection
    worst_before: WorstDeflection | None
    limits: tuple[float, float]
    meets_limits: bool
    force: float
    moment: float
    own_weight: float
    relieved_by: tuple[str, ...]

    @property
    def utilisation(self) -> tuple[float, float]:
        """Return slope and deflection over their limits."""
        return self.worst.slope / self.limits[0], self.worst.deflection / self.limits[1]

    @property
    def governing(self) -> int:
        """Return the governing limit: 0 slope, 1 deflection."""
        return int(self.utilisation[1] > self.utilisation[0])

    @property
    def index(self) -> int:
        """Return the worst pose of the governing limit."""
        return self.worst.deflection_index if self.governing else self.worst.slope_index


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

    page = "sizing_page"

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
    sized = arm
    sections: dict[str, SizedSection] = {}
    for turn in range(_ROUNDS):
        report("sizing links", turn, _ROUNDS)
        sized, sections = _one_pass(arm, options, limits, q, tilt, step)
        worse = _worse_poses(sized, options, limits, q, tilt)
        if not len(worse):
            break
        q = np.vstack([q, worse])
    links = tuple(
        _link_size(arm, sized, name, limits, q, tilt, list(sections))
        for name in reversed(list(sections))
    )
    few = sample_poses(arm, min(len(poses), _ERROR_POSES)).q if poses.law != "given" else poses.q
    trade_off = []
    for k, scale in enumerate(SCALES):
        report("trade-off of mass and error", k, len(SCALES))
        other, chosen = (
            (sized, sections)
            if scale == 1
            else _one_pass(arm, options, limits.scaled(scale), q, tilt, step)
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
    """Return the r.m.s. tool error over these poses, m, by exact sums over terms."""
    total = sum(Tally.of(screws(state)).total for _, state in states_of(arm, q, _BLOCK))
    return math.sqrt(total / len(q))


def _mass(arm: Arm, options: Mapping[str, LinkOptions]) -> float:
    return sum(joint.link.total_mass for joint in arm.joints if joint.name in options)


def _with(arm: Arm, name: str, section: Plain, material: Material | None) -> Arm:
    joints = tuple(
        with_section(joint, section, material) if joint.name == name else joint
        for joint in arm.joints
    )
    return arm.model_copy(update={"joints": joints})


def _index(arm: Arm, name: str) -> int:
    return next(k for k, joint in enumerate(arm.joints) if joint.name == name)


def _one_pass(
    arm: Arm,
    options: Mapping[str, LinkOptions],
    limits: Limits,
    q: Floats,
    tilt: float | None,
    step: float | None,
) -> tuple[Arm, dict[str, SizedSection]]:
    """Return the arm with every link sized once, from the tip inward, and the sections in that
    order.
    """
    sized = arm
    sections: dict[str, SizedSection] = {}
    for k, joint in reversed(list(enumerate(arm.joints))):
        if joint.name in options:
            own = options[joint.name]
            task = LinkTask(joint, LinkLoads.of(sized, k, q, tilt), limits, own.material)
            sections[joint.name] = lightest(task, own.choice, step)
            sized = _with(sized, joint.name, sections[joint.name].section, own.material)
    return sized, sections


def _worse_poses(
    sized: Arm, options: Mapping[str, LinkOptions], limits: Limits, q: Floats, tilt: float | None
) -> Floats:
    """Return poses (pose, joint) near the worst ones with a larger utilisation above 1; none where
    there is none.
    """
    worse = []
    for k, joint in enumerate(sized.joints):
        if joint.name in options:
            task = LinkTask(joint, LinkLoads.of(sized, k, q, tilt), limits)
            ratios = task.utilisation(joint.elastic_link, task.loads)
            for measure in range(2):
                if ratios[:, measure].max() < 1 / 2:
                    continue
                for start in np.argsort(-ratios[:, measure], kind="stable")[:_SHARPENED]:
                    at, share = _local_maximum(sized, k, q[start], limits, tilt, measure)
                    if share > max(1.0, float(ratios[:, measure].max())) * (1 + _EXCESS):
                        worse.append(at)
    return np.array(worse).reshape(-1, q.shape[1])


def _local_maximum(
    arm: Arm, k: int, start: Floats, limits: Limits, tilt: float | None, measure: int
) -> tuple[Floats, float]:
    """Return the pose of largest utilisation near `start`, within the joint limits, and the
    utilisation.
    """
    from scipy.optimize import minimize

    joint = arm.joints[k]
    low, high = arm.limits.T
    width = high - low
    nudge = 1e-6

    def share(at: Floats) -> Floats:
        task = LinkTask(
            joint, LinkLoads.of(arm, k, np.clip(low + at * width, low, high), tilt), limits
        )
        return np.asarray(task.utilisation(joint.elastic_link, task.loads)[:, measure])

    def less(at: Floats) -> tuple[float, Floats]:
        steps = nudge * np.eye(len(at))
        values = share(np.vstack([at, at + steps, at - steps]))
        inside = np.minimum(at + nudge, 1) - np.maximum(at - nudge, 0)
        return -float(values[0]), -(values[1 : 1 + len(at)] - values[1 + len(at) :]) / inside

    best = minimize(
        less,
        (start - low) / width,
        jac=True,
        bounds=[(0, 1)] * len(low),
        method="L-BFGS-B",
        options={"maxiter": 40},
    )
    return np.clip(low + best.x * width, low, high), -float(best.fun)


def _link_size(
    arm: Arm, sized: Arm, name: str, limits: Limits, q: Floats, tilt: float | None, names: list[str]
) -> LinkSize:
    k = _index(arm, name)
    stated, joint = arm.joints[k], sized.joints[k]
    loads = LinkLoads.of(sized, k, q, tilt)
    link = joint.elastic_link
    worst = loads.worst(link)
    before = (
        None if stated.link.is_rigid else LinkLoads.of(arm, k, q, tilt).worst(stated.elastic_link)
    )
    length = joint.link.reach
    allowed = limits.slope, length / limits.deflection
    governing = int(worst.deflection / allowed[1] > worst.slope / allowed[0])
    index = worst.deflection_index if governing else worst.slope_index
    gravity = loads.worst_gravity(link, index, governing)
    load = loads.at_pose(index, gravity)
    moment, force, own = (
        float(np.linalg.norm(across(link) @ each))
        for each in (load[:3], load[3:6], joint.link.total_mass * load[6:])
    )
    return LinkSize(
        joint=name,
        length=length,
        before=stated.link.section,
        section=joint.link.section,  # type: ignore[arg-type]  # selected from plain ones
        mass_before=stated.link.total_mass,
        mass=joint.link.total_mass,
        worst=worst,
        worst_before=before,
        limits=allowed,
        meets_limits=worst.slope <= allowed[0] * (1 + _EXCESS)
        and worst.deflection <= allowed[1] * (1 + _EXCESS),
        force=force,
        moment=moment,
        own_weight=own,
        relieved_by=_relieved(sized, k, q[[index]], gravity, governing, names),
    )


def _relieved(
    arm: Arm, k: int, q: Floats, gravity: Floats, measure: int, names: list[str]
) -> tuple[str, ...]:
    """Return the sized joints outboard whose links relieve this one by their weight at this
    pose.
    """
    link = arm.joints[k].elastic_link
    carried = arm.tree.outboard(arm.tree.joints[k].tip)

    def deflection(some: Arm) -> Floats:
        loads = LinkLoads.of(some, k, q, math.pi)
        return deflection_under(link, loads.at_pose(0, gravity), measure)

    total = deflection(arm)
    out = []
    for name in names:
        at = _index(arm, name)
        if arm.tree.joints[at].seat in carried:
            joint = arm.joints[at]
            weightless = joint.model_copy(
                update={"link": joint.link.model_copy(update={"mass": 0.0})}
            )
            without = arm.model_copy(
                update={"joints": (*arm.joints[:at], weightless, *arm.joints[at + 1 :])}
            )
            part = total - deflection(without)
            if part @ total < -SLACK * (total @ total):
                out.append(name)
    return tuple(out)
