"""The glossary: terms that users search for, each with a link to a heading that exists."""

import re

import pytest

from tests.docs.pages import ROOT

GLOSSARY = ROOT / "docs" / "glossary.md"
ENTRIES = re.findall(r"^\*\*(.+?)\.\*\* (.+)$", GLOSSARY.read_text("utf-8"), re.MULTILINE)
LINK = re.compile(r"\]\(([^)#]+)(?:#([^)]+))?\)")
SEARCHED = (
    *(
        "lost motion",
        "backlash",
        "play",
        "hysteresis",
        "torsional stiffness",
        "wind-up",
        "ring pin",
        "eccentricity",
        "repeatability RP",
        "accuracy AP",
    ),
    *(
        "ISO 9283",
        "reach",
        "payload",
        "sag",
        "droop",
        "stick-slip",
        "transmission error",
        "TCP",
        "flange",
        "DH parameters",
        "URDF",
        "SRDF",
        "MJCF",
    ),
    *(
        "workspace",
        "compliance",
        "servo stiffness",
        "homing",
        "absolute encoder",
        "calibration",
        "singularity",
        "harmonic drive",
        "backdriving",
    ),
)


def anchors(text):
    """Return the anchors of the headings of a page, as GitHub and the site make them."""
    headings = re.findall(
        r"^#+ (.+)$", re.sub(r"^```.*?^```", "", text, flags=re.MULTILINE | re.DOTALL), re.MULTILINE
    )
    return {re.sub(r"[^\w\- ]", "", each.lower()).strip().replace(" ", "-") for each in headings}


@pytest.mark.parametrize(("term", "text"), ENTRIES, ids=[term for term, _ in ENTRIES])
def test_an_entry_is_short_and_leads_somewhere(term, text):
    """One to three sentences, and a link to a heading that exists."""
    links = LINK.findall(text)
    assert links, term
    assert len(re.findall(r"[.;](?: |$)", text)) <= 5, text
    for page, anchor in links:
        target = GLOSSARY.parent / page
        assert target.exists(), page
        assert not anchor or anchor in anchors(target.read_text("utf-8")), (page, anchor)


def test_the_terms_of_the_field_are_there():
    """Terms that were searched for have an entry, once, in alphabetical order, and the site lists the page."""
    terms = [each.strip().lower() for names, _ in ENTRIES for each in names.split(",")]
    assert [each for each in SEARCHED if each.lower() not in terms] == []
    assert len(terms) == len(set(terms))
    assert [names for names, _ in ENTRIES] == sorted((names for names, _ in ENTRIES), key=str.lower)
    assert "glossary.md" in (ROOT / "mkdocs.yml").read_text("utf-8")


def test_keys_of_the_glossary_are_keys_of_the_arm_file():
    """Every key that an entry names is documented on the page of the arm file or on the page it
    links to.
    """
    pages = "".join(
        path.read_text("utf-8") for path in (ROOT / "docs").rglob("*.md") if path != GLOSSARY
    )
    for term, text in ENTRIES:
        for key in re.findall(r"`([a-z_]+)`", text):
            assert re.search(rf"\b{key}\b", pages), (term, key)
