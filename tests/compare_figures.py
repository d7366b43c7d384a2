"""Compare every figure of every question about every example between two versions of the package.

    python tests/compare_figures.py record BEFORE --package PATH/TO/OLD/src
    python tests/compare_figures.py record AFTER
    python tests/compare_figures.py compare BEFORE AFTER

`record` runs each question with a fixed seed and keeps its result.json. `compare` prints each figure that moved by more than its kind
allows, with its place, both values and the relative change, and exits with 1 where there is one. Figures are matched by section, row and
column, not by their labels, so a change of words alone is no difference.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

if TYPE_CHECKING:
    from collections.abc import Iterator

ROOT: Final = Path(__file__).parents[1]
EXAMPLES: Final = ROOT / "examples"
ARMS: Final = ("z-arm.toml", "ur5e.urdf", "arm-from-drawings.toml", "paper/z-arm-lumped.toml")
# What a figure may move by: sums in another order; differences of such sums (RP); figures without sampling, to the error that their method states.
MONTE_CARLO, REPEATABILITY, WITHOUT_SAMPLING = 1e-10, 1e-8, 1e-3
# Below this share of the largest figure of its row a figure is the rounding of another.
_ROUNDING: Final = 1e-12


def commands() -> Iterator[tuple[str, list[str]]]:
    """Yield the name and the words of every question that is asked about an example."""
    for arm in ARMS:
        path, name = str(EXAMPLES / arm), Path(arm).stem
        yield f"study-{name}", ["run", path]
        yield f"analytic-{name}", ["run", path, "--method", "analytic"]
        yield f"statics-{name}", ["statics", path]
        yield f"iso9283-{name}", ["iso9283", path]
        yield f"map-{name}", ["map", path, "--target", "1 mm"]
        yield f"target-{name}", ["target", path, "--error", "1.15 mm"]
    for measured in ("z-arm.csv", "z-arm-loads.csv"):
        yield (
            f"measured-{measured[:-4]}",
            ["iso9283", str(EXAMPLES / ARMS[0]), "--measured", str(EXAMPLES / "measured" / measured), "--instrument", "5 µm"],
        )
    yield "size-z-arm", ["size", str(EXAMPLES / ARMS[0])]
    yield "choose-z-arm", ["size", str(EXAMPLES / ARMS[0]), "--by", str(EXAMPLES / "sizing" / "z-arm-target.toml")]
    for part in sorted((EXAMPLES / "gearbox").glob("*.toml")):
        yield f"gear-{part.stem}", ["gear", str(part)]
    for part in sorted((EXAMPLES / "bearing").glob("*.toml")):
        yield f"bearing-{part.stem}", ["bearing", str(part), "--force-radial", "3 kN"]


def record(folder: Path, package: Path) -> list[str]:
    """Write NAME.json for every question that the package in this folder answers, and return the names of those that it refuses."""
    folder.mkdir(parents=True, exist_ok=True)
    refused = []
    for name, words in commands():
        out = folder / f"{name}.out"
        environment = {**os.environ, "PYTHONPATH": str(package)}
        done = subprocess.run(
            [sys.executable, "-m", "lostmotion", *words, "--out", str(out), "--force"], env=environment, capture_output=True, text=True, check=False
        )
        if done.returncode:
            refused.append(f"{name}: exit code {done.returncode}: {done.stderr.strip()[:200]}")
            continue
        (folder / f"{name}.json").write_text((out / "result.json").read_text(encoding="utf-8"), encoding="utf-8")
        print(name, flush=True)  # noqa: T201 - progress of a script
    return refused


@dataclass(frozen=True)
class Move:
    """A figure that differs: its place, both values, and the relative change; NaN where only one of them is a number."""

    place: str
    before: float | str | None
    after: float | str | None
    change: float


def figures(result: dict[str, Any]) -> Iterator[tuple[str, str, float | str | None, float]]:
    """Yield place, label, value and scale of every figure and interval end; the scale is the largest of its row in the same unit."""
    for section in result["sections"]:
        for r, row in enumerate(section["rows"]):
            ends = [(f, part, value) for f, figure in enumerate(row["figures"]) for part, value in _parts(figure)]
            largest: dict[str, float] = {}
            for f, _, value in ends:
                unit = row["figures"][f]["unit"]
                largest[unit] = max(largest.get(unit, 0.0), abs(value) if isinstance(value, float) and math.isfinite(value) else 0.0)
            for f, part, value in ends:
                yield f"{section['key']}[{r}][{f}].{part}", row["label"], value, largest[row["figures"][f]["unit"]]


def _parts(figure: dict[str, Any]) -> list[tuple[str, float | str | None]]:
    low, high = figure["interval"] or (None, None)
    return [
        (name, float(value) if isinstance(value, int | float) else value)
        for name, value in (("value", figure["value"]), ("low", low), ("high", high))
    ]


def moves(before: dict[str, Any], after: dict[str, Any], allowed: float) -> list[Move]:
    """Return the figures that moved by more than `allowed`, relative, the largest change first; RP may move as differences of sums do."""
    old = {place: (label, value, scale) for place, label, value, scale in figures(before)}
    new = {place: (label, value, scale) for place, label, value, scale in figures(after)}
    out = []
    for place in dict.fromkeys([*old, *new]):
        label, a, scale = old.get(place, ("", None, 0.0))
        named, b, _ = new.get(place, (label, None, 0.0))
        if isinstance(a, float) and isinstance(b, float):
            change = 0.0 if a == b or max(abs(a), abs(b)) <= _ROUNDING * scale else abs(a - b) / max(abs(a), abs(b))
            if change > max(allowed, REPEATABILITY if label.startswith("RP") else 0.0):
                out.append(Move(f"{place} ({named or label})", a, b, change))
        elif a != b:
            out.append(Move(f"{place} ({named or label})", a, b, math.nan))
    return sorted(out, key=lambda move: -move.change if math.isfinite(move.change) else -math.inf)


def main(words: list[str] | None = None) -> int:
    """Record or compare, as the words say; return the exit code."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    verbs = parser.add_subparsers(dest="verb", required=True)
    one = verbs.add_parser("record")
    one.add_argument("folder", type=Path)
    one.add_argument("--package", type=Path, default=ROOT / "src")
    two = verbs.add_parser("compare")
    two.add_argument("before", type=Path)
    two.add_argument("after", type=Path)
    asked = parser.parse_args(words)
    if asked.verb == "record":
        refused = record(asked.folder, asked.package.resolve())
        print("\n".join(refused))  # noqa: T201 - the answer of a script
        return 1 if refused else 0
    found = 0
    for path in sorted(asked.before.glob("*.json")):
        other = asked.after / path.name
        if not other.exists():
            print(f"{path.stem}: not recorded after")  # noqa: T201 - the answer of a script
            found += 1
            continue
        before, after = (json.loads(each.read_text(encoding="utf-8")) for each in (path, other))
        for move in moves(before, after, WITHOUT_SAMPLING if path.stem.startswith(("analytic", "map")) else MONTE_CARLO):
            print(f"{path.stem}: {move.place}: {move.before} -> {move.after} ({move.change:.1e})")  # noqa: T201 - the answer of a script
            found += 1
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
