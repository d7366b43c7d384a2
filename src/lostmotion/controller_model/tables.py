"""Layout of the tables of a controller: one record per place of the arm, without part kinds and
without functions.

This is the one definition of the layout. `lowering` fills it, `prediction` evaluates it in NumPy,
and the C sources evaluate the same tables.

The screw of a place is a sum of directions (6,) times sizes. A size is a product of up to three
factors, and a factor is a number that depends on the load, on the joint value or on neither: one, a
curve of a load, a sine or cosine of the joint value, a component of a load's unit direction, the
share of robots in which a load closes a play, or a displacement from a table of loads. With s for
the last motion of the joint (-1, 0 or 1):

    mean        sum of size x side factor x direction                     plus mean + compliance @
                wrench + own_weight @ gravity
    covariance  sum of first size x second size x side factor x matrix    plus the constant
                covariance
    shared      as the mean, one screw per shared draw, such as the modulus of a material: at the
                tool, each adds the square of its own sum

Axes of a place are those of the arm's place, turned so that a joint moves along or about z. Twists
are (rotation, displacement), wrenches (moment, force), in SI. Calibration fits into the same
records: an estimate moves a screw from the covariance to the mean, and what remains of the robot's
draws is a list of shared draws.

The side factors are 1, -s and, by the index UNKNOWN, 1 - s^2, the variance of a last motion that is
not known.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from lostmotion.laws.rolling.table import ShiftTable
    from lostmotion.spatial import Floats

# Index of the factor that is always one, and of the size that is always one.
ONE: Final = 0
# Side factor of what varies only where the last motion is not known.
UNKNOWN: Final = 2
# Factors of a threshold: share of robots with the play closed, share with it open, and the root of
# their product.
CLOSED, OPEN, DIFFERS = range(3)


class ExportedCurve(NamedTuple):
    """A piecewise linear factor of the load way @ wrench: base + sum of slope x clip(|load| -
    start, 0, width); odd: times the load's sign.

    way    (6,) direction of the load; zero for a factor of the joint value, which takes the place
           of |load|
    start, width, slope  (n,) of each piece; the last width is infinite
    weights  whether the load is that of the weights alone, without the process force and moment
    """

    way: Floats
    odd: bool
    base: float
    start: Floats
    width: Floats
    slope: Floats
    weights: bool = False

    @property
    def travels(self) -> bool:
        """Return whether it is a factor of the joint value."""
        return not self.way.any()


class ExportedHarmonic(NamedTuple):
    """The sine of order x (turns x joint value) + phase; the phase is 0 for a sine and a quarter
    turn, as a flag, for a cosine.
    """

    order: float
    turns: float
    cosine: bool


class ExportedSeat(NamedTuple):
    """A load in one to three directions, `way` (m, 6): its m factors are the components of its unit
    direction.
    """

    way: Floats


class ExportedFriction(NamedTuple):
    """Friction of one seat: share of robots in which the load of the seat exceeds it.

    seat       index of the seat
    lever      length (m) that divides the whole wrench before it is compared with the load; one
               where the load is along a joint
    nominal    friction, N m or N
    tolerance  its scatter over robots, in the same unit; zero: none
    start, width, slope, base  share over (load - nominal) / tolerance as a piecewise linear
                               function; empty for a normal law
    cut        truncation of a normal law in its standard deviations, infinite without one; zero for
               a piecewise linear law
    scale      factor on (load - nominal) / tolerance in a normal law
    """

    seat: int
    lever: float
    nominal: float
    tolerance: float
    base: float
    start: Floats
    width: Floats
    slope: Floats
    cut: float
    scale: float


class ExportedThreshold(NamedTuple):
    """One or several frictions; the largest of their shares counts. Its three factors are CLOSED,
    OPEN and DIFFERS.
    """

    frictions: tuple[ExportedFriction, ...]


class ExportedLoadTable(NamedTuple):
    """Displacements of a shaft on two rows over the loads of three seats: nine factors.

    Rows behind and ahead and axis, of each the deflection beyond the play, the displacement to the
    edge of the play, and its growth per metre. `seats` are the two radial seats and the axial one;
    the axial load has a sign.
    """

    seats: tuple[int, int, int]
    axial: bool
    table: ShiftTable
    wider: ShiftTable | None
    step: float


class Entry(NamedTuple):
    """A direction (6,), its size, and the index of the side factor."""

    size: int
    side: int
    direction: Floats


class Product(NamedTuple):
    """A symmetric matrix (6, 6), the two sizes by which it is multiplied, and the index of the side
    factor.
    """

    first: int
    second: int
    side: int
    matrix: Floats


class Shared(NamedTuple):
    """The part of a shared draw at one place: compliance @ wrench + own_weight @ gravity + entries.

    share  by which factor compliance and own weight are those of the place; 0 where they are not
           proportional to them
    """

    draw: int
    compliance: Floats
    own_weight: Floats
    entries: tuple[Entry, ...]
    share: float


@dataclass(frozen=True)
class Record:
    """Everything about one place.

    parent     index of the parent, -1 for the base
    joint      index of the joint that moves it along or about its z axis, -1 for a fixed place
    slides     whether that joint slides
    carries_tool  whether the place is between the base and the tool, so that its errors move the
                  tool
    pose       (4, 4) relative to the parent, before the joint's motion, m
    mass, moment  kg and kg m: of everything fixed to the place, without the payload
    mean, compliance, own_weight, covariance  constant parts: (6,), (6, 6), (6, 3), (6, 6)
    sizes      (size, 3) indices of the factors of each size; factors are numbered in the order of
               the fields below, after ONE
    """

    name: str
    parent: int
    joint: int
    slides: bool
    carries_tool: bool
    pose: Floats
    mass: float = 0.0
    moment: Floats = field(default_factory=lambda: np.zeros(3))
    mean: Floats = field(default_factory=lambda: np.zeros(6))
    compliance: Floats = field(default_factory=lambda: np.zeros((6, 6)))
    own_weight: Floats = field(default_factory=lambda: np.zeros((6, 3)))
    covariance: Floats = field(default_factory=lambda: np.zeros((6, 6)))
    curves: tuple[ExportedCurve, ...] = ()
    harmonics: tuple[ExportedHarmonic, ...] = ()
    seats: tuple[ExportedSeat, ...] = ()
    thresholds: tuple[ExportedThreshold, ...] = ()
    tables: tuple[ExportedLoadTable, ...] = ()
    sizes: tuple[tuple[int, int, int], ...] = ((ONE, ONE, ONE),)
    entries: tuple[Entry, ...] = ()
    products: tuple[Product, ...] = ()
    shared: tuple[Shared, ...] = ()


@dataclass(frozen=True)
class Validity:
    """Inputs for which a controller answers; others have a status other than OK.

    payload  largest mass, kg
    reach    largest distance of its centre of mass from the tool point along each axis, m
    force, moment  largest component of the process force and moment, N and N m
    gravity  largest component of the acceleration of free fall, m/s^2
    """

    payload: float
    reach: float
    force: float
    moment: float
    gravity: float


@dataclass(frozen=True)
class Tables:
    """The tables of an arm.

    name     of the arm
    joints   names of the moving joints, in the order of q
    limits   (joint, 2) rad or m
    rated    (joint,) rated torque or force of each drive, N m or N; infinite where none is stated
    records  places, parents before children; the tool is the last
    draws    names of the shared draws
    load     mass (kg), centre of mass (3, m), force (3, N) and moment (3, N m) of the arm's own
             payload, in one row of ten
    gravity  (3,) acceleration of free fall of the arm's own base, m/s^2
    """

    name: str
    joints: tuple[str, ...]
    limits: Floats
    rated: Floats
    records: tuple[Record, ...]
    draws: tuple[str, ...]
    load: Floats
    gravity: Floats
    valid: Validity

    @property
    def fed_forward(self) -> bool:
        """Return whether a factor follows the weights alone: then the wrenches of the process force
        are needed as well.
        """
        return any(curve.weights for record in self.records for curve in record.curves)

    @property
    def start(self) -> Floats:
        """Return joint values (joint,) to start with, rad or m: zero, or the middle of a range
        without it.
        """
        low, high = self.limits.T
        return np.where((low <= 0) & (high >= 0), 0.0, low + (high - low) / 2)
