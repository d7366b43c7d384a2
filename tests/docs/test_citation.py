"""CITATION.cff, by which others cite the project."""

import re

import lostmotion
from tests.docs.pages import ROOT


def test_the_citation_names_the_version_and_the_licence_of_the_package():
    """Who cites the file cites what is installed, under the licence of pyproject.toml."""
    text = (ROOT / "CITATION.cff").read_text("utf-8")
    stated = dict(re.findall(r"^([a-z-]+): (\S.*)$", text, re.MULTILINE))
    project = (ROOT / "pyproject.toml").read_text("utf-8")
    assert stated["version"] == lostmotion.__version__
    assert f'license = "{stated["license"]}"' in project
    assert {"cff-version", "message", "title"} <= stated.keys()
    assert re.search(r"^authors:\n  - name: lostmotion maintainers$", text, re.MULTILINE)
