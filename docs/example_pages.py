"""A page of the site for each example arm: its picture, the comment at the head of its file, and
the file.

`mkdocs build --strict` calls it (`hooks` in mkdocs.yml) before `site_pages`, which knows these
pages by their names alone.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING

from mkdocs.structure.files import File, InclusionLevel

import lostmotion

if TYPE_CHECKING:
    from mkdocs.config.defaults import MkDocsConfig
    from mkdocs.structure.files import Files
    from mkdocs.structure.pages import Page

EXAMPLES = Path(__file__).parents[1] / "examples"
LISTED = "tour/examples.md"
_LINK = re.compile(r"\]\(\.\./\.\./examples/((?:[\w-]+/)?)([\w-]+)\.(toml|urdf)\)")


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add the page and the picture of each arm that the list of examples links to."""
    listed = files.get_file_from_path(LISTED)
    for folder, stem, suffix in _LINK.findall(listed.content_string):
        source = EXAMPLES / folder / f"{stem}.{suffix}"
        found = lostmotion.check(source)
        files.append(File.generated(config, f"tour/arms/{stem}.svg", content=found.picture))
        text = (
            f"# {found.arm.name}\n\n![The arm from the side, from the front and from "
            f"above]({stem}.svg)\n\n{_story(source)}\n"
        )
        for file in sorted(source.parent.glob(f"{stem}.*"), key=lambda path: path != source):
            text += (
                f"\n## {file.name}\n\n```{'xml' if file.suffix == '.urdf' else 'toml'}\n"
                f"{file.read_text('utf-8')}```\n"
            )
        files.append(
            File.generated(
                config, f"tour/arms/{stem}.md", content=text, inclusion=InclusionLevel.NOT_IN_NAV
            )
        )
    return files


def on_page_markdown(markdown: str, page: Page, config: MkDocsConfig, files: Files) -> str:  # noqa: ARG001 - MkDocs passes them by name
    """Point the links of the list of examples to their pages."""
    return _LINK.sub(r"](arms/\2.md)", markdown) if page.file.src_uri == LISTED else markdown


def _story(file: Path) -> str:
    """Return the comment at the head of a file as Markdown: its indented lines, among them the
    command, are code there too.
    """
    text = file.read_text("utf-8")
    if file.suffix == ".urdf":
        return re.sub("(?m)^  (?! )", "", text.partition("<!--\n")[2].partition("-->")[0])
    lines = text.splitlines()
    end = next(k for k, line in enumerate(lines) if not line.startswith("#"))
    return "\n".join(line.removeprefix("#").removeprefix(" ") for line in lines[:end])
