"""Sizes of the scratch arrays of a controller in C, and the bytes that its tables take."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from lostmotion.controller_model.tables import (
        Tables,
    )


@dataclass(frozen=True)
class Sizes:
    """Lengths of the scratch arrays of the C core; the largest of any place."""

    factors: int
    sizes: int
    seats: int
    tables: int
    draws: int
    places: int


def sizes_of(tables: Tables) -> Sizes:
    """Return the lengths of the scratch arrays that these tables need."""
    factors = (
        1
        + len(record.curves)
        + len(record.harmonics)
        + sum(len(seat.way) for seat in record.seats)
        + 3 * len(record.thresholds)
        + 9 * len(record.tables)
        for record in tables.records
    )
    return Sizes(
        max(factors),
        max(len(record.sizes) for record in tables.records),
        max(len(record.seats) for record in tables.records),
        sum(len(record.tables) for record in tables.records),
        max(len(tables.draws), 1),
        len(tables.records),
    )


class Bytes(NamedTuple):
    """Sizes of the structures of the C core, and of its arrays on the stack while it compensates,
    in bytes.
    """

    input: int
    output: int
    command: int
    stack: int


def bytes_of(tables: Tables, number_size: int) -> Bytes:
    """Return sizes in bytes for numbers of 4 or 8 bytes, on machines with integers of 4."""
    joints, sizes = len(tables.joints), sizes_of(tables)
    given, output = 2 * joints + 13, 9 + 3 + 2 * joints + 12 + 6 + 2 + 6 * joints
    command, of_integers = joints + 6, max(number_size, 4)
    # Frames and wrenches, the twists of places from three evaluations, one place, its two results,
    # the input, the normal matrix, and small arrays.
    local, places = 12 + sizes.factors + sizes.sizes, (24 + 3 * 6) * sizes.places
    numbers_held = places + local + 3 * sizes.draws + 6 * joints + 200
    stack = numbers_held + 512 // number_size
    return Bytes(
        given * number_size,
        output * number_size + 8,
        command * number_size + of_integers,
        stack * number_size,
    )
