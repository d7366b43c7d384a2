"""The tests to run for changed files are found along imports, and by names of files."""

from __future__ import annotations

import re
from pathlib import Path

import grimp
import pytest

from tests.affected import ROOT, TESTS, affected, import_graph, main, nearest_tests, public_names

PACKAGE = ROOT / "src" / "lostmotion"


@pytest.fixture(scope="module")
def graph():
    """Imports of the package and of its tests."""
    return import_graph()


def test_every_file_of_the_package_has_tests_to_run(graph):
    """Whatever was changed in the package, a test reaches it, but for what starts the command
    line.
    """
    without = {
        path.relative_to(PACKAGE)
        for path in PACKAGE.rglob("*.py")
        if path.name != "__init__.py" and not affected([path], graph)
    }
    assert without == {Path("__main__.py")}


def test_a_changed_law_runs_its_own_tests_and_those_that_import_it(graph):
    """The nearest tests are those that name the module in an import."""
    law = PACKAGE / "laws" / "perforated_disc.py"
    found = affected([law], graph)
    imported = re.compile("^from lostmotion.laws.perforated_disc import", re.MULTILINE)
    direct = [test for test in TESTS if imported.search(test.read_text("utf-8"))]
    assert direct
    assert {*direct} <= {*found}
    assert len(found) < len(TESTS) / 4


def test_steps_of_imports_lead_to_the_nearest_tests_only():
    """A test two steps away is found where none is nearer, and is not where one is."""
    graph = grimp.ImportGraph()
    steps = {
        "lostmotion.a": "lostmotion.inner",
        "lostmotion.b": "lostmotion.a",
        "tests.source.test_affected": "lostmotion.a",
        "tests.source.test_imports": "lostmotion.b",
    }
    for importer, imported in steps.items():
        graph.add_import(importer=importer, imported=imported)
    assert nearest_tests("lostmotion.inner", graph) == {Path(__file__)}
    assert nearest_tests("lostmotion.b", graph) != {Path(__file__)}


def test_names_that_are_loaded_when_used_count_as_imports(graph):
    """`lostmotion.sample_poses` is an import of its home, which no import statement names."""
    assert public_names("import lostmotion\nlostmotion.study(lostmotion.nothing)") == {"study"}
    importers = graph.find_modules_that_directly_import("lostmotion.analyses.accuracy.command")
    assert "lostmotion.cli.app" in importers
    assert any(each.startswith("tests.") for each in importers)


def test_other_files_are_found_by_their_names(graph, tmp_path):
    """A page runs the tests that name it, a test runs itself, and an unknown file runs nothing."""
    page = ROOT / "docs" / "validation.md"
    assert ROOT / "tests" / "docs" / "test_validation.py" in affected([page], graph)
    assert affected([Path(__file__)], graph) == [Path(__file__)]
    assert affected([tmp_path / f"{tmp_path.name}.md"], graph) == []


def test_the_command_prints_paths_for_pytest(capsys, tmp_path):
    """One path per line from the root of the project; exit 1 where there is no test, so that
    pytest does not run all of them.
    """
    assert main([str(Path(__file__))]) == 0
    printed = capsys.readouterr().out.splitlines()
    assert [ROOT / each for each in printed] == [Path(__file__)]
    assert main([str(tmp_path / f"{tmp_path.name}.md")]) == 1
    assert "No test file" in capsys.readouterr().err
