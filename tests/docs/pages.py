"""The pages that users read, and the snippets in them."""

from __future__ import annotations

import re
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).parents[2]
TOUR = (
    ROOT / "README.md",
    ROOT / "docs" / "tour.md",
    ROOT / "docs" / "how-to.md",
    *sorted((ROOT / "docs" / "tour").glob("*.md")),
)
PAGES = (
    *TOUR,
    ROOT / "CHANGELOG.md",
    ROOT / "CONTRIBUTING.md",
    *sorted(path for path in (ROOT / "docs").rglob("*.md") if path not in TOUR),
)
_BLOCK = re.compile(r"^```(\w*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)


class Snippet(NamedTuple):
    """One fenced block of a page."""

    page: Path
    line: int
    language: str
    text: str

    def __str__(self) -> str:
        """Return the place of the block, as the name of a test."""
        return f"{self.page.name}:{self.line}"


def snippets(page: Path, language: str) -> list[Snippet]:
    """Return the blocks of a page in a language, in their order."""
    text = page.read_text("utf-8")
    blocks = [
        Snippet(page, text.count("\n", 0, found.start()) + 1, found[1], found[2])
        for found in _BLOCK.finditer(text)
    ]
    return [block for block in blocks if block.language == language]
