"""The table of validation: it lists what the tests state, and every law is compared with
something.
"""

from tests.docs.pages import ROOT
from tests.docs.validation import PAGE, SOURCE, comparisons, page

# Modules that compute no figure.
WITHOUT_FIGURES = {
    "laws/cycloid/finite_elements/raster.py",
    "laws/cycloid/kept.py",
    "propagation/montecarlo/memory.py",
}


def test_the_page_is_what_the_tests_state():
    """The committed page is the one made of the tests: `python -m tests.docs.validation >
    docs/validation.md`.
    """
    assert PAGE.read_text("utf-8") == page()


def test_every_law_and_every_propagation_is_compared_with_something():
    """Each module of the laws and of the propagation is named by a comparison with something that
    does not use it.
    """
    modules = {
        str(path.relative_to(SOURCE))
        for folder in ("laws", "propagation")
        for path in (SOURCE / folder).rglob("*.py")
    }
    named = {name for each in comparisons() for name in each.sources}
    assert {name for name in modules if not name.endswith("__init__.py")} - named == WITHOUT_FIGURES


def test_a_comparison_names_files_that_exist_and_says_how_close_it_is():
    """No comparison is without a reference and an agreement, and none names a file that has
    moved.
    """
    for each in comparisons():
        assert each.quantity, each.tests
        assert each.against, each.quantity
        assert each.within, each.quantity
        for name in (*(f"src/lostmotion/{source}" for source in each.sources), *each.tests):
            assert (ROOT / name).is_file(), name
