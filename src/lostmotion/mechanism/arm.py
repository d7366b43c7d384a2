"""Description of an arm: joints, links, base, tool and payload, and the places that they define."""

from __future__ import annotations

import functools
from collections import Counter
from typing import TYPE_CHECKING, Annotated, ClassVar, Final, Self

import numpy as np
from pydantic import Field, PrivateAttr, model_validator
from pydantic_core import PydanticCustomError

from lostmotion.errors import nearest, shown
from lostmotion.mechanism.calibration import Calibration
from lostmotion.mechanism.closed_box import box_error, closed_remarks
from lostmotion.mechanism.closed_chain import assembly_error, closing_error
from lostmotion.mechanism.closures import Closure
from lostmotion.mechanism.holding import holding_loads
from lostmotion.mechanism.load_gradient import soft_freedoms
from lostmotion.mechanism.opened_constraints import ways_of
from lostmotion.mechanism.placed_terms import PlacedPart, PlacedTerm, placed_parts
from lostmotion.mechanism.places import misplaced, tool_moves, tree_of
from lostmotion.mechanism.remarks import remarks_on, remarks_on_ranges, temperature_remarks
from lostmotion.mechanism.shape import Body, bodies_of
from lostmotion.mechanism.tool import Payload, Tool
from lostmotion.mechanism.workspace_box import WorkspaceBox
from lostmotion.parts.bands import unknown_values
from lostmotion.parts.base import Base
from lostmotion.parts.environment import Environment
from lostmotion.parts.error_source import Line, Part
from lostmotion.parts.joint import Joint, PrismaticJoint, RevoluteJoint, has_axis
from lostmotion.units import Quantity

if TYPE_CHECKING:
    from collections.abc import Iterable

    from lostmotion.mechanism.calibration import Correlations
    from lostmotion.mechanism.load_gradient import Freedom
    from lostmotion.mechanism.opened_constraints import Way
    from lostmotion.mechanism.places import Tree
    from lostmotion.parts.error_source import Friction
    from lostmotion.parts.term import Holding
    from lostmotion.spatial import Floats

STANDARD_GRAVITY = 9.80665
# Mass (kg) at the arm's reach that every joint is assumed to hold at least, where friction is not
# stated.
_LEAST_MASS: Final = 0.1
LONGEST_NAME: Final = 80
LONGEST_NOTE: Final = 300
MOST_NOTES: Final = 200
MOST_JOINTS: Final = 64


class Arm(Part):
    """An arm from base to tool, with any number of joints; branches may be attached to it, and
    closures may join them to closed loops.

    Places are listed in the order of the joints: "base", then for each joint NAME its seat
    "NAME.seat" (before the motion), "NAME" (after it) and "NAME.tip" (the far end of its link), and
    last "tool". q has one value per driven joint, in rad or m, in the order of the joints.

    joints   in order from the base
    closures  pairs of places on different branches that are one frame
    base     place and tilt of the foot, with its errors
    tool     tool frame and mass of the tool
    payload  mass held by the tool, and the process force and moment
    gravity  magnitude of the acceleration of free fall, m/s^2
    environment  temperature at which the arm works
    workspace  box of the tool of a closed chain in which poses are sampled
    notes    text that is repeated with every result
    """

    shareable: ClassVar[bool] = False
    name: Annotated[Line, Field(min_length=1, max_length=LONGEST_NAME)]
    joints: Annotated[tuple[Joint, ...], Field(min_length=1, max_length=MOST_JOINTS)]
    closures: Annotated[tuple[Closure, ...], Field(max_length=MOST_JOINTS)] = ()
    base: Base = Base()
    tool: Tool = Tool()
    payload: Payload = Payload()
    gravity: Annotated[float, Quantity("m/s^2", "9.81 m/s^2", low=0)] = STANDARD_GRAVITY
    environment: Environment = Environment()
    workspace: WorkspaceBox | None = None
    notes: Annotated[
        tuple[Annotated[Line, Field(max_length=LONGEST_NOTE)], ...], Field(max_length=MOST_NOTES)
    ] = ()

    _warnings: tuple[str, ...] = PrivateAttr(())
    _calibration: Calibration | None = PrivateAttr(None)
    _open: tuple[str, str] = PrivateAttr(("", ""))

    @model_validator(mode="after")
    def _has_a_mechanism(self) -> Self:
        twice = sorted(
            name
            for name, times in Counter(joint.name for joint in self.joints).items()
            if times > 1
        )
        if twice:
            expected, example = "a name of its own for every joint", f'name = "{twice[0]}2"'
            raise _refusal(f"the joint name '{twice[0]}' more than once", expected, example)
        if not self.driven:
            raise _refusal(
                "no joint that moves",
                "at least one revolute or prismatic joint",
                'type = "revolute"',
            )
        wrong = misplaced(self.joints, self.tool)
        if wrong:
            (path, after, known), *others = wrong
            near = nearest(after, known)
            found = (
                f"{' and '.join(shown(each) for each in (after, *(other.after for other in others)))}, "  # noqa: E501
                "not exactly one earlier place"
            )
            expected = '"base", or NAME.seat, NAME or NAME.tip of an earlier joint'
            raise _refusal(found, expected, f'after = "{near or known[-1]}"', near, path)
        if not tool_moves(self.joints, self.tool):
            expected = "at least one moving joint between the base and the tool"
            raise _refusal(
                "a tool that no joint moves",
                expected,
                f'[tool] with after = "{self.moving[-1].name}.tip"',
                "",
                ("tool", "after"),
            )
        return self

    @model_validator(mode="after")
    def _closes(self) -> Self:
        wrong = closing_error(self.joints, self.closures)
        wrong = wrong or (assembly_error(self.joints, self.tree) if self.closures else None)
        wrong = wrong or (box_error(self.tree, self.workspace) if self.workspace else None)
        if wrong:
            raise _refusal(*wrong[1:], path=wrong[0])
        return self

    @model_validator(mode="after")
    def _has_bearings_for_its_temperature(self) -> Self:
        for k, joint in enumerate(self.joints):
            bearing = getattr(joint, "bearing", None)
            problem = None if bearing is None else bearing.temperature_error(self.environment.rise)
            if problem:
                found, expected, example = problem
                raise _refusal(found, expected, example, path=("joints", k, "bearing"))
        return self

    @functools.cached_property
    def moving(self) -> tuple[RevoluteJoint | PrismaticJoint, ...]:
        """Return the joints that turn about or slide along one axis, in the order of `joints`."""
        return tuple(joint for joint in self.joints if has_axis(joint))

    @functools.cached_property
    def driven(self) -> tuple[RevoluteJoint | PrismaticJoint, ...]:
        """Return the joints with a drive, in the order of the columns of q."""
        return tuple(joint for joint in self.moving if not joint.passive)

    @functools.cached_property
    def tree(self) -> Tree:
        """Return the places with their parents, and the masses on them."""
        return tree_of(self.base.foot, self.joints, self.tool, self.closures)

    @functools.cached_property
    def places(self) -> tuple[str, ...]:
        """Return the names of the places, in the order of `frames` and `wrenches`."""
        return tuple(place.name for place in self.tree.places)

    @functools.cached_property
    def bodies(self) -> tuple[Body, ...]:
        """Return the bodies that pictures of the arm show, each fixed to a place."""
        return bodies_of(self.tree, self.joints, self.payload)

    @functools.cached_property
    def _working_joints(self) -> tuple[Joint, ...]:
        """Return the joints with their drawn gearboxes at the temperature of the arm."""
        return tuple(joint.at_temperature(self.environment.rise) for joint in self.joints)

    @functools.cached_property
    def parts(self) -> tuple[PlacedPart, ...]:
        """Return the parts with errors, each with its place, in the order of the places."""
        return placed_parts(
            self.base, self._working_joints, self.tree, self.environment, self.holding
        )

    @functools.cached_property
    def terms(self) -> tuple[PlacedTerm, ...]:
        """Return the error terms of all parts, in the order of the parts; those of one robot where
        the arm is calibrated.
        """
        terms = tuple(term for part in self.parts for term in part.terms())
        known = self._calibration
        return terms if known is None else tuple(known.of((*terms, *known.added)))

    def calibrated(self, calibration: Calibration | None) -> Self:
        """Return the arm of one robot of which some draws were estimated; without a calibration,
        the arm as its file states it.

        The estimates are those of the arm as its file states it, also where this arm is calibrated
        already. Raises InputError for a stream by which the arm is not drawn.
        """
        out = self._copy_without("terms", "soft_freedoms", "open_ways")
        out._calibration = None  # noqa: SLF001 - of the same class
        if calibration is not None:
            calibration.refuse_unknown((*out.terms, *calibration.added))
            del out.__dict__["terms"]
            out._calibration = calibration  # noqa: SLF001 - of the same class
        return out

    def _copy_without(self, *names: str) -> Self:
        """Return a copy that keeps what was computed already, but for these properties."""
        out = self.model_copy()
        out.__dict__.update(self.__dict__)
        for name in names:
            out.__dict__.pop(name, None)
        return out

    @property
    def calibration(self) -> Calibration | None:
        """Return the estimates of the robot that this arm is; None for an arm of any robot."""
        return self._calibration

    def with_open_play(self, part: str, remark: str = "") -> Self:
        """Return the arm with the constraints of its closures open that the play of a part opens,
        by its full name; with all of them closed for "". The remark says why.
        """
        out = self._copy_without("open_ways")
        out._open = part, remark  # noqa: SLF001 - of the same class
        return out

    @functools.cached_property
    def open_ways(self) -> tuple[Way, ...]:
        """Return the places and directions of the plays that open constraints; see
        `with_open_play`.
        """
        part, _ = self._open
        return tuple(way for way in ways_of(self.terms if part else ()) if way.part == part)

    @property
    def correlations(self) -> Correlations | None:
        """Return the correlations of the draws of its terms; None where all are independent."""
        return None if self._calibration is None else self._calibration.correlations

    @functools.cached_property
    def soft_freedoms(self) -> tuple[Freedom, ...]:
        """Return the freedoms that the tangent of its equilibrium needs; none for a stiff arm."""
        springs = [each for each in self.terms if each.term.form.elastic]
        return soft_freedoms(
            self.tree,
            self.limits,
            self.payload,
            self.gravity,
            [each for each in springs if each.term.level == "design"],
        )

    @property
    def has_temperatures(self) -> bool:
        """Return whether a temperature, or a temperature difference across a link, is stated."""
        return self.environment.temperature is not None or any(
            joint.link.bends_with_temperature for joint in self.joints
        )

    @functools.cached_property
    def limits(self) -> Floats:
        """Return the range of every driven joint (joint, 2), rad or m."""
        return np.array([joint.limits for joint in self.driven])

    @functools.cached_property
    def home(self) -> Floats:
        """Return the driven joints at home (joint,), rad or m: by default mid-range."""
        return np.array(self.tree.home) if self.closures else self.limits.mean(axis=1)

    @property
    def warnings(self) -> tuple[str, ...]:
        """Return what seems wrong in the description of the arm; it is shown with every result."""
        return self._warnings

    def with_warnings(self, warnings: Iterable[str]) -> Self:
        """Return this arm with these warnings in place of its own."""
        out = self._copy_without()
        out._warnings = tuple(warnings)  # noqa: SLF001 - of the same class
        return out

    @property
    def remarks(self) -> tuple[str, ...]:
        """Return the notes of the arm, then whether it is calibrated, what encoders correct, what
        is not stated (members, ratings, friction, masses), and what expands.
        """
        return (
            *self.notes,
            *(() if self.calibration is None else self.calibration.remarks),
            *remarks_on_ranges(unknown_values(self)),
            *remarks_on(self.moving, self.assumed_friction, self.gearboxes_without_mass),
            *temperature_remarks(self.joints, self.environment),
            *closed_remarks(self.tree, self.limits, self.workspace),
            *filter(None, self._open[1:]),
        )

    @functools.cached_property
    def assumed_friction(self) -> dict[tuple[str, str], Friction]:
        """Return the friction (N m or N) of parts with play that do not state it, or not its
        scatter; keys are joint and part.
        """
        out = {}
        for k, joint in enumerate(self._working_joints):
            for name, source in joint.sources.items():
                friction = source.play_friction(functools.partial(self.holding, k))
                if friction is not None and (friction.reason or friction.scatter_assumed):
                    out[joint.name, name] = friction
        return out

    def holding(self, joint: int) -> Holding:
        """Return the largest static load of a joint over poses and tilts of the base; friction that
        is not stated is a share of it.

        `joint` is the index of the joint in `joints`. The maximum over tilts is exact; over poses
        it is the largest of 256 that are spread evenly between the joint limits. The load is at
        least that of 0.1 kg at the arm's reach. So an axis through the centre of mass has friction
        too, and so has an arm without stated masses. The load does not depend on the poses, the
        seed or the nominal tilt of a study.
        """
        return self._holdings[joint]

    @functools.cached_property
    def _holdings(self) -> tuple[Holding, ...]:
        return holding_loads(
            self.tree, self.limits, self.payload, self.gravity, _LEAST_MASS * STANDARD_GRAVITY
        )

    def with_payload(self, payload: Payload) -> Self:
        """Return the arm with another payload. Assumed friction does not change with the payload,
        because the drives stay the same.
        """
        other = self.model_copy(update={"payload": payload})
        other.__dict__["_holdings"] = self._holdings
        return other

    @property
    def mass(self) -> float:
        """Return the stated mass (kg) of joints, gearboxes, links and tool together, without the
        payload.
        """
        return (
            sum(joint.total_mass + joint.link.total_mass for joint in self.joints) + self.tool.mass
        )

    @property
    def gearboxes_without_mass(self) -> tuple[str, ...]:
        """Return the models of gearboxes without a mass, stated neither for the gearbox nor for its
        joint: they count as massless.
        """
        found = [
            joint.gearbox
            for joint in self.moving
            if joint.gearbox is not None and joint.mass is None and joint.gearbox.mass is None
        ]
        return tuple(dict.fromkeys(gearbox.model for gearbox in found if gearbox.model))

    @property
    def price(self) -> float | None:
        """Return the stated prices of joints, gearboxes, links and tool together; None where none
        is stated.
        """
        prices = [
            *(joint.total_price for joint in self.joints),
            *(joint.link.price for joint in self.joints),
            self.tool.price,
        ]
        stated = [price for price in prices if price is not None]
        return sum(stated) if stated else None

    @property
    def joints_without_price(self) -> tuple[str, ...]:
        """Return the names of moving joints with a price neither of their own nor of a gearbox."""
        return tuple(joint.name for joint in self.moving if joint.total_price is None)

    @functools.cached_property
    def gravity_in_base(self) -> Floats:
        """Return the acceleration of free fall (3,), m/s^2, in the base's axes at the base's
        nominal tilt.
        """
        return np.asarray(self.base.tilt.T @ np.array([0.0, 0.0, -self.gravity]))

    def __repr__(self) -> str:
        """Return the arm in one line."""
        kinds = "".join(joint.type[0].upper() for joint in self.joints)
        return f"<Arm '{self.name}': {kinds}, {self.mass:.3g} kg, payload {self.payload.mass:g} kg>"

    __str__ = __repr__


def _refusal(
    found: str, expected: str, example: str, near: str = "", path: tuple[str | int, ...] = ()
) -> PydanticCustomError:
    return PydanticCustomError(
        "names",
        "{why}",
        {"why": found, "expected": expected, "example": example, "near": near, "path": path},
    )
