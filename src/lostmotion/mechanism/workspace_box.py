"""The box of a closed chain's tool in which its poses are sampled, as an arm file states it."""

from __future__ import annotations

import functools
from typing import TYPE_CHECKING, Annotated, ClassVar, Final

import numpy as np
from pydantic import Field

from lostmotion.parts.error_source import Part
from lostmotion.parts.joint import SlidingLimits, TurningLimits
from lostmotion.spatial import exp

if TYPE_CHECKING:
    from lostmotion.spatial import Floats

# Fields in the order of a twist.
_COMPONENTS: Final = ("rx", "ry", "rz", "x", "y", "z")


class WorkspaceBox(Part):
    """A box of poses of the tool of a closed chain, in which its poses are sampled.

    x, y, z     limits of the tool point in the base's frame, m
    rx, ry, rz  limits of the tool's rotation from home: components of the rotation vector in the
                base's axes, rad

    Components that are not stated, and that the drives control besides, stay as they are at home.
    """

    shareable: ClassVar[bool] = False
    x: SlidingLimits | None = None
    y: SlidingLimits | None = None
    z: Annotated[SlidingLimits | None, Field(description="of the tool point, base's frame")] = None
    rx: TurningLimits | None = None
    ry: TurningLimits | None = None
    rz: Annotated[
        TurningLimits | None, Field(description="of the rotation vector from home, base's axes")
    ] = None

    @functools.cached_property
    def stated(self) -> dict[int, tuple[float, float]]:
        """Return the stated limits, rad or m, by component of a twist: positions first."""
        limits = {k: getattr(self, _COMPONENTS[k]) for k in (3, 4, 5, 0, 1, 2)}
        return {k: each for k, each in limits.items() if each is not None}

    @property
    def ranges(self) -> Floats:
        """Return the stated limits (component, 2), rad or m, in the order of `stated`."""
        return np.array(list(self.stated.values())).reshape(-1, 2)

    def names(self, components: list[int]) -> str:
        """Return the keys of these components of a twist."""
        return ", ".join(_COMPONENTS[k] for k in components)

    def poses_at(self, values: Floats, home: Floats) -> Floats:
        """Return the poses of the tool (pose, 4, 4), m, at values (pose, component) in the order of
        `stated`, rad or m; others as in the pose of the tool at home (4, 4).
        """
        at = dict(zip(self.stated, values.T, strict=True))
        twist = np.zeros((len(values), 6))
        out = np.tile(home, (len(values), 1, 1))
        for k, each in at.items():
            if k < 3:  # noqa: PLR2004 - rotations come first in a twist
                twist[:, k] = each
            else:
                out[:, k - 3, 3] = each
        out[:, :3, :3] = exp(twist)[:, :3, :3] @ home[:3, :3]
        return out
