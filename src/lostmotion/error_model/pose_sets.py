"""Pose matrices of independent sets of poses: small sets share the work of one matrix."""

from __future__ import annotations

from typing import TYPE_CHECKING

from lostmotion.error_model.pose_matrix import pose_matrix
from lostmotion.mechanism.state import BLOCK

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence

    from lostmotion.error_model.pose_matrix import PoseMatrix
    from lostmotion.mechanism.arm import Arm
    from lostmotion.spatial import Floats


def blocks_of_sets(count: int, sets: int, most: int) -> list[slice]:
    """Return blocks of at most `most` of `count` poses, in order, each within one of the
    independent sets of equal size that the poses consist of. Raises ValueError where the sets would
    differ in size.
    """
    each, left = divmod(count, sets)
    if left:
        raise ValueError(f"{count} poses in {sets} sets; expected sets of equal size")
    return [
        slice(start, min(start + most, first + each))
        for first in range(0, count, each or 1)
        for start in range(first, first + each, most)
    ]


def together(spans: Sequence[tuple[int, int]], most: int) -> list[list[tuple[int, int]]]:
    """Return spans of poses (first, last, exclusive), which follow one another, in groups of at
    most `most` poses; a longer one is alone.
    """
    out: list[list[tuple[int, int]]] = []
    for span in spans:
        if out and span[1] - out[-1][0][0] <= most:
            out[-1].append(span)
        else:
            out.append([span])
    return out


def matrices_of(
    blocks: Sequence[slice], matrix_at: Callable[[slice], PoseMatrix]
) -> Iterator[PoseMatrix]:
    """Yield the pose matrix of each block of poses, which follow one another; `matrix_at` returns
    that of any poses. A pose has the same bits in any of them.
    """
    for here in together([(block.start, block.stop) for block in blocks], BLOCK):
        start = here[0][0]
        matrix = matrix_at(slice(start, here[-1][1]))
        if len(here) == 1:
            yield matrix
            continue
        for first, last in here:
            yield matrix.stretch(first - start, last - start)


def matrices_of_sets(
    arm: Arm, q: Floats, sets: int, *, approach: float = 0.0
) -> Iterator[tuple[int, PoseMatrix]]:
    """Yield for each block of at most `BLOCK` poses (pose, joint) the number of its set, as in
    `blocks_of_sets`, and its pose matrix; approach and errors as for `pose_matrix`.
    """
    blocks = blocks_of_sets(len(q), sets, BLOCK)
    matrices = matrices_of(blocks, lambda rows: pose_matrix(arm, q[rows], approach=approach))
    for block, matrix in zip(blocks, matrices, strict=True):
        yield block.start * sets // len(q), matrix
