"""The language is the trade's: expressions to avoid occur in no text, and a search for a common
term finds its explanation.
"""

import ast
import io
import re
import tokenize
from pathlib import Path

import pytest

from tests.docs.pages import PAGES, ROOT

# What to avoid, with what to write instead. Every expression begins at the edge of a word.
AVOID = {
    r"\btold\b|\btells?\b|\btelling\b": "reported, stated, specified",
    r"\bsaid\b": "stated",
    r"\bhow sure\b|\bas sure\b|\bsurer\b|\bsure to\b|\bless sure\b|\bthat sure\b": "precise, uncertainty, confidence interval",
    r"\bdearest\b|\bwho is to blame\b|\bwho to blame\b": "largest contributor, error budget",
    r"\bgives? way\b|\bgave way\b|\bgiving way\b|\bthe give\b|\bplay and give\b|\bor give\b": "deflects, compliance",
    r"\b(?:radial|axial|own|inboard|outboard) give\b|\band give\b|\b(?<=\")give\"": "deflection, return",
    r"\bafresh\b": "recomputed, validated on new samples",
    r"\bc[oa]mes? about\b|\bcome by\b": "derivation, how computed",
    r"\b(?:hold|keep|kept|keeps|holds|held)\b(?: \w+){0,2} targets?\b": "meet",
    r"\bas built\b|\b(?:gearboxes|bearings|robots) built\b|\bbuilt ones\b": "manufactured samples, simulated gearboxes",
    r"\bto and fro\b": "hysteresis, loading and unloading",
    r"\bwarmth\b|\bwarmer\b": "temperature rise",
    r"\balike\b": "uniform, shared, equal",
    r"\bonce more\b|\bmay come again\b": "again, repeat, repeatable",
    r"\bleav(?:e|es|ing) out\b|\bleft out\b": "neglected, excluded, omitted",
    r"\bwaves?\b|\bwaviness\b": "harmonic",
    r"\bplay crossed\b": "backlash traversed",
    r"\bhardest pressed\b": "most heavily loaded",
    r"\bwork (?:should|is to) stand\b": "best placement for a task",
    r"\bamounts\b": "quantities",
    r"\bverbs?\b": "function, command",
    r"\blooked at\b": "evaluated, analysed",
    r"\banew\b": "again, new",
    r"\bmade[ -]up\b": "synthetic",
    r"\bpart by part\b.{0,30}\btogether\b": "each part by itself",
}
# All of them at once: behind one edge of a word they are searched for ten times as fast.
ANY = re.compile(
    r"\b(?:{})".format("|".join(words.removeprefix(r"\b").replace(r"|\b", "|") for words in AVOID))
)
# Senses of these words that the trade uses.
ALLOWED = (
    r"strain[ -]wave|wave[ _]generator|wavelength|wavy rim|waves or thinner rings|\"waves\"|--terms waves",
)
FOLDERS = ("examples", "src/lostmotion")
SUFFIXES = {".py", ".toml", ".md", ".urdf"}
SOURCES = sorted(
    path for folder in FOLDERS for path in (ROOT / folder).rglob("*") if path.suffix in SUFFIXES
)

# This test itself is full of the words to avoid.
TESTS = sorted(path for path in (ROOT / "tests").rglob("*.py") if path != Path(__file__))


def unwanted(text):
    """Return the expressions to avoid in a text, each with its line and what to write instead."""
    if not ANY.search(text.lower()):
        return []
    for allowed in ALLOWED:
        text = re.sub(allowed, lambda found: "_" * len(found[0]), text, flags=re.IGNORECASE)
    hits = [
        (found.start(), found[0], instead)
        for words, instead in AVOID.items()
        for found in re.finditer(words, text, re.IGNORECASE)
    ]
    return [
        f"line {text.count(chr(10), 0, at) + 1}: '{words}'; write {instead}"
        for at, words, instead in sorted(hits)
    ]


def test_a_text_is_written_in_the_terms_of_the_trade():
    """A reader can search for every term in a textbook."""
    found = {path: unwanted(path.read_text("utf-8")) for path in (*PAGES, *SOURCES)}
    assert {str(path.relative_to(ROOT)): hits for path, hits in found.items() if hits} == {}


@pytest.mark.parametrize(
    ("text", "count"),
    [
        ("what is not told then is told by points", 2),
        ("A strain wave gear has no backlash.", 0),
        ("the wave of a mesh, looked at afresh", 3),
        ("the 95th percentile of the error", 0),
        ('Told of an "and give" and of a "give", ONCE MORE', 4),
    ],
)
def test_the_search_for_unwanted_words_finds_them(text, count):
    """The test of the texts is itself able to fail, and does not object to the trade's own
    words.
    """
    assert len(unwanted(text)) == count


@pytest.mark.parametrize("words", AVOID)
def test_every_expression_begins_at_the_edge_of_a_word(words):
    """So that the search for all of them at once finds what the search for each finds."""
    without_groups = re.sub(r"\([^()]*\)", "", words)
    assert all(each.startswith(r"\b") for each in without_groups.split("|"))


def statements(source):
    """Yield the module of a source and its statements, at any depth: classes and functions are
    among them, and none within an expression.
    """
    inside = [ast.parse(source)]
    while inside:
        node = inside.pop()
        yield node
        for blocks in ("body", "orelse", "finalbody", "handlers", "cases"):
            inside += getattr(node, blocks, ())


def test_classes_and_functions_are_found_at_any_depth():
    """In branches, loops, handlers and cases, and within one another."""
    source = """
class A:
    async def b():
        if 0:
            def c(): ...
        else:
            def d(): ...
        for _ in ():
            try:
                def e(): ...
            except OSError:
                def f(): ...
            finally:
                def g(): ...
        with h:
            match 0:
                case 1:
                    def i(): ...
"""
    found = {getattr(node, "name", None) for node in statements(source)} - {None}
    assert found == {*"Abcdefgi"}
    every = ast.walk(ast.parse(source))
    assert sum(isinstance(node, ast.stmt) for node in every) == sum(
        isinstance(node, ast.stmt) for node in statements(source)
    )


def words_of(path):
    """Return the names of a test's file and functions, its docstrings and comments, by where they
    are.
    """
    source = path.read_text("utf-8")
    texts = {f"name of {path.name}": path.stem.replace("_", " ")}
    for node in statements(source):
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef):
            name, line = getattr(node, "name", path.stem), getattr(node, "lineno", 1)
            texts |= {
                f"line {line}, name": name.replace("_", " "),
                f"line {line}, docstring": ast.get_docstring(node) or "",
            }
    comments = (
        token
        for token in tokenize.generate_tokens(io.StringIO(source).readline)
        if token.type == tokenize.COMMENT
    )
    return texts | {f"line {token.start[0]}, comment": token.string for token in comments}


def test_a_test_is_named_and_described_in_the_terms_of_the_trade():
    """Names of files and functions, docstrings and comments of tests follow the same rule; data and
    messages in them may contain anything.
    """
    found = {
        f"{path.relative_to(ROOT)}, {place}": unwanted(text)
        for path in TESTS
        for place, text in words_of(path).items()
    }
    assert {place: hits for place, hits in found.items() if hits} == {}


def opens_badly(docstring):
    """Return whether documentation opens with a question, or with a word that is no statement."""
    opening = docstring.partition("\n\n")[0]
    return "?" in opening or opening.partition(" ")[0] in {"Give", "Gives", "Tell", "Say"}


def test_a_docstring_states_what_a_function_returns_or_does():
    """Documentation opens with a statement, "Return the ...", "Write ...", and asks no question."""
    assert opens_badly("Give the sum.")
    assert opens_badly("How large\nis it?")
    assert not opens_badly("Return the sum.\n\nIs it large?")
    documented = ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef
    found = [
        f"{path.relative_to(ROOT)}, line {getattr(node, 'lineno', 1)}"
        for path in SOURCES
        if path.suffix == ".py"
        for node in statements(path.read_text("utf-8"))
        if isinstance(node, documented) and opens_badly(ast.get_docstring(node) or "")
    ]
    assert found == []


# A search term, the page and the heading that must explain it, and a word of the explanation.
EXPLAINED = [
    ("backlash side", "docs/conventions.md", "Backlash and friction", "last motion"),
    ("hysteresis", "docs/conventions.md", "Backlash and friction", "loop"),
    ("hysteresis", "docs/tour/arm-file.md", "`[gearboxes.NAME]`", "width of the friction loop"),
    ("standard deviation", "docs/conventions.md", "Statistics", "all robots, poses and visits"),
    ("standard deviation", "docs/theory/accuracy.md", "Mean vector and covariance", "mean square"),
    ("confidence interval", "docs/conventions.md", "Statistics", "95 %"),
    (
        "confidence",
        "docs/theory/accuracy.md",
        "Confidence intervals",
        "Student|Searle|Satterthwaite",
    ),
    ("largest contributor", "docs/conventions.md", "Statistics", "share"),
    ("percentile", "docs/conventions.md", "Statistics", "histogram"),
    (
        "harmonic",
        "docs/theory/gearboxes.md",
        "Harmonics of the transmission error",
        "cycles per turn",
    ),
    ("compliance", "docs/theory/statics.md", "Compliance", "wrench"),
    ("tolerance", "docs/conventions.md", "Tolerances", "three standard deviations"),
    ("tolerance", "docs/tour/arm-file.md", "Tolerances", "uniform"),
]


def _sections(path):
    """Return the text of each section of a page, by its heading."""
    text = (ROOT / path).read_text("utf-8")
    parts = re.split(r"^#+ (.+)$", text, flags=re.MULTILINE)
    return dict(zip(parts[1::2], parts[2::2], strict=True))


@pytest.mark.parametrize(
    ("term", "page", "heading", "word"),
    EXPLAINED,
    ids=lambda value: value if " " not in value else None,
)
def test_a_search_for_a_common_term_finds_its_explanation(term, page, heading, word):
    """The section that explains a term has it in its heading or in its text, beside the word that
    matters.
    """
    text = _sections(page)[heading]
    assert re.search(term, f"{heading}\n{text}", re.IGNORECASE)
    assert re.search(word, text)
