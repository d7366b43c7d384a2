"""How close the first answer is: predicted repeatability of public robot files, by class of drive,
beside what their makers print.

    python benchmarks/first_answer.py FOLDER [--half 0]

FOLDER holds the robot files that `makers_repeatability.toml` names, none of which is part of this
repository. For each it prints the class of the drives, the predicted RP (ISO cycle) of that class,
the range between the neighbouring classes, the maker's figure, and the ratio of the two.
"""

from __future__ import annotations

import argparse
import tomllib
from pathlib import Path

from lostmotion.accuracy.drive_classes import ClassFigures, first_figures
from lostmotion.io.drive_loads import drive_loads
from lostmotion.io.urdf import arm_of, tree_of
from lostmotion.printed import rounded_length

TABLE = Path(__file__).parent / "makers_repeatability.toml"
FACTOR = 3.0


def rounded_outward(low: float, high: float) -> tuple[float, float]:
    """Return the ends of a range (m) as the headline prints them: one digit, rounded outward."""
    ends = (rounded_length(low, -1.0), rounded_length(high, 1.0))
    low, high = (float(end.split()[0]) * {"mm": 1e-3, "µm": 1e-6}[end.split()[1]] for end in ends)
    return low, high


def main() -> None:
    """Print a line for each robot file, and how many are hit."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("folder", type=Path)
    parser.add_argument("--half", type=int, choices=(0, 1), help="every other robot only")
    parser.add_argument("--names", nargs="*", default=[], help="of robots only")
    asked = parser.parse_args()
    rows = tomllib.loads(TABLE.read_text("utf-8"))["robots"]
    counts = {"files": 0, "in range": 0, "within a factor of 3": 0}
    for number, row in enumerate(rows):
        if (asked.half is not None and number % 2 != asked.half) or (
            asked.names and row["name"] not in asked.names
        ):
            continue
        path = asked.folder / row["file"]
        if not path.exists():
            print(f"{row['name']:24} not in this folder")
            continue
        content = {"tip": row["tip"]} if "tip" in row else {}
        tree = tree_of(path, None, {})
        arm = arm_of(path, None, content)
        found = drive_loads(arm, {name: joint.effort for name, joint in tree.joints.items()})
        figures = first_figures(arm, found.of, found.loads)
        own = next(each for each in figures if each.default).repeatability
        low, high = rounded_outward(*ClassFigures.ends(figures, "repeatability"))
        maker = row["repeatability_mm"] * 1e-3
        hit, near = low - 1e-9 <= maker <= high + 1e-9, max(own / maker, maker / own) <= FACTOR
        counts["files"] += 1
        counts["in range"] += hit
        counts["within a factor of 3"] += near
        print(
            f"{row['name']:24} {found.of.name:18} {max(found.loads.values()):8.3g} N m  RP "
            f"{own * 1e3:7.3g} mm, {low * 1e3:.1g} to {high * 1e3:.1g}"
            f"  maker {row['repeatability_mm']:g} mm  ratio "
            f"{own / maker:5.2f}{'' if hit else '  NOT IN RANGE'}{'' if near else '  FAR'}"
        )
    print(", ".join(f"{name}: {count}" for name, count in counts.items()))


if __name__ == "__main__":
    main()
