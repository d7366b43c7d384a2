"""Every snippet of the README and of the tour is read, parsed or executed."""

from __future__ import annotations

import re
import shlex
import tomllib
from typing import TYPE_CHECKING

import pytest
import tomlkit
import typer.main

import lostmotion
from lostmotion.cli import app
from lostmotion.io.calibration_file import read_calibration
from lostmotion.io.sizing import read_request
from lostmotion.io.sweep_designs import read_sweep
from lostmotion.io.task_file import read_task
from lostmotion.propagation import factor_metrics
from tests.docs.pages import PAGES, ROOT, TOUR, snippets

if TYPE_CHECKING:
    from pathlib import Path

EXAMPLES = ROOT / "examples"
SHARED = ("gearboxes", "bearings", "encoders", "sections", "materials", "reducers")
# What is asked of fewer poses and robots than a page prints: the answers have tests of their own.
FEWER = {
    "robots=1000, visits=30": "poses=64, robots=24, visits=3",
    "poses=1024,": "poses=256,",
    "poses=128, robots=100": "poses=32, robots=24, visits=3",
    "128, robots=200, visits=5": "32, robots=40, visits=3",
    "robots=200, visits=30": "robots=24, visits=3",
}
JOINT = {"name": "only", "type": "revolute", "limits": ["-90 deg", "90 deg"]}


def _blocks(language):
    return [
        pytest.param(block, id=str(block)) for page in TOUR for block in snippets(page, language)
    ]


def _arm_of(block):
    """Return a block as a whole arm file: a name and a joint where it has none, and the shared
    parts of the page's other blocks.
    """
    tree = tomllib.loads(block.text)
    for other in snippets(block.page, "toml"):
        for table, parts in tomllib.loads(other.text).items():
            if table in SHARED and table != "reducers":
                tree[table] = {**parts, **tree.get(table, {})}
    return {"name": "arm", "joints": [JOINT], **tree}


@pytest.mark.parametrize("block", _blocks("toml"))
def test_every_toml_snippet_is_accepted(block, tmp_path):
    """An arm, a sidecar, a sizing file, a calibration or a sweep: each is read without a mistake,
    and each value has its unit.
    """
    tree = tomllib.loads(block.text)
    file = tmp_path / "snippet.toml"
    if "sizing" in tree:
        file.write_text(block.text, "utf-8")
        assert read_request(file, {}, lostmotion.read(EXAMPLES / "z-arm.toml")).plan is not None
    elif isinstance(tree.get("joints"), dict) or "xacro" in tree:
        file.write_text(block.text, "utf-8")
        assert lostmotion.read(EXAMPLES / "ur5e.urdf", file).joints
    elif "tolerances" in tree:
        file.write_text(block.text, "utf-8")
        assert read_task(file, lostmotion.read(EXAMPLES / "six-axis.toml")).tolerances
    elif "estimates" in tree:
        file.write_text(block.text, "utf-8")
        other = "calibration/ur5.toml" if "joints.J2." in block.text else "z-arm.toml"
        found = read_calibration(file, lostmotion.read(EXAMPLES / other))
        assert len(found.streams) == len(tree["estimates"])
    elif "sweep" in tree and "gearboxes.cycloidal.backlash" in tree["sweep"]:
        file.write_text(block.text, "utf-8")
        assert len(read_sweep(EXAMPLES / "z-arm.toml", None, file)[1]) == len(tree["sweep"])
    else:
        file.write_text(tomlkit.dumps(_arm_of(block)), "utf-8")
        assert lostmotion.read(file).joints


@pytest.mark.parametrize("block", _blocks("sh"))
def test_every_command_line_is_one_that_the_command_takes(block):
    """Each line names a command with options that it has, and files of the examples that exist."""
    group = typer.main.get_command(app)
    for text in block.text.splitlines():
        command = text.partition("#")[0].split("&&")[-1].strip()
        if not command.startswith("lostmotion "):
            assert command.startswith("pip install ") or command == "pytest", command
            continue
        name, found, words = group.resolve_command(None, shlex.split(command)[1:])
        found.make_context(name, words)
        for word in words:
            assert not word.startswith("examples/") or (ROOT / word).exists(), word


@pytest.mark.parametrize("page", TOUR, ids=lambda page: page.name)
def test_every_command_of_a_table_is_one_that_the_command_takes(page):
    """Commands within sentences and tables parse as those in blocks do."""
    group = typer.main.get_command(app)
    for command in re.findall(r"`lostmotion (\w+(?: [^`]+)?)`", page.read_text("utf-8")):
        name, found, words = group.resolve_command(None, shlex.split(command))
        if words and not words[0].isupper() and "--help" not in words:
            found.make_context(name, words)


@pytest.mark.slow
@pytest.mark.few_counts
@pytest.mark.usefixtures("unpainted")
@pytest.mark.parametrize(
    "page", [page for page in TOUR if snippets(page, "python")], ids=lambda page: page.name
)
def test_the_python_of_a_page_runs_from_top_to_bottom(page, tmp_path, monkeypatch):
    """A reader who types a page's snippets one after the other gets no error."""
    # those with which a target is solved, of which no snippet states the number
    monkeypatch.setattr(factor_metrics, "_SAMPLES", 1 << 13)
    (tmp_path / "examples").symlink_to(EXAMPLES)
    monkeypatch.chdir(tmp_path)
    names = {}
    for block in snippets(page, "python"):
        text = block.text
        for printed, fewer in FEWER.items():
            text = text.replace(printed, fewer)
        exec(compile(text, str(block), "exec"), names)  # noqa: S102 - our own pages


def test_each_smaller_number_stands_on_one_page():
    """No page has lost what is asked of fewer poses and robots."""
    text = "".join(block.text for page in TOUR for block in snippets(page, "python"))
    assert {printed: text.count(printed) for printed in FEWER} == dict.fromkeys(FEWER, 1)


def test_every_option_of_the_tour_exists():
    """An option that the tour names is one of some command."""
    group = typer.main.get_command(app)
    commands = [group.get_command(None, name) for name in lostmotion.QUESTIONS]
    known = {
        option for command in commands for parameter in command.params for option in parameter.opts
    }
    known |= {"--help"}
    for page in TOUR:
        for option in re.findall(r"`(--[a-z0-9-]+)", page.read_text("utf-8")):
            assert option in known, f"{page.name}: {option}"


def test_every_link_leads_to_a_page_and_a_heading():
    """No link of a page is broken, whether to a file, a folder or a heading."""
    for page in (
        *TOUR,
        *sorted((ROOT / "docs" / "theory").glob("*.md")),
        ROOT / "docs" / "conventions.md",
        ROOT / "docs" / "extending.md",
    ):
        for target in re.findall(r"\]\(([^)\s]+)\)", page.read_text("utf-8")):
            if target.startswith("http"):
                continue
            name, _, anchor = target.partition("#")
            path = (page.parent / name).resolve() if name else page
            assert path.exists(), f"{page.name}: {target}"
            if anchor:
                assert anchor in _anchors(path), f"{page.name}: {target}"


def test_every_file_that_a_page_names_is_there():
    """Modules, tests and examples move; the pages that point to them follow."""
    for page in PAGES:
        for name in re.findall(
            r"`((?:[a-z_0-9]+/)+[a-z_0-9-]+\.(?:py|toml|csv|urdf))`", page.read_text("utf-8")
        ):
            assert any(
                (folder / name).exists()
                for folder in (ROOT, ROOT / "src" / "lostmotion", ROOT / "examples")
            ), f"{page.name}: {name}"


def _anchors(page: Path) -> set[str]:
    headings = re.findall(r"^#+ (.+)$", page.read_text("utf-8"), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}
