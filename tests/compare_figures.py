"""Compare every figure of every question about every example between two versions of the package.

    python tests/compare_figures.py record BEFORE --package PATH/TO/OLD/src
    python tests/compare_figures.py record AFTER
    python tests/compare_figures.py compare BEFORE AFTER

`record` runs each question with a fixed seed and keeps its result.json and its arrays. `compare`
prints each figure that moved by more than its kind allows, with its place, both values and the
relative change. Tables are matched by their keys, rows and columns by their labels. Those with
changed labels are matched in their order where they lie between the same neighbours, are as many
and have the same units (tables: the same rows); each such pair of labels is listed. All others are
listed as gone or new. The exit code is 1 where a figure moved or something is gone or new.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import re
import subprocess
import sys
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np
import xarray

from lostmotion.printed import factor_of, si_of

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

_LAYOUT_IN_SI: Final = 4
ROOT: Final = Path(__file__).parents[1]
EXAMPLES: Final = ROOT / "examples"
ARMS: Final = ("z-arm.toml", "ur5e.urdf", "arm-from-drawings.toml", "paper/z-arm-lumped.toml")
# Relative limits: sums in another order; differences of such sums (RP); figures without sampling
# over all poses, their mean, and at single poses.
MONTE_CARLO, REPEATABILITY = 1e-10, 1e-8
WITHOUT_SAMPLING, MEAN_WITHOUT_SAMPLING, AT_A_POSE = 1e-3, 5e-4, 7e-3
# The share of poses and cells that must keep to the limit at single poses.
_POSES: Final = 0.99
# Below this part of the largest figure of its table in the same unit a figure is the rounding of
# another. Shares of a mean square may move by this part of the whole.
_ROUNDING: Final = 1e-12
_SHARES: Final = ("levels", "budget", "causes", "budget_levels", "causes_levels")
# Older versions called percentiles '95 % below'.
_PERCENTILE: Final = re.compile(r"([\d.]+) %( of robots)? below")


def commands() -> Iterator[tuple[str, list[str]]]:
    """Yield the name and the words of every question that is asked about an example: of some arms
    by default, of all others with few poses and robots.
    """
    others = [*EXAMPLES.glob("*.toml"), *(EXAMPLES / "closed-chains").glob("*.toml")]
    beside = {(EXAMPLES / each).with_suffix(".toml") for each in ARMS}
    for path, few in (
        *((EXAMPLES / arm, False) for arm in ARMS),
        *((each, True) for each in sorted(others) if each not in beside),
    ):
        yield from _of_arm(str(path), path.stem, few=few)
    z_arm, compared = (str(EXAMPLES / each) for each in ("z-arm.toml", "z-arm-drawn.toml"))
    for measured in ("z-arm", "z-arm-loads"):
        file = str(EXAMPLES / "measured" / f"{measured}.csv")
        words = ["iso9283", z_arm, "--measured", file, "--instrument", "5 µm"]
        yield f"measured-{measured}", words
    for task in sorted((EXAMPLES / "tasks").glob("*.toml")):
        six_axis = str(EXAMPLES / "six-axis.toml")  # as the examples themselves say
        yield f"task-{task.stem}", ["task", six_axis, "--by", str(task)]
    yield "compare-z-arm", ["compare", z_arm, compared, "--poses", "512"]
    sweep = str(EXAMPLES / "sweep" / "z-arm-gearboxes.toml")
    yield "sweep-z-arm", ["sweep", z_arm, "--by", sweep, "--poses", "512"]
    for gauge in ("printed-dial", "printed-tag"):
        rows = str(EXAMPLES / "calibration" / f"{gauge}.csv")
        words = ["calibrate", str(EXAMPLES / "printed-hobby-arm.toml"), "--measured", rows]
        yield f"calibrate-{gauge}", words
    yield "size-z-arm", ["size", z_arm]
    target = str(EXAMPLES / "sizing" / "z-arm-target.toml")
    yield "choose-z-arm", ["size", z_arm, "--by", target]
    for part in sorted((EXAMPLES / "gearbox").glob("*.toml")):
        yield f"gear-{part.stem}", ["gear", str(part)]
    for part in sorted((EXAMPLES / "bearing").glob("*.toml")):
        yield f"bearing-{part.stem}", ["bearing", str(part), "--force-radial", "3 kN"]


def _of_arm(path: str, name: str, *, few: bool) -> Iterator[tuple[str, list[str]]]:
    """Yield the questions about one arm."""
    poses = ["--poses", "256"] if few else []
    sampled = [*poses, "--robots", "100", "--visits", "4"] if few else []
    yield f"study-{name}", ["run", path, *sampled]
    yield f"analytic-{name}", ["run", path, "--method", "analytic", *poses]
    yield f"statics-{name}", ["statics", path, *poses]
    yield f"iso9283-{name}", ["iso9283", path, *(["--robots", "100"] if few else [])]
    yield f"map-{name}", ["map", path, "--target", "1 mm", *poses]
    yield f"target-{name}", ["target", path, "--error", "1.15 mm", *sampled]


def record(folder: Path, package: Path) -> list[str]:
    """Write NAME.json for every question that the package in this folder answers, and return the
    names of those that it refuses.
    """
    folder.mkdir(parents=True, exist_ok=True)
    refused = []
    for name, words in commands():
        out = folder / f"{name}.out"
        environment = {**os.environ, "PYTHONPATH": str(package)}
        done = subprocess.run(
            [sys.executable, "-m", "lostmotion", *words, "--out", str(out), "--force"],
            env=environment,
            capture_output=True,
            text=True,
            check=False,
        )
        # a task that fails too often is an answer, too, of exit code 1
        if not (out / "result.json").exists():
            refused.append(f"{name}: exit code {done.returncode}: {done.stderr.strip()[:200]}")
            continue
        (folder / f"{name}.json").write_text(
            (out / "result.json").read_text(encoding="utf-8"), encoding="utf-8"
        )
        print(name, flush=True)  # noqa: T201 - progress of a script
    return refused


@dataclass(frozen=True)
class Move:
    """A figure that differs: its place, both values, and the relative change; NaN where only one of
    them is a number.
    """

    place: str
    before: float | str | None
    after: float | str | None
    change: float

    def __str__(self) -> str:
        """Return the move in one line."""
        return f"{self.place}: {self.before} -> {self.after} ({self.change:.1e})"


@dataclass
class Comparison:
    """What differs between two results: figures that moved, labels that changed, and tables, rows
    and columns that only one of them has.
    """

    moves: list[Move] = field(default_factory=list)
    renamed: set[str] = field(default_factory=set)
    gone: list[str] = field(default_factory=list)
    new: list[str] = field(default_factory=list)


def matched(
    before: list[str], after: list[str], compatible: Callable[[int, int], bool]
) -> list[tuple[int, int]]:
    """Return pairs of positions of the same label and occurrence, then those of changed labels
    between the same neighbours.

    The latter only where both sides have as many labels there, which are compatible in their order.
    """
    where = {name: j for j, name in enumerate(_numbered(after))}
    pairs = [(i, where[name]) for i, name in enumerate(_numbered(before)) if name in where]
    olds, news = {i for i, _ in pairs}, {j for _, j in pairs}
    for i, j in [(-1, -1), *pairs]:
        old, new = _run(i + 1, len(before), olds), _run(j + 1, len(after), news)
        ends = (old.stop, new.stop)
        if (
            len(old) == len(new)
            and (ends == (len(before), len(after)) or ends in pairs)
            and all(map(compatible, old, new))
        ):
            pairs = [*pairs, *zip(old, new, strict=True)]
    return sorted(pairs)


def _numbered(labels: list[str]) -> list[tuple[str, int]]:
    """Return each label in the words of today, with the number of earlier rows of the same
    label.
    """
    seen: Counter[str] = Counter()
    out = []
    for label in labels:
        name = _PERCENTILE.sub(r"\1th percentile\2", label)
        out.append((name, seen[name]))
        seen[name] += 1
    return out


def _run(start: int, end: int, taken: set[int]) -> range:
    return range(start, next((k for k in range(start, end) if k in taken), end))


def limits(question: str, section: str, row: str, column: str, unit: str) -> tuple[float, float]:
    """Return by which part of itself a figure may move, and by how much in its unit."""
    if section in _SHARES and unit == "%" and "halving" not in column:
        return 0.0, 100.0 * _ROUNDING
    if question.startswith(("analytic", "map")) and section != "halving":
        return (
            MEAN_WITHOUT_SAMPLING
            if row == "mean"
            else AT_A_POSE
            if " pose" in row
            else WITHOUT_SAMPLING,
            0.0,
        )
    return REPEATABILITY if "RP" in row or section.startswith("rp") else MONTE_CARLO, 0.0


def comparison(question: str, before: dict[str, Any], after: dict[str, Any]) -> Comparison:
    """Return what differs between two results of a question, the largest moves first."""
    out = Comparison()
    old, new = (result["sections"] for result in (before, after))
    for table, other_table in _pairs(out, "tables", old, new, "key"):
        key = other_table["key"]
        largest: dict[str, float] = {}
        for figure in [figure for row in table["rows"] for figure in row["figures"]]:
            size = max(
                abs(value) if isinstance(value, float) and math.isfinite(value) else 0.0
                for _, value in _ends(figure)
            )
            largest[figure["unit"]] = max(largest.get(figure["unit"], 0.0), size)
        for row, other in _pairs(out, key, table["rows"], other_table["rows"], "label"):
            for one, two in _pairs(
                out, f"{key}: {other['label']}", row["figures"], other["figures"], "name"
            ):
                relative, absolute = limits(question, key, other["label"], two["name"], two["unit"])
                absolute = max(absolute, _ROUNDING * largest[one["unit"]])
                for (end, x), (_, y) in zip(_ends(one), _ends(two), strict=True):
                    place = f"{key}: {other['label']}: {two['name']}.{end}"
                    if not (isinstance(x, float) and isinstance(y, float)):
                        out.moves += [Move(place, x, y, math.nan)] if x != y else []
                    elif x != y and not abs(x - y) <= max(relative * max(abs(x), abs(y)), absolute):
                        out.moves.append(Move(place, x, y, abs(x - y) / max(abs(x), abs(y))))
    out.moves.sort(key=lambda move: -move.change if math.isfinite(move.change) else -math.inf)
    return out


def in_si(result: dict[str, Any]) -> dict[str, Any]:
    """Return a result with the numbers of its tables in SI, in which layouts before the fourth were
    not.
    """
    if result.get("layout", 1) >= _LAYOUT_IN_SI:
        return result
    for figure in (
        figure
        for section in result["sections"]
        for row in section["rows"]
        for figure in row["figures"]
    ):
        by = factor_of(figure["unit"] or "1")
        figure["unit"] = si_of(figure["unit"] or "1")
        figure["value"] = _divided(figure["value"], by)
        if figure["interval"] is not None:
            figure["interval"] = [_divided(end, by) for end in figure["interval"]]
    return result


def _divided(value: float | str | None, by: float) -> float | str | None:
    return value / by if isinstance(value, float) and by != 1 else value


def _pairs(
    out: Comparison, place: str, before: list[Any], after: list[Any], name: str
) -> list[tuple[Any, Any]]:
    """Return the tables, rows or columns that belong together, and list the others in `out`."""
    olds, news = ([item[name] for item in items] for items in (before, after))
    pairs = matched(olds, news, lambda i, j: _content(before[i]) == _content(after[j]))
    out.renamed |= {
        f"{place.partition(':')[0]}: {olds[i]} -> {news[j]}" for i, j in pairs if olds[i] != news[j]
    }
    out.gone += [
        f"{place}: {label}" for i, label in enumerate(olds) if i not in {i for i, _ in pairs}
    ]
    out.new += [
        f"{place}: {label}" for j, label in enumerate(news) if j not in {j for _, j in pairs}
    ]
    return [(before[i], after[j]) for i, j in pairs]


def _content(item: dict[str, Any]) -> list[str]:
    """Return what items of changed names must share: the labels of a table's rows, the units of a
    row's or a column's figures.
    """
    return (
        [row["label"] for row in item["rows"]]
        if "rows" in item
        else [figure["unit"] for figure in item.get("figures", [item])]
    )


def _ends(figure: dict[str, Any]) -> list[tuple[str, float | str | None]]:
    low, high = figure["interval"] or (None, None)
    return [
        (name, float(value) if isinstance(value, int | float) else value)
        for name, value in (("value", figure["value"]), ("low", low), ("high", high))
    ]


def array_moves(question: str, before: Path, after: Path) -> list[Move]:
    """Return the arrays that moved: by single entries, or without sampling by more than a hundredth
    of the poses or cells.
    """
    out = []
    with xarray.open_dataset(before) as old, xarray.open_dataset(after) as new:
        for name in [str(name) for name in old.variables if name in new.variables]:
            x, y = (np.asarray(each[name].values) for each in (old, new))
            if x.shape != y.shape:
                out.append(Move(f"array {name}", str(x.shape), str(y.shape), math.nan))
            elif x.size and x.dtype.kind in "biuf":
                x, y = x.astype(float), y.astype(float)
                size = np.maximum(np.abs(x), np.abs(y))
                same = (
                    (x == y)
                    | (np.isnan(x) & np.isnan(y))
                    | (size <= _ROUNDING * np.nanmax(size, initial=0.0))
                )
                change = np.nan_to_num(
                    np.where(same, 0.0, np.abs(x - y) / np.where(same, 1.0, size)), nan=np.inf
                )
                sampled = not question.startswith(("analytic", "map"))
                level, allowed = (
                    (1.0, REPEATABILITY if "RP" in name else MONTE_CARLO)
                    if sampled
                    else (_POSES, AT_A_POSE)
                )
                at = np.unravel_index(
                    np.argsort(change, axis=None)[math.ceil(level * change.size) - 1], change.shape
                )
                if change[at] > allowed:
                    out.append(
                        Move(
                            f"array {name}{[int(k) for k in at]}",
                            float(x[at]),
                            float(y[at]),
                            float(change[at]),
                        )
                    )
    return out


def main(words: list[str] | None = None) -> int:
    """Record or compare, as the words say; return the exit code."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n\n")[0])
    verbs = parser.add_subparsers(dest="verb", required=True)
    one = verbs.add_parser("record")
    one.add_argument("folder", type=Path)
    one.add_argument("--package", type=Path, default=ROOT / "src")
    two = verbs.add_parser("compare")
    two.add_argument("before", type=Path)
    two.add_argument("after", type=Path)
    asked = parser.parse_args(words)
    if asked.verb == "record":
        lines = record(asked.folder, asked.package.resolve())
        found = len(lines)
    else:
        lines, found = _compared(asked.before, asked.after)
    print("\n".join(lines))  # noqa: T201 - the answer of a script
    return 1 if found else 0


def _compared(before: Path, after: Path) -> tuple[list[str], int]:
    """Return the lines that `compare` prints, and the number of differences."""
    lines, found, renamed = [], 0, Counter[str]()
    for path in sorted(before.glob("*.json")):
        other = after / path.name
        if not other.exists():
            lines.append(f"{path.stem}: not recorded after")
            found += 1
            continue
        differs = comparison(
            path.stem,
            *(in_si(json.loads(each.read_text(encoding="utf-8"))) for each in (path, other)),
        )
        arrays = [folder / f"{path.stem}.out" / "arrays.nc" for folder in (before, after)]
        differs.moves += (
            array_moves(path.stem, *arrays) if all(each.exists() for each in arrays) else []
        )
        lines += [f"{path.stem}: {move}" for move in differs.moves]
        for what, rows in (("gone", differs.gone), ("new", differs.new)):
            lines += [f"{path.stem}: {len(rows)} {what}: {'; '.join(rows)}"] if rows else []
        found += len(differs.moves) + len(differs.gone) + len(differs.new)
        renamed.update(differs.renamed)
    return [
        *lines,
        *(
            f"renamed in {count} of the questions: {pair}"
            for pair, count in sorted(renamed.items())
        ),
    ], found


if __name__ == "__main__":
    sys.exit(main())
