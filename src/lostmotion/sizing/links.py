"""Links of an arm sized from the tip inward, at the poses where they are worst."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.mechanism.assembly import assembled
from lostmotion.mechanism.leg_copies import leg_copies
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
    from collections.abc import Mapping

    from lostmotion.mechanism.arm import Arm
    from lostmotion.parts.material import Material
    from lostmotion.parts.profile import Section
    from lostmotion.parts.section import Plain
    from lostmotion.sizing.candidates import LinkOptions
    from lostmotion.spatial import Floats

_SHARPENED: Final = 2
_EXCESS: Final = 1e-6


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


def _with(arm: Arm, name: str, section: Plain, material: Material | None) -> Arm:
    joints = tuple(
        with_section(joint, section, material) if joint.name == name else joint
        for joint in arm.joints
    )
    return arm.model_copy(update={"joints": joints})


def _index(arm: Arm, name: str) -> int:
    return next(k for k, joint in enumerate(arm.joints) if joint.name == name)


def one_pass(
    arm: Arm,
    options: Mapping[str, LinkOptions],
    limits: Limits,
    q: Floats,
    tilt: float | None,
    step: float | None,
) -> tuple[Arm, dict[str, SizedSection]]:
    """Return the arm with every link sized once, from the tip inward, and the sections in that
    order; links that are copies of each other, with equal options, have one section.
    """
    sized = arm
    copies = leg_copies(arm, "link")
    sections: dict[str, SizedSection] = {}
    for joint in reversed(arm.joints):
        own = options.get(joint.name)
        equal_links = [name for name in copies[joint.name] if options.get(name) == own]
        if own is not None and joint.name == equal_links[0]:
            loads = [LinkLoads.of(sized, _index(arm, name), q, tilt) for name in equal_links]
            task = LinkTask(joint, LinkLoads.together(loads), limits, own.material)
            found = lightest(task, own.choice, step)
            for name in reversed(equal_links):
                sections[name] = found
                sized = _with(sized, name, found.section, own.material)
    return sized, sections


def worse_poses(
    sized: Arm, options: Mapping[str, LinkOptions], limits: Limits, q: Floats, tilt: float | None
) -> Floats:
    """Return poses (pose, joint) near the worst ones with a larger utilisation above 1; none where
    there is none, and none of an arm whose poses lie in a box of the tool: the search could leave
    it.
    """
    worse: list[Floats] = []
    for k, joint in enumerate(sized.joints):
        if joint.name in options and sized.workspace is None:
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
    utilisation; a pose at which a closed chain is not assembled has none.
    """
    from scipy.optimize import minimize

    joint = arm.joints[k]
    low, high = arm.limits.T
    width = high - low
    nudge = 1e-6

    def share(at: Floats) -> Floats:
        q = np.clip(low + at * width, low, high)
        inside, out = assembled(arm, q), np.zeros(len(q))
        if inside.any():
            task = LinkTask(joint, LinkLoads.of(arm, k, q[inside], tilt), limits)
            out[inside] = task.utilisation(joint.elastic_link, task.loads)[:, measure]
        return out

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


def link_size(
    arm: Arm, sized: Arm, name: str, limits: Limits, q: Floats, tilt: float | None, names: list[str]
) -> LinkSize:
    """Return the sized link of a joint, with its worst pose and the loads there; `names` are the
    sized joints.
    """
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
