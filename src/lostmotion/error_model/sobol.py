"""Scrambled Sobol sequences: the numbers of `scipy.stats.qmc.Sobol`, without the half second that
it takes to load all of `scipy.stats`.

Sources: S. Joe and F. Y. Kuo, SIAM J. Sci. Comput. 30 (2008) 2635, direction numbers D(6);
J. Matousek, J. Complexity 14 (1998) 527, linear scrambling with a digital shift.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, Self

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from lostmotion.spatial import Floats

BITS: Final = 30
# Of each coordinate from the second on: the primitive polynomial as a binary number, and the first
# direction numbers.
_DIRECTIONS: Final = """
3:1 7:1,3 11:1,3,1 13:1,1,1 19:1,1,3,3 25:1,3,5,13 37:1,1,5,5,17 41:1,1,5,5,5 47:1,1,7,11,19
55:1,1,5,1,1 59:1,1,1,3,11 61:1,3,5,5,31 67:1,3,3,9,7,49 91:1,1,1,15,21,21 97:1,3,1,13,27,49
103:1,1,1,15,7,5 109:1,3,1,15,13,25 115:1,1,5,5,19,61 131:1,3,7,11,23,15,103
137:1,3,7,13,13,15,69 143:1,1,3,13,7,35,63 145:1,3,5,9,1,25,53 157:1,3,1,13,9,35,107
167:1,3,1,5,27,61,31 171:1,1,5,11,19,41,61 185:1,3,5,3,3,13,69 191:1,1,7,13,1,19,1
193:1,3,7,5,13,19,59 203:1,1,3,9,25,29,41 211:1,3,5,13,23,1,55 213:1,3,7,3,13,59,17
229:1,3,1,3,5,53,69 239:1,1,5,5,23,33,13 241:1,1,7,7,1,61,123 247:1,1,7,9,13,61,49
253:1,3,3,5,3,55,33 285:1,3,1,15,31,13,49,245 299:1,3,5,15,31,59,63,97 301:1,3,1,11,11,11,77,249
333:1,3,1,11,27,43,71,9 351:1,1,7,15,21,11,81,45 355:1,3,7,3,25,31,65,79 357:1,3,1,1,19,11,3,205
361:1,1,5,9,19,21,29,157 369:1,3,7,11,1,33,89,185 391:1,3,3,3,15,9,79,71
397:1,3,7,11,15,39,119,27 425:1,1,3,1,11,31,97,225 451:1,1,1,3,23,43,57,177
463:1,3,7,7,17,17,37,71 487:1,3,1,5,27,63,123,213 501:1,1,3,5,11,43,53,133
529:1,3,5,5,29,17,47,173,479 539:1,3,3,11,3,1,109,9,69 545:1,1,1,5,17,39,23,5,343
557:1,3,1,5,25,15,31,103,499 563:1,1,1,11,11,17,63,105,183 601:1,1,5,11,9,29,97,231,363
607:1,1,5,15,19,45,41,7,383 617:1,3,7,7,31,19,83,137,221 623:1,1,1,3,23,15,111,223,83
631:1,1,5,13,31,15,55,25,161 637:1,1,3,13,25,47,39,87,257
"""
_MOST: Final = 1 + len(_DIRECTIONS.split())


@dataclass(frozen=True)
class Sobol:
    """A scrambled Sobol sequence of numbers with 30 bits.

    start  (column,) its first point, times 2^30
    steps  (bit, column) what each bit of a point's number in Gray code adds to that, without carry
    """

    start: NDArray[np.uint64]
    steps: NDArray[np.uint64]

    @classmethod
    def scrambled(cls, columns: int, generator: np.random.Generator) -> Self:
        """Return a sequence in so many dimensions, scrambled by the first generator that this one
        spawns. Raises ValueError for more than 64 dimensions.
        """
        if columns > _MOST:
            raise ValueError(f"a Sobol sequence in {columns} dimensions; expected {_MOST} at most")
        drawn = generator.spawn(1)[0]
        weights = np.uint64(1) << np.arange(BITS, dtype=np.uint64)
        shift = drawn.integers(2, size=(columns, BITS), dtype=np.uint32)
        matrices = np.tril(drawn.integers(2, size=(columns, BITS, BITS), dtype=np.uint32))
        matrices[:, range(BITS), range(BITS)] = 1
        falling = weights[::-1]
        bits = (_directions(columns)[..., None] & falling > 0).astype(np.uint32)
        mixed = bits @ matrices.transpose(0, 2, 1) % 2
        return cls(shift @ weights, (mixed @ falling).T)

    def points(self, power: int) -> Floats:
        """Return the first 2^power points (point, column), 0 to 1."""
        return np.ascontiguousarray(self.columns(power).T)

    def columns(self, power: int) -> Floats:
        """Return the first 2^power points as (column, point), as they are made."""
        out = np.empty((len(self.start), 1 << power), np.uint64)
        out[:, 0] = self.start
        for bit, step in enumerate(self.steps[:power]):
            known = 1 << bit
            np.bitwise_xor(out[:, known - 1 :: -1], step[:, None], out=out[:, known : 2 * known])
        return np.asarray(out * 2.0**-BITS)

    def stretch(self, first: int, last: int) -> Floats:
        """Return the points with the numbers `first` to `last` - 1 (point, column)."""
        number = np.arange(first, last)
        out = np.repeat(self.start[None], last - first, axis=0)
        for bit in range(last.bit_length()):
            odd = (number ^ number >> 1) >> bit & 1
            out ^= np.where(odd[:, None] == 1, self.steps[bit], np.uint64(0))
        return np.asarray(out * 2.0**-BITS)


def _directions(columns: int) -> NDArray[np.uint64]:
    """Return the direction numbers (column, bit), times 2^30."""
    out = np.ones((columns, BITS), np.uint64)
    for row, stated in zip(out[1:], _DIRECTIONS.split(), strict=False):
        polynomial, _, first = stated.partition(":")
        numbers = [int(each) for each in first.split(",")]
        degree = len(numbers)
        for bit in range(degree, BITS):
            new = numbers[bit - degree]
            for k in range(1, degree + 1):
                if int(polynomial) >> (degree - k) & 1:
                    new ^= numbers[bit - k] << k
            numbers.append(new)
        row[:] = numbers
    return out << np.arange(BITS - 1, -1, -1, dtype=np.uint64)
