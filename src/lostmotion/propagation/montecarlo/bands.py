"""How far the figures of a study depend on values that are only known to lie in a range ("1.3 ..
3.0 GPa").

A range is ignorance: its value is the same for all robots. So the study is repeated for draws of
all ranges, with the same robots, visits and poses, and the 5th to the 95th percentile over the
draws is the band of a figure. It stands beside the confidence interval, which counts robots and
poses, and is never combined with it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.parts.bands import band, draws, influence, latin_hypercube, unknown_values
from lostmotion.propagation.error_samples import Drawn
from lostmotion.propagation.figures import figures_of
from lostmotion.propagation.montecarlo.common_random_numbers import thinned
from lostmotion.propagation.montecarlo.montecarlo import run

if TYPE_CHECKING:
    from collections.abc import Callable

    from lostmotion.error_model.poses import Poses
    from lostmotion.mechanism.arm import Arm
    from lostmotion.parts.bands import UnknownValue
    from lostmotion.spatial import Floats

DRAWS: Final = 32
_POSES: Final = 256
_ROBOTS: Final = 128


@dataclass(frozen=True)
class Bands:
    """Figures of a study over draws of its unknown values, from runs of `poses` x `robots` x
    `visits`.

    unknown  the ranges
    shares   (draw, value) at which each range was taken
    ratios   by key of a figure, (draw,): to the one with the middle of every range; NaN for a
             figure that is zero there
    """

    unknown: tuple[UnknownValue, ...]
    shares: Floats
    ratios: dict[str, Floats]
    poses: int
    robots: int
    visits: int

    def band(self, figure: str, value: float) -> tuple[float, float]:
        """Return the 5th and 95th percentile of a figure, by its key, that has this value with the
        middle of every range.
        """
        low, high = band(self.ratios[figure])
        return low * value, high * value

    def influence(self, figure: str) -> dict[str, float]:
        """Return the share of a figure's variance over the draws that each range explains alone:
        its name to the share, largest first.
        """
        shares = influence(self.shares, self.ratios[figure])
        each = {
            unknown.name: float(share) for unknown, share in zip(self.unknown, shares, strict=True)
        }
        return dict(sorted(each.items(), key=lambda item: -item[1]))


def bands(  # noqa: PLR0913 - a study is these numbers
    arm: Arm,
    poses: Poses,
    robots: int,
    visits: int,
    seed: int,
    *,
    approach: float = 0.0,
    threads: int = 1,
    progress: Callable[[str, int, int], None] | None = None,
) -> Bands | None:
    """Return the figures of a study over draws of its unknown values; None for an arm whose values
    are all known.

    At most 256 of the poses and 128 robots, the same ones in every draw and with the middles.
    Arguments as `montecarlo.run`. Raises InputError where a draw makes an impossible part,
    DidNotConvergeError where one cannot be computed.
    """
    unknown = unknown_values(arm)
    if not unknown:
        return None
    chosen, robots = thinned(poses, _POSES), min(robots, _ROBOTS)

    def figures(each: Arm) -> dict[str, float]:
        """Return the figures that are asked for first, m."""
        sampled = run(
            each, chosen, robots, visits, seed, approach=approach, threads=threads, compared=0
        )
        errors = Drawn.of(sampled, approach=approach)
        return {
            key: figure.estimate(errors).value
            for key, figure in figures_of(errors).items()
            if figure.first
        }

    shares = latin_hypercube(unknown, DRAWS, seed)
    middle, found = figures(arm), []
    for k, known in enumerate(draws(arm, unknown, shares)):
        if progress is not None:
            progress("drawing what is unknown", k, DRAWS)
        found.append(figures(known))
    ratios = {
        key: np.array([each[key] for each in found]) / (value if 0 < value < np.inf else np.nan)
        for key, value in middle.items()
    }
    return Bands(unknown, shares, ratios, len(chosen), robots, visits)
