"""Rules of the source, read from its syntax trees: no questions for kinds of parts, no patterns on
names, short files, nothing unused.
"""

from __future__ import annotations

import ast
import functools
import re
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

import lostmotion

if TYPE_CHECKING:
    from collections.abc import Iterable

SRC = Path(lostmotion.__file__).parent
FILES = {str(path.relative_to(SRC)): path for path in sorted(SRC.rglob("*.py"))}
# Where parts are made, read from files, and listed.
OF_PARTS = ("parts/", "io/", "catalogue/")
# These do not distinguish kinds of parts: any description, any with sources, any that errs.
BASES = {"Part", "Sourced", "ErrorSource"}
# Forms of error terms are no kinds of parts: whatever evaluates terms in a way of its own, as a
# controller does, distinguishes them.
FORMS = {"lostmotion.parts.forms", "lostmotion.parts.play", "lostmotion.parts.load_table"}
# A gearbox or a bearing studied by itself has more to show where it is given by its drawing.
ONE_PART = ("analyses/gearbox/", "analyses/bearing/")
DRAWN = {"is_drawn", "is_drawn_bearing", "is_sliding", "is_gearbox"}
# What users write, by patterns: no names of terms or causes.
PATTERNS = {
    "standards/measured_paths.py": "pairs of pose names",
    "analyses/quantities.py": "quantities with units",
    "analyses/signature.py": "sections of a docstring",
    "propagation/montecarlo/stopping.py": "a precision, '1 %'",
}
# Closed chains are a matter of the mechanism and of its files; elsewhere only what is new to them.
CLOSED = {
    "calibration/geometry.py": "geometric errors of joints that closures move are not estimated",
    "reporting/arm_picture.py": "marks of passive joints and closures",
}

# Each file is read, and each of its nodes visited, by most of the rules.
parsed = functools.cache(ast.parse)
nodes = functools.cache(lambda tree: tuple(ast.walk(tree)))


@pytest.fixture(scope="module", autouse=True)
def forgotten():
    """Free the syntax trees, some hundred megabytes, after the last rule."""
    yield
    parsed.cache_clear()
    nodes.cache_clear()


def kinds_asked(text: str) -> list[str]:
    """Return each question for a kind of part: a class of `lostmotion.parts` in isinstance or
    issubclass, or a function that does the same.
    """
    tree = parsed(text)
    parts = {
        name.asname or name.name
        for node in nodes(tree)
        if isinstance(node, ast.ImportFrom)
        and (node.module or "").startswith("lostmotion.parts")
        and node.module not in FORMS
        for name in node.names
    } - BASES
    for node in tree.body:  # constants made of such classes
        value = getattr(node, "value", None)
        if (
            isinstance(node, ast.Assign | ast.AnnAssign)
            and value is not None
            and _names(value) & parts
        ):
            parts |= {
                name
                for target in (node.targets if isinstance(node, ast.Assign) else [node.target])
                for name in _names(target)
            }
    found = []
    for node in nodes(tree):
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name):
            asked = (
                _names(node.args[1]) & parts
                if node.func.id in {"isinstance", "issubclass"}
                else {node.func.id} & parts & DRAWN
            )
            found += [f"line {node.lineno}: {name}" for name in sorted(asked)]
    return found


def _names(node: ast.AST) -> set[str]:
    return {each.id for each in ast.walk(node) if isinstance(each, ast.Name)}


def test_nothing_asks_which_kind_of_part_it_has():
    """Outside parts and the reading of files, parts are known by their fields and terms; a joint's
    `type` is such a field.
    """
    asked = {
        name: kinds_asked(path.read_text("utf-8"))
        for name, path in FILES.items()
        if not name.startswith(OF_PARTS)
    }
    asked = {
        name: [
            each for each in found if not (name.startswith(ONE_PART) and each.split()[-1] in DRAWN)
        ]
        for name, found in asked.items()
    }
    assert {name: found for name, found in asked.items() if found} == {}


@pytest.mark.parametrize(
    ("text", "count"),
    [
        ("from lostmotion.parts.link import Link\nisinstance(part, Link)", 1),
        ("from lostmotion.parts.joint import RevoluteJoint as R\nisinstance(part, R | int)", 1),
        (
            (
                "from lostmotion.parts.link import Link\nfrom lostmotion.parts.lumped import "
                "Lumped\nKINDS = Link, Lumped\nisinstance(part, KINDS)"
            ),
            1,
        ),
        ("from lostmotion.parts.gearbox.kinds import is_drawn\nis_drawn(part)", 1),
        ("from lostmotion.parts.error_source import ErrorSource\nisinstance(part, ErrorSource)", 0),
        ("from lostmotion.mechanism.arm import Arm\nisinstance(part, Arm)", 0),
    ],
)
def test_a_question_for_a_kind_would_be_found(text, count):
    """By its own name, another name, a constant, or a function that asks it."""
    assert len(kinds_asked(text)) == count


def test_no_name_of_a_term_or_cause_is_read_by_a_pattern():
    """Terms carry cause, parameter and effect as fields; regular expressions read only what users
    write.
    """
    using = {
        name
        for name, path in FILES.items()
        if name.startswith(
            (
                "error_model/",
                "propagation/",
                "accuracy/",
                "comparison/",
                "loads/",
                "maps/",
                "standards/",
                "analyses/",
                "live_view/",
            )
        )
        and "re" in _imported(parsed(path.read_text("utf-8")))
    }
    assert using == set(PATTERNS)


def _imported(tree: ast.AST) -> set[str]:
    return {
        alias.name for node in nodes(tree) if isinstance(node, ast.Import) for alias in node.names
    } | {node.module or "" for node in nodes(tree) if isinstance(node, ast.ImportFrom)}


def test_a_file_is_short_enough_to_read():
    """No file of the source has more than 400 lines; tables are data files, which do not count."""
    lengths = {name: len(path.read_text("utf-8").splitlines()) for name, path in FILES.items()}
    too_long = {name: n for name, n in lengths.items() if n > 400}
    assert too_long == {}


def test_a_question_is_a_folder_of_at_most_four_files():
    """What is computed, its page (a file, or a folder of its sections), its command with the type
    of its result, and one of its own; `__init__.py` apart. Whatever else it needs lies in a room
    below.
    """
    entries: dict[str, set[str]] = {}
    for name in FILES:
        room, *inside = Path(name).parts
        if room == "analyses" and len(inside) > 1 and inside[1] != "__init__.py":
            entries.setdefault(inside[0], set()).add(inside[1])
    assert len(entries) > 15
    too_many = {question: sorted(each) for question, each in entries.items() if len(each) > 4}
    assert too_many == {}


def test_no_two_classes_have_the_same_name():
    """The name of a class states one thing throughout the source."""
    classes = [
        node.name
        for path in FILES.values()
        for node in nodes(parsed(path.read_text("utf-8")))
        if isinstance(node, ast.ClassDef)
    ]
    assert {name for name in classes if classes.count(name) > 1} == set()


# Parameters of more than five classes, each with what it is in all of them.
OF_MANY_CLASSES = {
    "at": "where, whatever has places",
    "each": "one of several, in functions that are mapped over them",
    "error": "an error of the tool, or of the program",
    "figures": "figures, of whatever was studied",
    "gearbox": "a gearbox, however it is described",
}
CONTAINERS = {
    *("Annotated", "Any", "Argument", "Callable", "Collection", "Floats", "Iterable", "Iterator"),
    *("Literal", "Mapping", "NDArray", "Path", "Quantity", "Self", "Sequence"),
}


def classes_by_parameter(trees: Iterable[ast.AST]) -> dict[str, set[str]]:
    """Return the classes that annotate each parameter of public functions, by its name; containers
    apart.
    """
    out: dict[str, set[str]] = {}
    for tree in trees:
        for node in nodes(tree):
            if not isinstance(node, ast.FunctionDef) or node.name.startswith("_"):
                continue
            for each in (*node.args.posonlyargs, *node.args.args, *node.args.kwonlyargs):
                named = set() if each.annotation is None else _names(each.annotation)
                words = {name for name in named - CONTAINERS if name[0].isupper()}
                out.setdefault(each.arg, set()).update(words)
    return out


def test_a_parameter_is_named_by_what_it_is():
    """A name of parameters that stands for more than five classes says nothing of what is meant."""
    one = parsed("def f(found: Cell | None, n: int): ...\ndef g(found: Sequence[Row]): ...")
    assert classes_by_parameter([one]) == {"found": {"Cell", "Row"}, "n": set()}
    classes = classes_by_parameter(parsed(path.read_text("utf-8")) for path in FILES.values())
    many = {name: sorted(each) for name, each in classes.items() if len(each) > 5}
    assert {name: each for name, each in many.items() if name not in OF_MANY_CLASSES} == {}
    assert set(OF_MANY_CLASSES) <= set(many)


# Names that something other than Python's own syntax refers to.
CALLED_BY_NAME = {
    "lostmotion.io.native.read_arm": "io/__init__.py, by the file's ending",
    "lostmotion.io.urdf.read_arm": "io/__init__.py, by the file's ending",
    "lostmotion.cli.app._options": "typer, as the callback",
}


def unused(modules: dict[str, ast.Module]) -> set[str]:
    """Return the functions, classes and constants of modules (by name) to which nothing in them
    refers; annotations in quotes count.
    """
    used: set[str] = set()
    for module, tree in modules.items():
        names = {
            alias.asname or alias.name: f"{node.module}.{alias.name}"
            for node in nodes(tree)
            if isinstance(node, ast.ImportFrom)
            for alias in node.names
        }
        used |= set(names.values())
        for top in tree.body:
            for node in ast.walk(top):
                if (
                    isinstance(node, ast.Name)
                    and isinstance(node.ctx, ast.Load)
                    and node.id != getattr(top, "name", None)
                ):
                    used.add(f"{module}.{node.id}")
                elif (
                    isinstance(node, ast.Attribute)
                    and isinstance(node.value, ast.Name)
                    and node.value.id in names
                ):
                    used.add(f"{names[node.value.id]}.{node.attr}")
                elif (
                    isinstance(node, ast.Constant)
                    and isinstance(node.value, str)
                    and re.fullmatch(r"[\w\[\], |.\"']+", node.value)
                ):
                    used |= {f"{module}.{word}" for word in re.findall(r"\w+", node.value)}
    return {
        f"{module}.{name}"
        for module, tree in modules.items()
        for top in tree.body
        for name in _defined(top)
    } - used


def _defined(node: ast.stmt) -> list[str]:
    if isinstance(node, ast.FunctionDef | ast.ClassDef):
        names = [node.name]
    else:
        targets = (
            node.targets
            if isinstance(node, ast.Assign)
            else [node.target]
            if isinstance(node, ast.AnnAssign)
            else []
        )
        names = [each.id for each in targets if isinstance(each, ast.Name)]
    return [name for name in names if not name.startswith("__")]


def test_the_source_uses_what_it_defines():
    """Every function, class and constant has a user in the source, or is a public name; none is
    there for tests alone.
    """
    modules = {
        ".".join(["lostmotion", *Path(name).with_suffix("").parts]).removesuffix(".__init__"): path
        for name, path in FILES.items()
    }
    trees = {name: parsed(path.read_text("utf-8")) for name, path in modules.items()}
    public = {f"{home}.{name}" for name, home in lostmotion.HOMES.items()}
    assert unused(trees) - public == set(CALLED_BY_NAME)


def test_what_nothing_uses_would_be_found():
    """A function that only calls itself is unused; one that another module imports, and a class
    named in a quoted annotation, are not.
    """
    one = parsed(
        "def alone(n): return alone(n - 1)\ndef shared(): ...\nclass Kind: ...\ndef _own(x: "
        "'list[Kind]'): ...\nLIMIT = _own"
    )
    assert unused({"a": one, "b": parsed("from a import LIMIT, shared")}) == {"a.alone"}


def closed_asked(text: str) -> bool:
    """Return whether a source reads the closures of an arm or of its tree."""
    return any(
        isinstance(node, ast.Attribute) and node.attr in {"closures", "welds"}
        for node in nodes(parsed(text))
    )


def test_only_the_mechanism_and_its_readers_ask_whether_a_chain_is_closed():
    """Whatever reads closures lies in mechanism/ or io/, or shows what is new to closed chains."""
    assert closed_asked("def f(arm):\n    return 1 if arm.closures else 2")
    asked = {
        name
        for name, path in FILES.items()
        if not name.startswith(("mechanism/", "io/")) and closed_asked(path.read_text("utf-8"))
    }
    assert asked == set(CLOSED)
