"""Helpers to write a file and to read what a reader says about it."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from lostmotion.errors import InputError, Problem, legible
from lostmotion.io import read

if TYPE_CHECKING:
    from collections.abc import Callable

EXAMPLES = Path(__file__).parents[2] / "examples"

JOINT = '[[joints]]\nname = "A"\ntype = "revolute"\nlimits = ["-90 deg", "90 deg"]\n'


def mistakes(path: Path, sidecar: Path | None = None) -> list[Problem]:
    """Read a file that cannot be read, and return its mistakes; each states file, found, expected
    and an example.
    """
    with pytest.raises(InputError) as caught:
        read(path, sidecar)
    for problem in caught.value.problems:
        assert problem.file
        assert problem.found
        assert problem.expected
        assert problem.example
        assert legible(str(problem)) in str(caught.value)
        assert max(map(len, str(problem).splitlines())) < 400
    return list(caught.value.problems)


@pytest.fixture
def mistakes_in(tmp_path: Path) -> Callable[..., dict[str, Problem]]:
    """Write a text, read it as an arm, and return its mistakes by key."""

    def read_mistakes(text: str, name: str = "arm.toml") -> dict[str, Problem]:
        path = tmp_path / name
        path.write_text(text, encoding="utf-8")
        return {problem.key: problem for problem in mistakes(path)}

    return read_mistakes
