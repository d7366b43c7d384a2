"""Base of the arm: its tilt, nominal and tolerance, and the compliance of its mount."""

from __future__ import annotations

import functools
from typing import TYPE_CHECKING, Annotated, ClassVar, Literal, Self

import numpy as np
from pydantic import model_validator

from lostmotion.laws.distributions import Normal, of_tolerance
from lostmotion.laws.elastic_foundation import track_stiffness
from lostmotion.parts.compliance import Compliance
from lostmotion.parts.error_source import (
    Angle,
    AngleDim,
    AngularStiffness,
    ErrorSource,
    LengthPlus,
    LinearStiffness,
    Share,
)
from lostmotion.parts.forms import Constant, Linear
from lostmotion.parts.frame import Vector
from lostmotion.parts.provenance import Sourced
from lostmotion.parts.section import refuse_section
from lostmotion.parts.standard_terms import limit_terms, parameter
from lostmotion.parts.term import Motion, Parameter, Term
from lostmotion.spatial import pose_of, skew
from lostmotion.units import Quantity, Toleranced

if TYPE_CHECKING:
    from lostmotion.spatial import Floats

Six = tuple[AngularStiffness, AngularStiffness, AngularStiffness]
Three = tuple[LinearStiffness, LinearStiffness, LinearStiffness]


class Tracks(Sourced):
    """Two tracks on the ground, along the base's x, as a mount.

    length, width   of each track's contact with the ground; gauge between the tracks' middles
    bedding         the ground's pressure per settlement
    shear_share     stiffness of the ground in shear (along its surface), as a share of `bedding`
    middle          the middle of both contacts, in the base's frame
    scatter         ± variation of the ground's stiffness between sites, as a share

    Assumed: a rigid hull on rigid tracks and rollers, a uniform elastic foundation (Winkler) under
    both tracks, no lifting off, no slip. A suspension adds compliance: then state the whole mount
    as a `compliance`.
    """

    length: LengthPlus
    width: LengthPlus
    gauge: LengthPlus
    bedding: Annotated[float, Quantity("N/m^3", "50 MN/m^3", above=0)]
    shear_share: Annotated[float, Quantity("", "50 %", above=0, high=1)] = 0.5
    middle: Vector = (0.0, 0.0, 0.0)
    scatter: Share = 0.0

    @functools.cached_property
    def values(self) -> Floats:
        """Return the compliance (6, 6) at the base's origin, in its axes."""
        carry = np.eye(6)
        # a turn about the middle swings the base's origin
        carry[3:, :3] = skew(np.array(self.middle))
        return np.asarray(
            carry
            / track_stiffness(self.length, self.width, self.gauge, self.bedding, self.shear_share)
            @ carry.T
        )


class Base(Sourced, ErrorSource):
    """The ground, chassis or table under the arm.

    xyz, rpy      frame of the arm in the base: the first joint's origin is given in it
    roll, pitch   tilt about the base's x, then y axis; the nominal value turns gravity, the
                  tolerance is the unmeasured part
    tilt_varies   "robot": the arm is set down once; "visit": a mobile base stands differently every
                  time
    angular_stiffness, linear_stiffness  of the mount about and along x, y, z; default: rigid
    compliance    of the mount instead, a whole matrix at the base's origin and in its axes
    tracks        instead: two tracks on the ground

    The error of an unmeasured tilt is counted at the tool, relative to level ground. The change of
    load that it causes is neglected: its effect is the tilt times the arm's deflection under its
    whole weight, small beside the tilt times the reach (tests/parts/test_base.py).
    """

    shareable: ClassVar[bool] = False
    xyz: Vector = (0.0, 0.0, 0.0)
    rpy: tuple[Angle, Angle, Angle] = (0.0, 0.0, 0.0)
    roll: AngleDim = Toleranced(0.0)
    pitch: AngleDim = Toleranced(0.0)
    tilt_varies: Literal["robot", "visit"] = "robot"
    angular_stiffness: Six | None = None
    linear_stiffness: Three | None = None
    compliance: Compliance | None = None
    tracks: Tracks | None = None

    @model_validator(mode="after")
    def _has_one_mount(self) -> Self:
        by_axis = (
            "angular_stiffness or linear_stiffness"
            if self.angular_stiffness or self.linear_stiffness
            else ""
        )
        stated = [
            name
            for name in (
                by_axis,
                "compliance" if self.compliance else "",
                "tracks" if self.tracks else "",
            )
            if name
        ]
        if self.compliance is not None and self.compliance.own_weight is not None:
            raise refuse_section(
                "own weight in the compliance of a mount",
                "the mount without it",
                'compliance = "mount.csv"',
            )
        if len(stated) > 1:
            raise refuse_section(" beside ".join(stated), "one of them", 'compliance = "mount.csv"')
        return self

    @functools.cached_property
    def foot(self) -> Floats:
        """Return the frame in which the arm stands, as a pose (4, 4) in the base's frame."""
        return pose_of(self.xyz, self.rpy)

    @functools.cached_property
    def tilt(self) -> Floats:
        """Return the rotation (3, 3) of the base against level ground."""
        return pose_of(rpy=(self.roll.nominal, self.pitch.nominal, 0.0))[:3, :3]

    @functools.cached_property
    def sources(self) -> dict[str, ErrorSource]:
        """Return the error sources of the base by name; the budget lists each separately."""
        return {"tilt": BaseTilt(self), "mount": BaseMount(self)}

    def terms(self, motion: Motion) -> list[Term]:
        """Return the terms of the unmeasured tilt and of the mount's compliance."""
        return [term for source in self.sources.values() for term in source.terms(motion)]


class BaseTilt(ErrorSource):
    """Unmeasured tilt of a base."""

    def __init__(self, base: Base) -> None:
        """Store the base."""
        self.base = base

    def terms(self, motion: Motion) -> list[Term]:  # noqa: ARG002 - a tilt does not depend on a joint
        """Return roll and pitch, drawn once per robot or at every visit."""
        base = self.base
        out: list[Term] = []
        for k, (name, dimension) in enumerate((("roll", base.roll), ("pitch", base.pitch))):
            if dimension.tolerance:
                # `tilt` is R_y R_x; its roll axis is the base's own x, its pitch axis the level y
                axis = np.eye(6)[k]
                axis[:3] = axis[:3] if k == 0 else base.tilt.T @ axis[:3]
                sized = parameter(name, dimension.tolerance, "rad")
                law, visit = of_tolerance(dimension.law), base.tilt_varies == "visit"
                out += limit_terms(
                    name, Constant(axis), dimension.tolerance, law, sized, visit=visit
                )
        return out


class BaseMount(ErrorSource):
    """Deflection of the mount under the whole arm, linear in the load."""

    def __init__(self, base: Base) -> None:
        """Store the base."""
        self.base = base

    @functools.cached_property
    def compliance(self) -> Floats | None:
        """Return the compliance (6, 6) at the base's origin, in its axes; None where it is
        rigid.
        """
        base = self.base
        stated = base.compliance or base.tracks
        if stated is not None:
            return stated.values
        if base.angular_stiffness is None and base.linear_stiffness is None:
            return None
        return np.diag(
            [1 / k for k in (base.angular_stiffness or _RIGID) + (base.linear_stiffness or _RIGID)]
        )

    def terms(self, motion: Motion) -> list[Term]:  # noqa: ARG002 - a mount has no joint
        """Return the deflection of the mount, and its scatter over mounts."""
        if self.compliance is None:
            return []
        stated = self.base.compliance or self.base.tracks
        scatter = stated.scatter if stated is not None else 0.0
        form, sized = Linear(self.compliance), Parameter("stiffness")
        out = [Term("deflection", "deflection", form, parameter=sized, exponent=-1)]
        return out + (
            limit_terms("scatter", form, scatter, Normal(), sized, exponent=-1) if scatter else []
        )


_RIGID = (np.inf, np.inf, np.inf)
