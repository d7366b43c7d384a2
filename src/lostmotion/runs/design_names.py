"""Short names of the designs of a run, from the keys that its sweep varies."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lostmotion.io.sweep import Axis

# Longest value in a name: tables and lists may be long.
_LONGEST_LABEL: Final = 32
_NO_SWEEP: Final = "the arm as stated"


def short_keys(axes: Sequence[Axis]) -> list[str]:
    """Return a short name for each swept key: its last step, with the nearest earlier step that
    distinguishes it where needed.

    "A length" for `joints.A.link.length` beside `joints.B.link.length`; where one more step is not
    enough, as many last steps as needed.
    """
    paths = [axis.steps for axis in axes]
    out = []
    for k, path in enumerate(paths):
        others = [other for j, other in enumerate(paths) if j != k]
        same_end = [other for other in others if other[-1] == path[-1]]
        distinct = [
            step
            for at, step in enumerate(path[:-1])
            if all(step not in other[:-1] for other in same_end)
        ]
        if not same_end:
            steps = path[-1:]
        elif distinct:
            steps = [distinct[-1], path[-1]]
        else:
            steps = path[
                -next(
                    (
                        n
                        for n in range(1, len(path))
                        if all(path[-n:] != other[-n:] for other in others)
                    ),
                    len(path),
                ) :
            ]
        out.append(" ".join(steps).replace("_", " "))
    return out if len(set(out)) == len(out) else [axis.key for axis in axes]


def short_labels(axis: Axis) -> list[str]:
    """Return a short text for each value of a key: without a tolerance that all share, and by
    number where texts are equal.
    """
    parts = [text.partition("±") for text in axis.labels]
    shared = len({tolerance.strip() for _, _, tolerance in parts}) == 1
    whole = [bare.strip() for bare, _, _ in parts] if shared else axis.labels
    short = [
        text if len(text) <= _LONGEST_LABEL else f"{text[: _LONGEST_LABEL - 1]}…" for text in whole
    ]
    return [text if short.count(text) == 1 else f"no. {k}" for k, text in enumerate(short, start=1)]


def design_name(axes: Sequence[Axis], design: int) -> str:
    """Return the name of a design: the values of the keys that differ between designs."""
    if not axes:
        return _NO_SWEEP
    varied = [axis for axis in axes if len(axis.values) > 1] or axes
    parts = []
    # the last key changes fastest
    for name, axis in reversed(list(zip(short_keys(varied), varied, strict=True))):
        design, at = divmod(design, len(axis.values))
        parts.append(f"{name} {short_labels(axis)[at]}")
    return ", ".join(reversed(parts))
