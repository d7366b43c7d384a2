"""Pages of the site that are made of other files: front page, changelog, contributing, reference,
and the files of the project that pages link to.

`mkdocs build --strict` calls it (`hooks` in mkdocs.yml). So every text stands in one place, where
the repository shows it too.
"""

from __future__ import annotations

import posixpath
import re
import subprocess
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from mkdocs.structure.files import File, InclusionLevel

import lostmotion
from lostmotion.analyses.result import Result
from lostmotion.cli.generator import command_name

if TYPE_CHECKING:
    from mkdocs.config.defaults import MkDocsConfig
    from mkdocs.structure.files import Files
    from mkdocs.structure.pages import Page

ROOT = Path(__file__).parents[1]
DOCS = "docs/"
# Files of the project that are pages of the site.
PAGES = {
    "README.md": "index.md",
    "CHANGELOG.md": "changelog.md",
    "CONTRIBUTING.md": "contributing.md",
    "examples/paper/README.md": "paper.md",
}
# Pages of the reference: title, introduction, and the ends of the homes of the names that they
# describe; the last has the others.
REFERENCE = {
    "functions": (
        "Functions",
        "Every question is a function, and a command with the same arguments.",
        (".command",),
    ),
    "results": (
        "Results",
        "What the functions return: `Result`, which all of them are, and what each has besides.",
        (".result",),
    ),
    "errors": ("Errors", "What can go wrong.", (".errors",)),
    "pieces": ("Pieces", "What the functions are made of, for programs of your own.", ("",)),
}
_LINK = re.compile(r"(\]\()([^)#:\s]+)((?:#[^)\s]*)?\))")


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add the pages that are made here, and the files that they and the others link to."""
    made = {name: (ROOT / source).read_text("utf-8") for source, name in PAGES.items()}
    made["reference/command-line.md"] = _command_line()
    made |= {f"reference/{name}.md": text for name, text in _reference().items()}
    texts = {
        each.src_uri: each.content_string
        for each in files.documentation_pages()
        if each.src_uri.endswith(".md")
    } | made
    for name, text in made.items():
        files.append(File.generated(config, name, content=text))
    for linked in sorted(
        {_source(link[2], name) for name, text in texts.items() for link in _LINK.finditer(text)}
        - {None, *PAGES}
    ):
        place = ROOT / linked
        if linked.startswith(DOCS) or not place.exists():
            continue
        if place.is_dir():
            listed = "\n".join(
                f"- `{each.name}`"
                for each in sorted(place.iterdir())
                if not each.name.startswith((".", "_"))
            )
            text = f"# {linked}\n\nFiles of the project:\n\n{listed}\n"
            generated = File.generated(config, f"project/{linked}/index.md", content=text)
        else:
            generated = File.generated(config, f"project/{linked}", abs_src_path=str(place))
        generated.inclusion = InclusionLevel.NOT_IN_NAV
        files.append(generated)
    return files


def on_page_markdown(markdown: str, page: Page, config: MkDocsConfig, files: Files) -> str:  # noqa: ARG001 - MkDocs passes them by name
    """Point links to files outside of docs to where the site has them."""
    name = page.file.src_uri
    here = posixpath.dirname(name)

    def pointed(link: re.Match[str]) -> str:
        source = _source(link[2], name)
        if source is None:
            return link[0]
        target = PAGES.get(source) or (
            source.removeprefix(DOCS) if source.startswith(DOCS) else f"project/{source}"
        )
        if (ROOT / source).is_dir():
            target += "/index.md"
        return f"{link[1]}{posixpath.relpath(target, here or '.')}{link[3]}"

    return _LINK.sub(pointed, markdown)


def _source(link: str, name: str) -> str | None:
    """Return the file of the project that a link of a page of the site points to; None for a page
    made here, or one that it has already.
    """
    made_of = next((source for source, page in PAGES.items() if page == name), f"{DOCS}{name}")
    source = posixpath.normpath(posixpath.join(posixpath.dirname(made_of), link))
    return source if (ROOT / source).exists() else None


def _command_line() -> str:
    """Return the page of all commands with their options, as the command line describes itself."""
    described = [
        sys.executable,
        "-m",
        "typer",
        "lostmotion.cli.app",
        "utils",
        "docs",
        "--name",
        "lostmotion",
    ]
    text = subprocess.run(described, check=True, capture_output=True, text=True).stdout  # noqa: S603 - this project's own command
    for name in lostmotion.QUESTIONS:
        text = text.replace(f"lostmotion {name}", f"lostmotion {command_name(name)}")
    head, _, commands = text.partition("\n## ")
    return (
        head.partition("**Commands**")[0].replace("# `lostmotion`", "# Command line", 1)
        + "\n## "
        + commands
    )


def _reference() -> dict[str, str]:
    """Return the pages of the public names."""
    left = dict(lostmotion.HOMES)
    out = {}
    for page, (title, about, ends) in REFERENCE.items():
        names = {name: left.pop(name) for name, home in [*left.items()] if home.endswith(ends)}
        described = [f"::: {home}.{name}\n{_members(name)}" for name, home in names.items()]
        if page == "results":
            described.insert(0, f"::: {Result.__module__}.Result\n")
        out[page] = f"# {title}\n\n{about}\n\n" + "\n".join(described)
    return out


def _members(name: str) -> str:
    """Return the option that lists the members of a result, those of the classes that it extends
    included; what every result has is described once, for `Result`.
    """
    kind = getattr(lostmotion, name)
    if not (isinstance(kind, type) and issubclass(kind, Result)):
        return ""
    bases = [base for base in kind.__mro__ if not issubclass(Result, base)]
    members = sorted({each for base in bases for each in vars(base)} - {*dir(Result)})
    own = [each for each in members if not each.startswith("_")]
    return f"    options: {{members: {own}, inherited_members: {own}}}\n"
