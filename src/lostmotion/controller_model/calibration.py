"""The error terms of one measured robot: what calibration estimated of its draws becomes design,
and what remains uncertain keeps its covariance.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.errors import nearest, refuse_argument
from lostmotion.laws.distributions import Normal
from lostmotion.parts.term import Draw

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lostmotion.laws.distributions import Law
    from lostmotion.mechanism.placed_terms import PlacedTerm
    from lostmotion.spatial import Floats

# Owner of the draws that remain after calibration.
_OWNER: Final = "calibration"
# A negative variance below this share of the largest is rounding.
_ROUNDING: Final = 1e-9


@dataclass(frozen=True)
class Calibration:
    """Estimates of a robot's draws. Draws that are not listed keep their distribution.

    streams    names of the draws with their laws, such as ("joints.A.encoder.zero", Normal()); a
               harmonic has two, of its sine and of its cosine
    mean       (stream,) estimated draws, in standard deviations of what the arm file states
    covariance (stream, stream) of the estimates; zeros for exact ones

    The names of the streams are those of `known_streams`. Raises InputError for arrays of another
    shape, numbers that are not finite, a stream that is named twice, and a covariance that is not
    symmetric or has a negative variance.
    """

    streams: tuple[tuple[str, Law], ...]
    mean: Floats
    covariance: Floats

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

    def terms(self, terms: Sequence[PlacedTerm]) -> list[PlacedTerm]:
        """Return the terms of this robot. Raises InputError for a stream that none of them is drawn
        by, with the nearest that there is.

        A term drawn with x = mean + sum of factor x remaining draw becomes one term without that
        draw, and one for each remaining draw.
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
        values, vectors = np.linalg.eigh(np.asarray(self.covariance, dtype=float))
        factors = vectors * np.sqrt(np.maximum(values, 0.0))
        rows = {stream: k for k, stream in enumerate(self.streams)}
        out: list[PlacedTerm] = []
        for placed in terms:
            draw = placed.term.robot
            row = None if draw is None else rows.get(_stream(placed, draw))
            if row is None:
                out.append(placed)
                continue
            parts: list[tuple[float, Draw | None]] = [(float(self.mean[row]), None)]
            parts += [
                (float(factor), Draw(f"remaining {k}", Normal(np.inf), _OWNER))
                for k, factor in enumerate(factors[row])
            ]
            out += [
                replace(
                    placed, term=replace(placed.term, scale=placed.term.scale * factor, robot=robot)
                )
                for factor, robot in parts
                if factor
            ]
        return out


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
