"""What was measured of one robot: estimates of its draws.

A draw that was estimated has a mean, which every visit of the robot repeats and which therefore
becomes design, and a remaining part: a normal draw of the posterior deviation. The remaining parts
of several estimates may be correlated. The correlation is no property of a term: it mixes the draws
(`Correlations`), so that a calibrated arm has at most two terms for each of its own.
"""

from __future__ import annotations

import functools
import hashlib
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from lostmotion.errors import nearest, refuse_argument
from lostmotion.laws.distributions import Cosine, Normal, Sine

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lostmotion.laws.distributions import Law
    from lostmotion.mechanism.placed_terms import PlacedTerm
    from lostmotion.parts.term import Draw
    from lostmotion.spatial import Floats

# Law of what remains uncertain of an estimate.
REMAINING: Final = Normal(np.inf)
# A negative variance below this share of the largest is rounding.
_ROUNDING: Final = 1e-9


@dataclass(frozen=True, eq=False)
class Correlations:
    """Draws that are correlated: draws = factor @ independent standard normal draws.

    streams  names of the draws
    factor   (stream, stream) lower triangle with rows of unit length, the Cholesky factor of their
             correlation matrix; columns beyond its rank are zero
    """

    streams: tuple[str, ...]
    factor: Floats

    @functools.cached_property
    def row(self) -> dict[str, int]:
        """Return the row of each draw, by name."""
        return {name: k for k, name in enumerate(self.streams)}

    @functools.cached_property
    def key(self) -> str:
        """Return a name that only equal correlations have."""
        found = hashlib.blake2b(repr(self.streams).encode(), digest_size=16)
        found.update(self.factor.tobytes())
        return f"calibration.{found.hexdigest()}"


class StatedEstimate(NamedTuple):
    """An estimate as it went into a figure.

    name              of the draw
    value, deviation  signed, in `unit`
    unit              "rad" or "m"; "1" for standard deviations of the draw
    in_file           whether the arm's file states the error
    assumed           whether its size is a number of standard deviations that nobody states
    source            what it was estimated from, as in `Calibration`; empty where it is stated
    """

    name: str
    value: float
    deviation: float
    unit: str
    in_file: bool
    assumed: bool
    source: str


@dataclass(frozen=True, eq=False)
class Calibration:
    """Estimates of a robot's draws. Draws that are not listed keep their distribution.

    streams    names of the draws with their laws, such as ("joints.A.encoder.zero", Normal()); a
               harmonic has two, of its sine and of its cosine
    mean       (stream,) estimated draws, in standard deviations of what the arm file states
    covariance (stream, stream) of the estimates; zeros for exact ones
    added      terms that the arm has besides those of its file, such as an unknown base frame
    source     what the estimates are from, such as "20 measured poses": they are then compared with
               the base and tool frame that fit them best. Empty: they are stated, and base and tool
               count as errors of the robot
    assumed    names of draws whose estimates are numbers of standard deviations that nobody states

    The names of the streams are those of `known_streams`. Raises InputError for arrays of another
    shape, numbers that are not finite, a stream that is named twice, and a covariance that is not
    symmetric or has a negative variance.
    """

    streams: tuple[tuple[str, Law], ...]
    mean: Floats
    covariance: Floats
    added: tuple[PlacedTerm, ...] = ()
    source: str = ""
    assumed: frozenset[str] = frozenset()

    def __post_init__(self) -> None:
        """Refuse estimates that no robot can have."""
        count = len(self.streams)
        mean, covariance = (
            np.asarray(self.mean, dtype=float),
            np.asarray(self.covariance, dtype=float),
        )
        if mean.shape != (count,) or not np.isfinite(mean).all():
            raise refuse_argument(
                "mean", self.mean, f"{count} finite numbers, one per stream", mean=[0.7]
            )
        if (
            covariance.shape != (count, count)
            or not np.isfinite(covariance).all()
            or not np.array_equal(covariance, covariance.T)
        ):
            raise refuse_argument(
                "covariance",
                self.covariance,
                f"a symmetric matrix of {count} x {count} finite numbers",
                covariance=[[0.01]],
            )
        values = np.linalg.eigvalsh(covariance) if count else np.zeros(0)
        if (values < -_ROUNDING * np.abs(values).max(initial=0.0)).any():
            raise refuse_argument(
                "covariance",
                self.covariance,
                "a matrix without negative variances",
                covariance=[[0.01]],
            )
        if len(set(self.streams)) < count:
            raise refuse_argument(
                "streams",
                [name for name, _ in self.streams],
                "every stream once",
                streams='[("joints.A.encoder.zero", Normal())]',
            )

    @property
    def remarks(self) -> tuple[str, ...]:
        """Return what every figure of this robot is of; nothing without an estimate."""
        if not self.streams:
            return ()
        count = f"{len(self.streams)} estimate{'s' * (len(self.streams) > 1)}"
        if self.source:
            text = f"these are the figures of one calibrated robot, with {count} from {self.source}"
            compared = ", compared with the base and tool frame that fit it best"
            return (text + (compared if self.added else ""),)
        text = f"these are the figures of one robot, with {count} that a file or a call states"
        if self.added:
            owners = ", ".join(dict.fromkeys(each.owner for each in self.added))
            text += f"; {owners}: errors that the arm file does not state"
        return (text,)

    def stated(self, terms: Sequence[PlacedTerm]) -> tuple[StatedEstimate, ...]:
        """Return the estimates, in the units of the errors of these terms, those of the arm as its
        file states it.
        """
        out = []
        for (name, law), mean, deviation in zip(
            self.streams, self.mean, self._deviations, strict=True
        ):
            of = [
                each
                for each in (*terms, *self.added)
                if each.term.robot is not None and _stream(each, each.term.robot) == (name, law)
            ]
            size, unit = size_of(of)
            in_file = not any(each in self.added for each in of)
            value = size * float(mean), abs(size) * float(deviation)
            out.append(
                StatedEstimate(
                    name + _PHASES.get(type(law), ""),
                    *value,
                    unit,
                    in_file,
                    name in self.assumed,
                    self.source,
                )
            )
        return tuple(out)

    def refuse_unknown(self, terms: Sequence[PlacedTerm]) -> None:
        """Raise InputError for a stream by which none of these terms is drawn, with the nearest
        that there is.
        """
        known = known_streams(terms)
        for name, law in self.streams:
            if (name, law) not in known:
                laws = [str(each) for other, each in known if other == name]
                near = (
                    f"the law {laws[0]} for it"
                    if laws
                    else nearest(name, [other for other, _ in known]) or "one of `known_streams`"
                )
                raise refuse_argument(
                    "streams", f"{name} with {law}", f"a stream by which the arm is drawn: {near}"
                )

    def estimates(self, placed: PlacedTerm) -> bool:
        """Return whether the draw of a term of the arm as its file states it was estimated."""
        draw = placed.term.robot
        return draw is not None and _stream(placed, draw) in self.streams

    def of(self, terms: Sequence[PlacedTerm]) -> list[PlacedTerm]:
        """Return the terms of this robot: in place of a term with an estimated draw, one with its
        mean and without that draw, and one with what remains uncertain of it. A part that is zero
        has no term.
        """
        rows = {stream: k for k, stream in enumerate(self.streams)}
        out: list[PlacedTerm] = []
        for placed in terms:
            draw = placed.term.robot
            row = None if draw is None else rows.get(_stream(placed, draw))
            if draw is None or row is None:
                out.append(placed)
                continue
            parts = (
                (float(self.mean[row]), None),
                (float(self._deviations[row]), _remaining(draw)),
            )
            out += [
                replace(
                    placed, term=replace(placed.term, scale=placed.term.scale * size, robot=robot)
                )
                for size, robot in parts
                if size
            ]
        return out

    @functools.cached_property
    def correlations(self) -> Correlations | None:
        """Return the correlations of what remains uncertain; None where it is independent."""
        scale = np.where(self._deviations > 0, self._deviations, np.inf)
        correlation = np.asarray(self.covariance, dtype=float) / np.outer(scale, scale)
        np.fill_diagonal(correlation, 1.0)
        some = np.flatnonzero((correlation != np.eye(len(scale))).any(axis=1))
        if not len(some):
            return None
        values, vectors = np.linalg.eigh(correlation[np.ix_(some, some)])
        rank = np.flatnonzero(values > _ROUNDING * values[-1])
        # By QR, and not by Cholesky's method, since a covariance may be singular.
        _, upper = np.linalg.qr((vectors[:, rank] * np.sqrt(values[rank])).T)
        factor = np.zeros_like(vectors)
        signs = np.where(np.diag(upper) < 0, -1.0, 1.0)
        factor[:, : len(rank)] = np.tril((upper * signs[:, None]).T)
        factor /= np.linalg.norm(factor, axis=1, keepdims=True)
        return Correlations(
            tuple(
                name + _PHASES.get(type(law), "")
                for name, law in map(self.streams.__getitem__, some)
            ),
            factor,
        )

    @functools.cached_property
    def _deviations(self) -> Floats:
        return np.sqrt(np.maximum(np.diag(np.asarray(self.covariance, dtype=float)), 0.0))


def size_of(placed: Sequence[PlacedTerm]) -> tuple[float, str]:
    """Return the size of an error per unit of the draw that these terms share, with its unit, "rad"
    or "m"; 1 and "1" where its screw depends on the pose, or several terms share the draw.
    """
    term = placed[0].term
    direction = getattr(term.form, "direction", None)
    if len(placed) > 1 or direction is None or term.form.reads:
        return 1.0, "1"
    return float(term.scale), "rad" if direction[:3].any() else "m"


def known_streams(terms: Sequence[PlacedTerm]) -> tuple[tuple[str, Law], ...]:
    """Return the streams by which robots with these terms differ, with their laws, in the order of
    the arm: what a calibration may estimate.
    """
    return tuple(
        dict.fromkeys(
            _stream(each, each.term.robot) for each in terms if each.term.robot is not None
        )
    )


def _stream(placed: PlacedTerm, draw: Draw) -> tuple[str, Law]:
    return draw.name(placed.owner), draw.law


# The two draws of a harmonic have one name: what remains of them are two streams.
_PHASES: Final[dict[type[Law], str]] = {Sine: " sine", Cosine: " cosine"}


def _remaining(draw: Draw) -> Draw:
    """Return the draw of what remains uncertain of this one."""
    return replace(draw, stream=draw.stream + _PHASES.get(type(draw.law), ""), law=REMAINING)
