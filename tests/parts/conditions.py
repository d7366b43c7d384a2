"""What the tests of parts share: conditions at a place, what terms add up to for given draws, and
the way to the tool.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from lostmotion.error_model.closing import mean_and_change, standardised
from lostmotion.error_model.pose_matrix import screws
from lostmotion.mechanism.state import state_of
from lostmotion.parts.joint import PrismaticJoint, RevoluteJoint
from lostmotion.parts.term import Condition, Draw, Holding, Level, Motion, Term, level_of

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Sequence

    from lostmotion.mechanism.arm import Arm
    from lostmotion.mechanism.placed_terms import PlacedTerm
    from lostmotion.parts.error_source import ErrorSource
    from lostmotion.spatial import Floats

TURN_Z = np.array([0, 0, 1.0, 0, 0, 0])
SLIDE_Z = np.array([0, 0, 0, 0, 0, 1.0])
ARCMIN = np.pi / 180 / 60
STEEL = {"young": 210e9, "poisson": 0.3, "density": 7850.0}


@dataclass(frozen=True)
class Place:
    """What a place feels, pose first, and the joint that it belongs to."""

    angle: Floats
    axis: Floats
    wrench: Floats
    gravity: Floats
    approach: float
    holding: Callable[[], Holding] = Holding


@dataclass(frozen=True)
class Evaluated:
    """A term with its screw (pose, 6) at a place; a sided one with its side where the approach is
    known.

    closed  (pose,) share of robots whose play is closed, on what that changes from robot to robot
    """

    term: Term
    screw: Floats
    visit: Draw | None
    closed: Floats | None = None

    @property
    def name(self) -> str:
        """Return the term's name."""
        return self.term.name

    @property
    def robot(self) -> Draw | None:
        """Return what is drawn per robot."""
        return self.term.robot

    @property
    def level(self) -> Level:
        """Return the level of chance, with the side that is known."""
        return level_of(self.robot if self.closed is None else self.term.form, self.visit)

    @property
    def bound(self) -> float:
        """Return the largest size of the draws."""
        return math.prod(draw.law.bound for draw in (self.robot, self.visit) if draw is not None)


def condition(
    wrench: Sequence[float] | Floats = (0, 0, 0, 0, 0, 0),
    *,
    axis: Floats = TURN_Z,
    angle: float | Floats = 0.0,
    gravity: Sequence[float] = (0, 0, -9.80665),
    approach: float = 0.0,
) -> Place:
    """Say what a place feels: one pose, or as many as there are wrenches or angles."""
    loads = np.atleast_2d(np.asarray(wrench, dtype=float))
    angles = np.atleast_1d(np.asarray(angle, dtype=float))
    poses = max(len(loads), len(angles))
    return Place(
        np.broadcast_to(angles, poses).copy(),
        axis,
        np.broadcast_to(loads, (poses, 6)).copy(),
        np.broadcast_to(np.asarray(gravity, dtype=float), (poses, 3)).copy(),
        approach,
    )


def terms_at(part: ErrorSource, place: Place) -> list[Evaluated]:
    """Evaluate the terms of a part at a place."""
    at = Condition(place.angle, place.wrench.T, place.gravity.T)
    out = []
    for term in part.terms(Motion(place.axis, place.holding)):
        known = term.sided and place.approach
        screw, visit = (
            term.scale * term.form.screw(at).T * (-place.approach if known else 1.0),
            None if known else term.visit,
        )
        friction = term.form.threshold
        if friction is None:
            out.append(Evaluated(term, screw, visit))
            continue
        closed = friction.share(at)
        mean, changed = mean_and_change(closed, above=term.form.above)
        out += [
            Evaluated(term, screw * mean[:, None], visit),
            Evaluated(term, screw * changed[:, None], visit, closed),
        ]
    return out


def gearbox(**fields: object) -> ErrorSource:
    """Return a reducer on a turning joint."""
    made = RevoluteJoint(name="A", limits=(-1, 1), gearbox=fields).gearbox
    assert made is not None
    return made


def screw_drive(**fields: object) -> ErrorSource:
    """Return a drive on a sliding joint."""
    made = PrismaticJoint(name="A", limits=(0, 1), gearbox=fields).gearbox
    assert made is not None
    return made


def encoder(**fields: object) -> ErrorSource:
    """Return an encoder on a turning joint."""
    made = RevoluteJoint(name="A", limits=(-1, 1), encoder=fields).encoder
    assert made is not None
    return made


def design(found: Iterable[Evaluated], poses: int = 1) -> Floats:
    """Add up what follows from the pose alone (pose, 6)."""
    out = np.zeros((poses, 6))
    for term in found:
        if term.level == "design":
            out = out + term.screw
    return out


def drawn(found: Iterable[Evaluated], draws: int, seed: int = 0, poses: int = 1) -> Floats:
    """Add up all terms for so many robots at one visit each (draw, pose, 6); terms that name one
    stream share its uniforms.
    """
    rng = np.random.default_rng(seed)
    streams: dict[tuple[str, str], Floats] = {}
    out = np.zeros((draws, poses, 6))
    for term in found:
        weight = np.ones(draws)
        for level, draw in (("robot", term.robot), ("visit", term.visit)):
            if draw is not None:
                u = streams.setdefault((level, draw.stream), rng.uniform(1e-12, 1 - 1e-12, draws))
                weight = weight * draw.law.quantile(u)
        there = np.ones((draws, 1))
        if term.closed is not None and term.term.form.threshold is not None:
            u = streams.setdefault(
                ("closing", term.term.form.threshold.stream), rng.uniform(1e-12, 1 - 1e-12, draws)
            )
            there = standardised(u[:, None], term.closed)
        out = out + (weight[:, None] * there)[:, :, None] * np.broadcast_to(term.screw, (poses, 6))
    return out


def visit_size(found: Iterable[Evaluated]) -> float:
    """Return the largest entry of all that differs from visit to visit."""
    return max(
        (float(np.abs(term.screw).max()) for term in found if term.visit is not None), default=0.0
    )


def local_screws(
    arm: Arm, q: Sequence[float] | Floats, *, approach: float = 0.0
) -> list[tuple[PlacedTerm, Floats]]:
    """Return every term of an arm with its screw (pose, 6) in the frame of its place."""
    matrix = screws(state_of(arm, np.asarray(q, dtype=float)), approach=approach)
    return [(column.of, matrix.local[:, :, k]) for k, column in enumerate(matrix.infos)]


def at_tool(
    arm: Arm, q: Sequence[float], *, approach: float = 0.0
) -> list[tuple[PlacedTerm, Floats]]:
    """Carry every term of one pose to the tool: (term, twist (6,)) of the tool point, in the base's
    axes.
    """
    matrix = screws(state_of(arm, np.array([q], dtype=float)), approach=approach)
    at = matrix.state.frames[:, 0]

    def carried(frame: Floats, screw: Floats) -> Floats:
        turn, shift = frame[:3, :3] @ screw[:3], frame[:3, :3] @ screw[3:]
        return np.concatenate([turn, shift + np.cross(turn, at[-1, :3, 3] - frame[:3, 3])])

    return [
        (column.of, carried(at[place], screw))
        for column, place, screw in zip(matrix.infos, matrix.place, matrix.local[0].T, strict=True)
    ]


def only(found: list, name: str) -> np.ndarray:
    """Return the screw of the one term of this name."""
    (term,) = [term for term in found if term.name == name]
    return np.broadcast_to(term.screw, (1, 6))[0] * term.bound
