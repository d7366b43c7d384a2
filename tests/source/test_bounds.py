"""The lower bounds that the package declares are those that it is tried with."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

ROOT = Path(__file__).parents[2]


def version(text):
    """Read a plain version; zeros at its end count for nothing."""
    parts = [int(part) for part in text.split(".")]
    while parts and not parts[-1]:
        parts.pop()
    return parts


def test_every_lower_bound_is_the_version_that_is_tried():
    """Each dependency's `>=` in pyproject.toml stands as `==` in constraints-lowest.txt, with which
    .ci/run runs the package.
    """
    declared = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"][
        "dependencies"
    ]
    lowest = dict(
        re.findall(
            r"^([A-Za-z0-9_.-]+)==([0-9.]+)",
            (ROOT / "constraints-lowest.txt").read_text(encoding="utf-8").lower(),
            re.MULTILINE,
        )
    )
    bounds = dict(re.fullmatch(r"([a-z0-9_-]+)>=([0-9.]+)", each).groups() for each in declared)
    assert len(bounds) == len(declared)
    assert {name: version(lowest[name]) for name in bounds} == {
        name: version(bound) for name, bound in bounds.items()
    }
    assert "constraints-lowest.txt" in (ROOT / ".ci" / "run").read_text(encoding="utf-8")
