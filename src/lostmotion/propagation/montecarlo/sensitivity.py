"""Effect of halving the errors of one part on the 95th percentile of all errors, with common random
numbers.
"""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.error_model.budget import Halving, Tally, costs, label_of
from lostmotion.error_model.intervals import Estimate, quantile, quantile_drop
from lostmotion.propagation.montecarlo.common_random_numbers import Paired, thinned

if TYPE_CHECKING:
    from collections.abc import Callable

    from lostmotion.error_model.budget import By
    from lostmotion.error_model.poses import Poses
    from lostmotion.mechanism.arm import Arm

_POSES: Final = 512
_ROBOTS: Final = 128
_VISITS: Final = 4
LEVEL: Final = 0.95


def halving(  # noqa: PLR0913 - a study is these numbers
    arm: Arm,
    poses: Poses,
    robots: int,
    visits: int,
    seed: int,
    *,
    by: By = "part",
    most: int = _ROBOTS,
    approach: float = 0.0,
    threads: int = 1,
    progress: Callable[[str, int, int], None] | None = None,
) -> Halving:
    """Return the decrease of the 95th percentile when the errors of each part, and of each kind,
    are halved; draws are the same.

    Monte Carlo on at most 512 of the poses, `most` robots and 4 visits. Intervals count robots and
    sets of poses.

    by    grouping of the terms: "part", or "term", "cause" or "level" instead

    Other arguments and errors as for `montecarlo.run`; InputError for any other `by`.
    """
    paired = Paired.of(arm, thinned(poses, _POSES), min(robots, most), visits, seed, approach)
    infos = paired.matrix.infos
    before = paired.run(np.ones(len(infos)))
    groupings: tuple[By, ...] = (by, "cause")
    labels = tuple(label_of(each) for each in groupings)
    unmoving = tuple(
        {cost.part for cost in costs(Tally.of(paired.matrix, each)) if cost.alone == 0}
        for each in groupings
    )
    wanted = [
        (k, name) for k, label in enumerate(labels) for name in dict.fromkeys(map(label, infos))
    ]

    def gain(k: int, name: str) -> Estimate:
        if name in unmoving[k]:
            return Estimate(0.0, 0.0, 0.0)  # exactly zero where the tool does not move
        after = paired.run(np.array([0.5 if labels[k](info) == name else 1.0 for info in infos]))
        return quantile_drop((before.groups, before.sets), (after.groups, after.sets), LEVEL)

    gains: list[dict[str, Estimate]] = [{}, {}]
    with ThreadPoolExecutor(threads) as pool:
        for done, ((k, name), found) in enumerate(
            zip(wanted, pool.map(gain, *zip(*wanted, strict=True)), strict=True), start=1
        ):
            gains[k][name] = found
            if progress is not None:
                progress("halving each error", done, len(wanted))
    return Halving(gains[0], quantile(before.groups.sum(axis=0), LEVEL), paired.samples, gains[1])


def halving_at(
    arm: Arm, poses: Poses, seed: int, *, approach: float = 0.0, threads: int = 1
) -> Halving:
    """Return `halving` at one pose or in a zone, with more robots where there are fewer poses, so
    that the number of samples stays the same.
    """
    robots = _POSES * _ROBOTS // min(len(poses), _POSES)
    return halving(
        arm, poses, robots, _VISITS, seed, most=robots, approach=approach, threads=threads
    )
