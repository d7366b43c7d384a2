"""The state of an arm at poses: where its places are, what acts on them, and how far that deflects
it. Whatever needs a frame, a wrench or a carry matrix takes a State.
"""

from __future__ import annotations

import functools
import itertools
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.mechanism.carry import carry
from lostmotion.mechanism.closed_chain import assembled_frames, closed_statics, taken_up
from lostmotion.mechanism.closed_composition import composed
from lostmotion.mechanism.conditions import Conditions, springs_under
from lostmotion.mechanism.elastostatics import Compliances, elastic_terms, sagging_terms
from lostmotion.mechanism.equilibrium import settle
from lostmotion.mechanism.frames import place_frames, steps_between, tool_point
from lostmotion.mechanism.load_changes import tangent
from lostmotion.mechanism.wrenches import place_wrenches, process_wrenches, weights_by_axis
from lostmotion.spatial import exp, mapped

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Sequence

    from numpy.typing import NDArray

    from lostmotion.mechanism.arm import Arm
    from lostmotion.mechanism.closed_statics import Loops
    from lostmotion.mechanism.equilibrium import Equilibrium
    from lostmotion.mechanism.placed_terms import PlacedTerm
    from lostmotion.parts.term import Condition
    from lostmotion.spatial import Floats

# Poses evaluated at a time: their arrays fit into the processor's cache, and most of the time of
# fewer poses does not depend on their number. What asks for the same poses in the same blocks finds
# states and pose matrices that are kept. A multiple of the tile of `propagation.error_magnitude`.
BLOCK: Final = 512
# Number of poses up to which the terms of a place are carried together.
_FEW: Final = 16


@dataclass(frozen=True, eq=False, repr=False)
class State:
    """An arm at some poses. Built by `state_of`; its arrays are read-only, and what follows from
    them is computed when it is first needed.

    q        (pose, joint) values of the driven joints, rad or m
    frames   (place, pose, 4, 4) frames of the places in the base's frame, m, in the order of
             `arm.places`
    gravity  (3,) acceleration of free fall in the base's axes, m/s^2
    equilibrium  how a settled state was found; None for one that does not deflect

    Wrenches, torques and compliances are those of a mechanism that stands in these frames.
    """

    arm: Arm
    q: Floats
    frames: Floats
    gravity: Floats
    equilibrium: Equilibrium | None = None

    def __post_init__(self) -> None:
        """Protect the arrays from changes, which what was computed from them would not follow."""
        for name in ("q", "frames", "gravity"):
            protected = getattr(self, name).view()
            protected.flags.writeable = False
            object.__setattr__(self, name, protected)

    def __len__(self) -> int:
        """Return the number of poses."""
        return len(self.q)

    @property
    def commanded(self) -> Floats:
        """Return the frames (place, pose, 4, 4) to which the arm is commanded, m."""
        return self.frames if self.equilibrium is None else self.equilibrium.command

    def rows(self, rows: slice | NDArray[np.int64]) -> State:
        """Return the state at the poses in these rows."""
        return replace(
            self,
            q=self.q[rows],
            frames=self.frames[:, rows],
            equilibrium=None if self.equilibrium is None else self.equilibrium.rows(rows),
        )

    def settled(self) -> State:
        """Return the state in which the arm stands under its loads when it is commanded to this
        one: its frames are those of the deflected arm, q is still the command.

        Every design term moves its place by its screw at the load and the frame of the deflected
        arm. Where there is no stable equilibrium, the frames are NaN and `equilibrium.falls_at` is
        the place that cannot hold. A settled state is returned as it is, and that of a closed
        chain, whose deflection is of first order. The side of a play that no load closes takes no
        part: it adds a constant turn, which the pose matrix carries with the loads that follow.
        """
        if self.equilibrium is not None or self.arm.closures:
            return self
        found = settle(self.arm.tree, self.frames, DesignDeflection(self))
        return replace(self, frames=found.frames, equilibrium=found)

    @functools.cached_property
    def wrenches(self) -> Floats:
        """Return the static wrench on each place from everything outboard of it (place, pose, 6) in
        the place's own frame, N m and N.

        The loads are the weights of links, joints, tool and payload, and the process force and
        moment. The mass of a joint, or of its gearbox where none is stated, is on its seat with the
        housing. So it loads the previous link and not its own bearing.
        """
        if self.closed is not None:
            return self.closed[1]
        return place_wrenches(self.arm.tree, self.frames, self.arm.payload, self.gravity)

    @functools.cached_property
    def closed(self) -> tuple[Loops, Floats] | None:
        """Return the closures of a closed chain, and the wrenches on its places; None without."""
        arm = self.arm
        if not arm.tree.welds:
            return None
        open_tree = place_wrenches(arm.tree, self.frames, arm.payload, self.gravity)
        springs = functools.partial(springs_under, self)
        return closed_statics(arm.tree, self.frames, open_tree, springs, arm.open_ways)

    @functools.cached_property
    def weights_by_axis(self) -> Floats:
        """Return the wrenches of all weights per unit of gravity along each axis of the base; shape
        and unit as `wrenches.weights_by_axis`.
        """
        by_axis = weights_by_axis(self.arm.tree, self.frames, self.arm.payload)
        if self.closed is None:
            return by_axis
        return np.stack([self.closed[0].wrenches(each) for each in by_axis])

    @functools.cached_property
    def process_wrenches(self) -> Floats:
        """Return the part of `wrenches` by the process force and moment."""
        process = process_wrenches(self.arm.tree, self.frames, self.arm.payload)
        return process if self.closed is None else self.closed[0].wrenches(process)

    @functools.cached_property
    def torques(self) -> Floats:
        """Return the torque (force on a sliding joint) that each drive must hold (pose, joint), N m
        or N, positive along the joint's motion.
        """
        return np.column_stack(
            [
                -mapped(joint.twist, self.wrenches[place])
                for joint, place in zip(self.arm.driven, self.arm.tree.moved, strict=True)
            ]
        )

    def conditions(self) -> Conditions:
        """Return what acts on each part: joint value, wrench and gravity at its place."""
        return Conditions(self)

    def carry(self, place: int) -> Floats:
        """Return the twist of the tool about the tool point, in the base's axes, per twist at a
        place in its own axes (pose, 6, 6); zero for a place that does not carry the tool.

        The transpose is the wrench at the place per wrench on the tool (virtual work).
        """
        if self.closed is not None:
            return self.closed[0].carry(place)
        return carry(self.arm.tree, self.frames, place)

    def tool_twists(self, place: NDArray[np.int64], local: Floats) -> Floats:
        """Return the tool's twists (6, term, pose), rad and m, about the tool point in the base's
        axes, for twists `local` (6, term, pose).

        place  (term,) index of the place in whose axes each local twist is stated, in groups of
               equal indices
        local  (6, term, pose) rad and m

        The order of the sum does not depend on the number of poses. Components of a twist that are
        zero at all poses are skipped.
        """
        out = np.zeros_like(local)
        filled = np.asarray(local.any(axis=2))
        first = 0
        for number, group in itertools.groupby(place.tolist()):
            if self.closed is not None:
                taken_up(self.arm.tree, self.closed[0], number, local[:, place == number])
            matrix = self.carry(number).transpose(1, 2, 0)
            turns = np.asarray(matrix[:3].any(axis=(0, 2)))
            last = first + sum(1 for _ in group)
            # At few poses a loop over terms costs more than products with zeros, which change no
            # bit.
            together = last - first if local.shape[2] <= _FEW else 1
            for k in range(first, last, together):
                terms = slice(k, k + together)
                for j in np.flatnonzero(filled[:, terms].any(axis=1)):
                    rows = slice(0 if turns[j] else 3, 6)
                    out[rows, terms] += matrix[rows, None, j] * local[j, terms]
            first = last
        return out

    def composed(self, places: Sequence[int], twists: Floats) -> Floats:
        """Return the exact frames of the tool (pose, sample, 4, 4), m, with places displaced by
        twists (place, pose, sample, 6) in their own axes, rad and m.

        Every place moves by the exponential of its twist, and the frames are multiplied along the
        chain from the base to the tool; places on a branch do not move the tool. `places` are in
        rising order. The geometry is exact for displacements of any size.
        """
        if self.closed is not None:
            return composed(self.closed[0], dict(zip(places, twists, strict=True)))
        on_path = [k for k, place in enumerate(places) if place in self.arm.tree.tool_path]
        # Fixed steps from each place to the next one, and from the last one to the tool.
        *steps, last = steps_between(self.frames[[*(places[k] for k in on_path), -1]])
        here = np.broadcast_to(np.eye(4), (*twists.shape[1:3], 4, 4))
        for step, moved in zip(steps, exp(twists[on_path]), strict=True):
            here = here @ (step[:, None] @ moved)
        return np.asarray(here @ last[:, None])

    @functools.cached_property
    def compliances(self) -> Compliances:
        """Return the compliance contribution of each part.

        Each contribution is the tangent at the load that the part carries. It is exact, except for
        bearings described by drawings: their tables are differentiated over ±0.1 % of the load. An
        unloaded rolling contact has no stiffness; it is evaluated at a load of one millinewton.
        """
        springs = elastic_terms(self.arm)
        parts = tuple(dict.fromkeys(placed.owner for placed in springs))
        by_part = np.zeros((len(parts), len(self), 6, 6))
        for placed, carried, condition in self._carried(springs):
            own = placed.term.scale * placed.term.form.compliance(condition)
            by_part[parts.index(placed.owner)] += carried @ own @ carried.transpose(0, 2, 1)
        return Compliances(parts, by_part, np.array(self.frames[-1, :, :3, 3]))

    @property
    def compliance(self) -> Floats:
        """Return the twist of the tool per wrench on it (pose, 6, 6), rad and m per N m and N.

        Symmetric and positive semidefinite where the compliances of all parts are (reciprocity).
        """
        return self.compliances.whole

    @property
    def sag(self) -> Floats:
        """Return rotation and displacement of the tool (pose, 6; rad, m) by which the arm's own
        loads deflect its parts, first order.

        The loads are the weights of arm and payload, and the process force, in these frames; of the
        weights' torque a servo's controller takes off what it feeds forward. Plays stay as they
        are.
        """
        out = np.zeros((len(self), 6))
        for placed, carried, condition in self._carried(sagging_terms(self.arm)):
            moved = placed.term.scale * placed.term.form.screw(condition)
            out += np.einsum("pij,jp->pi", carried, moved)
        return out

    def deflection(self, wrench: Floats) -> Floats:
        """Return rotation and displacement of the tool (pose, 6; rad, m) due to this wrench in
        addition to the arm's own loads.

        wrench  (6,) or (pose, 6): moment and force at the tool point in the base's axes, N m and N

        The deflection of each part is evaluated with and without the wrench. So stiffness zones and
        contacts are included over the full change of load, not by their tangent. For linear springs
        the result is compliance @ wrench; for a rigid arm it is zero.
        Raises ValueError for a wrench of another shape or not finite.
        """
        load = np.asarray(wrench, dtype=float)
        if load.shape not in {(6,), (len(self), 6)} or not np.isfinite(load).all():
            raise ValueError(
                f"a wrench of shape {load.shape}; expected 6 finite values, moment and force, or "
                "as many per pose"
            )
        load = np.broadcast_to(load, (len(self), 6))
        out = np.zeros((len(self), 6))
        springs = elastic_terms(self.arm)
        for placed, carried, before in self._carried(springs):
            added = np.einsum("pji,pj->ip", carried, load)
            more = replace(before, wrench=before.wrench + added)
            form = placed.term.form
            moved = placed.term.scale * (form.screw(more) - form.screw(before))
            out += np.einsum("pij,jp->pi", carried, moved)
        return out

    def _carried(
        self, terms: Iterable[PlacedTerm]
    ) -> Iterator[tuple[PlacedTerm, Floats, Condition]]:
        """Yield each of these terms with the carry matrix and the condition of its place."""
        conditions = self.conditions()
        for place, group in itertools.groupby(terms, lambda each: each.place):
            carried = self.carry(place)
            for placed in group:
                yield placed, carried, conditions(placed)


class DesignDeflection:
    """How the parts of an arm deflect in other frames than those of its state."""

    def __init__(self, state: State, terms: Iterable[PlacedTerm] | None = None) -> None:
        """Take a state at the same poses; `terms` that deflect, by default all design terms."""
        self._state, self.freedoms = state, state.arm.soft_freedoms
        every = state.arm.terms if terms is None else terms
        self._terms = [each for each in every if each.term.level == "design"]
        self._last: tuple[Floats, State, Conditions] | None = None

    def within(self, frames: Floats, rows: NDArray[np.int64]) -> tuple[State, Conditions]:
        """Return state and conditions in other frames; the last are kept, which both use below."""
        if self._last is None or self._last[0] is not frames:
            state = replace(self._state, q=self._state.q[rows], frames=frames)
            self._last = frames, state, state.conditions()
        return self._last[1:]

    def twists(
        self, frames: Floats, rows: NDArray[np.int64], *, play: bool = True
    ) -> tuple[Floats, Floats]:
        """Return the twists of design terms as `Deflection.twists`."""
        smooth, in_play = np.zeros((2, *frames.shape[:2], 6))
        _, conditions = self.within(frames, rows)
        for placed in self._terms:
            form = placed.term.form
            if form.jumps and not play:
                continue
            screw = placed.term.scale * form.screw(conditions(placed))
            if form.threshold is not None:
                share = form.threshold.share(conditions(placed))
                screw *= share if form.above else 1 - share
            (in_play if form.jumps else smooth)[placed.place] += screw.T
        return smooth, in_play

    def tangent(self, frames: Floats, rows: NDArray[np.int64]) -> tuple[Floats, Floats]:
        """Return what `Deflection.tangent` does."""
        return tangent(*self.within(frames, rows), self.freedoms)


def as_poses(arm: Arm, q: Floats) -> Floats:
    """Return the values of the driven joints as (pose, joint). Raises ValueError for another shape
    or a value that is not finite.
    """
    values = np.atleast_2d(np.asarray(q, dtype=float))
    if values.ndim != 2 or values.shape[1] != len(arm.driven):  # noqa: PLR2004 - pose and joint
        raise ValueError(
            f"q has shape {np.shape(q)}; expected (pose, {len(arm.driven)}): one value per "
            f"driven joint of '{arm.name}'"
        )
    if not np.isfinite(values).all():
        raise ValueError("q has a value that is not finite")
    return values


def state_of(
    arm: Arm, q: Floats, *, frames: Floats | None = None, gravity: Floats | None = None
) -> State:
    """Return the state of an arm at these poses.

    q        (pose, joint) values of the driven joints, rad or m; the joint limits are not applied
    frames   (place, pose, 4, 4) where the places stand, m, in the order of `arm.places`; by default
             where the nominal geometry has them
    gravity  (3,) acceleration of free fall in the base's axes, m/s^2; by default the arm's, at the
             base's nominal tilt

    Raises ValueError for q or frames of another shape or not finite. Frames, wrenches and torques
    equal Pinocchio's (tests/validation).
    """
    values = np.array(as_poses(arm, q))
    free_fall = arm.gravity_in_base if gravity is None else np.array(gravity, dtype=float)
    if frames is None:
        place = assembled_frames if arm.closures else place_frames
        return State(arm, values, place(arm.tree, values), free_fall)
    stands = np.array(frames, dtype=float)
    shape = (len(arm.places), len(values), 4, 4)
    if stands.shape != shape or not np.isfinite(stands).all():
        raise ValueError(f"frames of shape {stands.shape}; expected {shape}, all of them finite")
    return State(arm, values, stands, free_fall)


def states_of(arm: Arm, q: Floats, size: int = BLOCK) -> Iterator[tuple[slice, State]]:
    """Yield the rows of q and the state there, for at most `size` poses at a time; arguments and
    errors as `state_of`.
    """
    for here, values in blocks_of(as_poses(arm, q), size):
        yield here, state_of(arm, values)


def blocks_of(q: Floats, size: int = BLOCK) -> Iterator[tuple[slice, Floats]]:
    """Yield the rows of q and the poses there, at most `size` at a time."""
    for start in range(0, len(q), size):
        here = slice(start, min(start + size, len(q)))
        yield here, q[here]


def tool_points(arm: Arm, q: Floats) -> Floats:
    """Return the tool point (pose, 3), m, in the base's frame; arguments and errors as `state_of`.
    Equal to that of the last frame, in a fraction of its time.
    """
    values = as_poses(arm, q)
    if not arm.closures:
        return tool_point(arm.tree, values)
    blocks = [values[k : k + BLOCK] for k in range(0, len(values), BLOCK)]
    return np.concatenate([assembled_frames(arm.tree, each)[-1, :, :3, 3] for each in blocks])
