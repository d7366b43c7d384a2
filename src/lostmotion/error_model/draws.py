"""Reproducible draws of robots and visits, by name and seed.

Random numbers are counter-based (Philox), with one key per stream name and seed. So the robots are
the same for any tiling and thread count, a new error source changes no other draw, and a run of
more robots or visits begins with the same ones. Source: J. Salmon et al., SC11 (Philox).

Robot draws are independent uniforms through the inverse CDF. Visit draws come from one table per
stream: 8 192 values, one from each of as many equally probable intervals, in random order. Every
visit of every tile of robots to every pose reads the table from its own start position. Compared
with independent numbers, this changes no distribution, and leaves only a correlation of about 0.01
between neighbouring robots, which share a tile.
"""

from __future__ import annotations

import functools
import hashlib
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from lostmotion.error_model.draw_kernel import LANES, ROW, TABLE, mix
from lostmotion.error_model.sobol import Sobol

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from numpy.typing import NDArray

    from lostmotion.laws.distributions import Law
    from lostmotion.spatial import Floats


@dataclass(frozen=True, slots=True)
class Stream:
    """A named stream of uniform random numbers and the distribution that maps them ("joints.A.last
    motion", TwoSided).
    """

    name: str
    law: Law


# The kernel's own function, uncompiled, on whole arrays.
_mix: Callable[[NDArray[np.uint64]], NDArray[np.uint64]] = mix.py_func


def key(seed: int, name: str) -> int:
    """Return the Philox key (128 bits) of this seed and name."""
    return int.from_bytes(
        hashlib.blake2b(f"{seed}\0{name}".encode(), digest_size=16).digest(), "little"
    )


def uniforms(seed: int, name: str, count: int) -> Floats:
    """Return the first `count` uniforms of this stream (count,), strictly between 0 and 1. A longer
    run begins with the values of a shorter one.
    """
    raw = np.random.Philox(key=key(seed, name)).random_raw(count)
    return np.asarray(((raw >> np.uint64(11)).astype(np.float64) + 0.5) * 2.0**-53)


def sobol(seed: int, name: str, columns: int) -> Sobol:
    """Return the scrambled Sobol sequence of this seed and name, with `columns` dimensions."""
    return Sobol.scrambled(columns, np.random.Generator(np.random.Philox(seed=key(seed, name))))


def robot_draws(seed: int, streams: Sequence[Stream], robots: int) -> Floats:
    """Return the draws of each robot (tile, stream, LANES). Robot r is lane r % LANES of tile r //
    LANES; lanes beyond the last robot are zero.
    """
    tiles = -(-robots // LANES)
    out = np.zeros((tiles, len(streams), LANES))
    for row, stream in enumerate(streams):
        values = np.zeros(tiles * LANES)
        values[:robots] = stream.law.quantile(uniforms(seed, stream.name, robots))
        out[:, row, :] = values.reshape(tiles, LANES)
    return out


@functools.lru_cache(maxsize=512)
def visit_table(seed: int, stream: Stream) -> Floats:
    """Return the table of this stream's visit draws (ROW,): TABLE values in random order, followed
    by the first LANES of them again.
    """
    order = np.argsort(
        np.random.Philox(key=key(seed, stream.name + "\0order")).random_raw(TABLE), kind="stable"
    )
    u = (order + uniforms(seed, stream.name, TABLE)) / TABLE
    return np.resize(stream.law.quantile(u), ROW)


def visit_key(seed: int, name: str) -> np.uint64:
    """Return the key (64 bits) that determines the positions at which this stream's table is
    read.
    """
    return np.uint64(key(seed, name) & 0xFFFFFFFFFFFFFFFF)


def visit_draws(
    seed: int,
    streams: Sequence[Stream],
    pose: int | NDArray[np.int64],
    robots: NDArray[np.int64],
    visits: NDArray[np.int64],
) -> Floats:
    """Return the draws of single samples (stream, sample).

    These are the numbers that the kernel reads in bulk; they serve to compose errors exactly and to
    replay an extreme sample.

    pose            number of the pose in the study: one for all samples, or one for each (sample,)
    robots, visits  numbers of the robot and of the visit of each sample (sample,)
    """
    out = np.empty((len(streams), len(robots)))
    counter = np.atleast_1d(pose).astype(np.uint64) * np.uint64(0x9E3779B97F4A7C15)
    counter = counter + (robots // LANES).astype(np.uint64) * np.uint64(0xD1B54A32D192ED03)
    counter = counter + visits.astype(np.uint64) * np.uint64(0xABC98388FB8FAC03)
    lane = robots % LANES
    for row, stream in enumerate(streams):
        start = (_mix(counter ^ visit_key(seed, stream.name)) >> np.uint64(51)).astype(np.int64)
        out[row] = visit_table(seed, stream)[start + lane]
    return out
