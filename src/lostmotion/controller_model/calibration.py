"""The error terms of one measured robot: what calibration estimated of its draws becomes design, and what remains uncertain keeps its covariance."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from lostmotion.laws.distributions import Normal
from lostmotion.parts.term import Draw

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lostmotion.laws.distributions import Law
    from lostmotion.mechanism.placed_terms import PlacedTerm
    from lostmotion.spatial import Floats

# Owner of the draws that remain after calibration.
_OWNER = "calibration"


@dataclass(frozen=True)
class Calibration:
    """Estimates of a robot's draws. Draws that are not listed keep their distribution.

    streams    names of the draws with their laws, such as ("joints.A.encoder.zero", Normal()); a harmonic has two, of its sine and of its cosine
    mean       (stream,) estimated draws, in standard deviations of what the arm file states
    covariance (stream, stream) of the estimates; zeros for exact ones
    """

    streams: tuple[tuple[str, Law], ...]
    mean: Floats
    covariance: Floats

    def terms(self, terms: Sequence[PlacedTerm]) -> list[PlacedTerm]:
        """Return the terms of this robot.

        A term drawn with x = mean + sum of factor x remaining draw becomes one term without that draw, and one for each remaining draw.
        """
        values, vectors = np.linalg.eigh(self.covariance)
        factors = vectors * np.sqrt(np.maximum(values, 0.0))
        rows = {stream: k for k, stream in enumerate(self.streams)}
        out: list[PlacedTerm] = []
        for placed in terms:
            draw = placed.term.robot
            row = None if draw is None else rows.get((f"{draw.shared or placed.owner}.{draw.stream}", draw.law))
            if row is None:
                out.append(placed)
                continue
            known: list[tuple[float, Draw | None]] = [(float(self.mean[row]), None)]
            known += [(float(factor), Draw(f"remaining {k}", Normal(np.inf), _OWNER)) for k, factor in enumerate(factors[row])]
            out += [replace(placed, term=replace(placed.term, scale=placed.term.scale * factor, robot=robot)) for factor, robot in known if factor]
        return out
