"""The Monte Carlo kernel in JAX, for a graphics processor: the same draws and sums in float64, with
whole arrays instead of loops.

It differs from `kernel` and `single_visit_kernel` only by rounding (sums run in another order): a
sample that is within rounding of a bin's edge may be counted in the next bin. JAX is imported here
and nowhere else.
"""

from __future__ import annotations

import functools
import importlib.util
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from lostmotion.error_model.draw_kernel import LANES, ROW
from lostmotion.error_model.error_bins import BINS, FIRST_BIN, MANTISSA_BITS, ROW_OF_BINS
from lostmotion.errors import LostmotionError
from lostmotion.propagation.montecarlo.kernel import (
    COLUMNS,
    FINE,
    FIRST_QUANTILE,
    LARGEST,
    LARGEST_ROBOT,
    LARGEST_VISIT,
    MEAN,
    MEAN_ERROR,
    MEAN_SQUARE,
    QUANTILES,
)

if TYPE_CHECKING:
    from collections.abc import Callable

    from lostmotion.spatial import Floats

Array = Any  # jax.Array; JAX is an optional dependency
# Number of errors in memory at a time; each takes about a hundred bytes.
_AT_ONCE: Final = 4_000_000


def refuse_without_gpu() -> None:
    """Raise LostmotionError where JAX is not installed, or finds no graphics processor."""
    if importlib.util.find_spec("jax") is None:
        raise LostmotionError(
            "a study on a GPU needs JAX, which is not installed\n  pip install 'lostmotion[gpu]'"
        )
    import jax

    if jax.default_backend() == "cpu":
        raise LostmotionError(
            'JAX finds no GPU here, only the processor\n  leave device = "gpu" out, or '
            "install JAX for your GPU: pip install 'lostmotion[gpu]'\n"
            "  to see why: python -c 'import jax; jax.devices()'"
        )


def run_block(
    first_pose: int,
    bias: Floats,
    shift: Floats,
    plays: Floats,
    robot_columns: np.ndarray,
    robot_draws: Floats,
    visit_columns: np.ndarray,
    visit_tables: np.ndarray,
    visit_keys: np.ndarray,
    product_columns: np.ndarray,
    product_tables: np.ndarray,
    product_keys: np.ndarray,
    product_factors: Floats,
    frictions: Floats,
    tables: Floats,
    robots: int,
    visits: int,
    groups: int,
    z: float,
    per_pose: Floats,
    ap_rp: Floats,
    robot_sums: Floats,
    group_hist: np.ndarray,
) -> tuple[int, int]:
    """Form the errors of every pose, robot and visit of one block of poses, and reduce them.
    Arguments and answer as of `kernel.run_block`.
    """
    import jax

    poses, tiles = len(bias), len(robot_draws)
    lowest, highest = BINS, -1
    step = min(max(_AT_ONCE // (tiles * LANES * visits), 1), poses)
    with jax.enable_x64(True):
        work = _compiled()
        products = len(product_columns)  # their tables and keys are filled up to a multiple of four
        product = product_tables[:products], product_keys[:products], product_factors, frictions
        constant = (robot_draws, visit_tables, visit_keys, *product, tables)
        steady = [jax.numpy.asarray(x) for x in constant]
        for start in range(0, poses, step):
            # The last step is filled up with repetitions of the last pose, which do not count.
            rows = np.minimum(np.arange(start, start + step), poses - 1)
            real = np.arange(start, start + step) < poses
            screws = [
                _taken(shift, columns, rows)
                for columns in (robot_columns, visit_columns, product_columns)
            ]
            found = work(
                first_pose + rows,
                real,
                bias[rows],
                plays[rows],
                *screws,
                *steady,
                z,
                robots=robots,
                visits=visits,
                groups=groups,
            )
            table, both, sums, counts = (np.asarray(x) for x in found)
            per_pose[rows[real]] = table[real]
            if visits > 1:
                ap_rp[rows[real]] = both.reshape(step, 2, -1)[real, :, :robots]
            robot_sums += sums.ravel()[:robots]
            group_hist += counts.reshape(group_hist.shape)
            counted = np.flatnonzero(counts.reshape(group_hist.shape).any(axis=0))
            lowest, highest = min(lowest, int(counted[0])), max(highest, int(counted[-1]))
    return lowest, highest


def _taken(shift: Floats, columns: np.ndarray, rows: np.ndarray) -> Floats:
    """Return the screws (term, 3, pose) of these columns; a column below zero has no effect."""
    return np.asarray(
        np.where(
            (columns >= 0)[:, None, None], shift[:, columns][:, :, rows].transpose(1, 0, 2), 0.0
        )
    )


@functools.cache
def _compiled() -> Callable[..., Any]:
    import jax

    return jax.jit(_reduced, static_argnames=("robots", "visits", "groups"))  # type: ignore[no-any-return, unused-ignore]


def _reduced(
    pose: Array,
    real: Array,
    bias: Array,
    plays: Array,
    robot_screws: Array,
    visit_screws: Array,
    product_screws: Array,
    robot_draws: Array,
    visit_tables: Array,
    visit_keys: Array,
    product_tables: Array,
    product_keys: Array,
    product_factors: Array,
    frictions: Array,
    tables: Array,
    z: Array,
    *,
    robots: int,
    visits: int,
    groups: int,
) -> tuple[Array, Array, Array, Array]:
    """Return the table (pose, COLUMNS), AP and RP (pose, 2, tile, lane), each robot's summed mean
    error (tile, lane), all counts (group x bin).
    """
    import jax
    import jax.numpy as jnp

    tiles = len(robot_draws)
    robot = jnp.arange(tiles * LANES).reshape(tiles, LANES)
    built = robot < robots
    # Everything below lies as (pose, tile, visit, lane), the components of a vector before it.
    fixed = bias.T[:, :, None, None] + jnp.einsum(
        "tcp,ntl->cpnl", robot_screws, robot_draws, precision=jax.lax.Precision.HIGHEST
    )
    errors = jnp.broadcast_to(fixed[:, :, :, None], (3, len(pose), tiles, visits, LANES))
    reads = _reader(pose, tiles, visits, tables)

    def add(errors: Array, term: tuple[Array, Array, Array]) -> tuple[Array, None]:
        screw, table, key = term
        return errors + screw[:, :, None, None, None] * reads(table, key), None

    def add_product(errors: Array, term: tuple[Array, ...]) -> tuple[Array, None]:
        screw, table, key, factor, friction, play = term
        closed, shut, opened = (play[:, None, None, k] for k in range(3))
        weight = factor * jnp.where(friction <= closed, shut, opened)
        return errors + screw[:, :, None, None, None] * (
            weight[:, :, None] * reads(table, key)
        ), None

    errors, _ = jax.lax.scan(add, errors, (visit_screws, visit_tables, visit_keys))
    of_robots = (
        product_factors.transpose(1, 0, 2),
        frictions.transpose(1, 0, 2),
        plays.transpose(1, 0, 2),
    )
    errors, _ = jax.lax.scan(
        add_product, errors, (product_screws, product_tables, product_keys, *of_robots)
    )

    square = (errors * errors).sum(axis=0)
    size = jnp.sqrt(square)
    counted = jnp.broadcast_to(built[:, None] & real[:, None, None, None], square.shape)
    bins = jnp.clip(
        (jax.lax.bitcast_convert_type(square, jnp.int64) >> (52 - MANTISSA_BITS)) - FIRST_BIN,
        0,
        BINS - 1,
    )
    row = jnp.minimum(robot, robots - 1) * groups // robots * ROW_OF_BINS
    counts = jnp.zeros(groups * ROW_OF_BINS, jnp.int64).at[row[:, None] + bins].add(counted)

    mean_of_robot = jnp.where(built, size.mean(axis=2), 0.0)
    mean = mean_of_robot.sum(axis=(1, 2)) / robots
    mean_square = jnp.where(counted, square, 0.0).sum(axis=(1, 2, 3)) / (robots * visits)
    of_means = jnp.maximum((mean_of_robot**2).sum(axis=(1, 2)) / robots - mean**2, 0.0)
    variance = mean_square - mean**2
    between = jnp.where(variance > 0, jnp.clip(of_means / variance, 0.0, 1.0), 0.0)

    table = (
        jnp.zeros((len(pose), COLUMNS)).at[:, MEAN].set(mean).at[:, MEAN_SQUARE].set(mean_square)
    )
    table = table.at[:, MEAN_ERROR].set(z * jnp.sqrt(of_means / max(robots - 1, 1)))
    # A pose that does not count has no robots either: it is separated afterwards, not here.
    ranked = jnp.where(built[:, None], square, -1.0).reshape(len(pose), -1)
    at = ranked.argmax(axis=1)
    high = jnp.sqrt(ranked.max(axis=1))
    low = jnp.sqrt(jnp.where(built[:, None], square, jnp.inf).min(axis=(1, 2, 3)))
    table = (
        table.at[:, LARGEST]
        .set(high)
        .at[:, LARGEST_ROBOT]
        .set(at // (visits * LANES) * LANES + at % LANES)
    )
    table = table.at[:, LARGEST_VISIT].set(at // LANES % visits)
    table = table.at[:, FIRST_QUANTILE:].set(_quantiles(size, built, low, high, between, z, robots))
    return (
        table,
        _accuracy_and_repeatability(errors),
        (mean_of_robot * real[:, None, None]).sum(axis=0),
        counts,
    )


def _reader(pose: Array, tiles: int, visits: int, tables: Array) -> Callable[[Array, Array], Array]:
    """Return what a stream reads at every pose, tile, visit and lane, by its table and key:
    `kernel.place_in_table` on whole arrays.
    """
    import jax.numpy as jnp

    def scattered(factor: int, axis: Array) -> Array:
        return axis.astype(jnp.uint64) * jnp.uint64(factor)

    here = (
        scattered(0x9E3779B97F4A7C15, pose)[:, None, None]
        + scattered(0xD1B54A32D192ED03, jnp.arange(tiles))[:, None]
    )
    here = here + scattered(0xABC98388FB8FAC03, jnp.arange(visits))

    def read(table: Array, key: Array) -> Array:
        x = here ^ key
        x = (x ^ (x >> 30)) * jnp.uint64(0xBF58476D1CE4E5B9)
        x = (x ^ (x >> 27)) * jnp.uint64(0x94D049BB133111EB)
        place = table * ROW + ((x ^ (x >> 31)) >> 51).astype(jnp.int64)
        return tables[place[..., None] + jnp.arange(LANES)]

    return read


def _quantiles(
    size: Array, built: Array, low: Array, high: Array, between: Array, z: Array, robots: int
) -> Array:
    """Return each pose's quantiles and the ends of their intervals (pose, 3 x quantile), as
    `kernel` does.
    """
    import jax
    import jax.numpy as jnp

    poses, _, visits, _ = size.shape
    samples = robots * visits
    width = (high - low) / FINE
    scale = jnp.where(width > 0, 1.0 / width, 0.0).astype(jnp.float32)
    above = (size.astype(jnp.float32) - low.astype(jnp.float32)[:, None, None, None]) * scale[
        :, None, None, None
    ]
    bins = jnp.clip(above.astype(jnp.int32), 0, FINE - 1)
    row = jnp.arange(poses)[:, None, None, None]
    hist = (
        jnp.zeros((poses, FINE), jnp.int64)
        .at[row, bins]
        .add(jnp.broadcast_to(built[:, None], bins.shape))
    )
    ladder = jnp.cumsum(hist, axis=1).astype(jnp.float64)

    def at(rank: Array) -> tuple[Array, Array, Array]:
        """Find the bin of this rank at every pose, how many lie below its end, and the error
        there.
        """
        found = jnp.minimum(jax.vmap(jnp.searchsorted)(ladder, rank), FINE - 1)
        below = jnp.take_along_axis(ladder, found[:, None], axis=1)[:, 0]
        before = jnp.where(
            found > 0,
            jnp.take_along_axis(ladder, jnp.maximum(found - 1, 0)[:, None], axis=1)[:, 0],
            0.0,
        )
        return (
            found,
            below,
            low
            + width * (found + jnp.maximum(rank - before, 0.0) / jnp.maximum(below - before, 1.0)),
        )

    columns = []
    for level in QUANTILES:
        found, below, value = at(jnp.full(poses, level * samples))
        per_robot = jnp.where(built, (bins <= found[:, None, None, None]).sum(axis=2), 0)
        clusters = (per_robot**2).sum(axis=(1, 2)) / (float(visits) * visits * robots) - (
            below / samples
        ) ** 2
        error = z * jnp.sqrt(
            jnp.maximum(
                clusters / max(robots - 1, 1),
                level * (1 - level) * (1 + (visits - 1) * between) / samples,
            )
        )
        columns.append(value)
        columns += [
            jnp.where((end > 0) & (end < 1), at(end * samples)[2], jnp.nan)
            for end in (level - error, level + error)
        ]
    return jnp.stack(columns, axis=1)


def _accuracy_and_repeatability(errors: Array) -> Array:
    """Return AP and RP (pose, 2, tile, lane) of errors (3, pose, tile, visit, lane); of no use
    where there is one visit.
    """
    import jax.numpy as jnp

    visits = errors.shape[3]
    centre = errors.mean(axis=3)
    away = ((errors - centre[:, :, :, None]) ** 2).sum(axis=0)
    mean = jnp.sqrt(away).mean(axis=2)
    spread = jnp.maximum(away.sum(axis=2) - visits * mean**2, 0.0) / max(visits - 1, 1)
    return jnp.stack([jnp.sqrt((centre**2).sum(axis=0)), mean + 3 * jnp.sqrt(spread)], axis=1)
