"""A design of a sweep: the arm file with some of its keys changed, read by the ordinary reader, so
that every check is the same.
"""

from __future__ import annotations

import copy
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, TypeAlias

import tomlkit

from lostmotion.errors import InputError, Problem, shown
from lostmotion.io import native, read, urdf
from lostmotion.io.arm_builder import SHARED
from lostmotion.io.arm_builder import SWEEP as TABLE
from lostmotion.io.draft import plain
from lostmotion.io.limits import MOST_MISTAKES, listed, nearest, refuse_all
from lostmotion.io.project_root import KEY as ROOT
from lostmotion.io.provenance import forget_assumed
from lostmotion.io.reducers import KEY as CATALOGUE_KEY
from lostmotion.io.sidecar import find_sidecar, sidecar_place
from lostmotion.io.srdf import find_srdf
from lostmotion.io.sweep import EXAMPLE, Axis, changes, designs, key_text, read_axes
from lostmotion.io.text import beside, read_old_text, read_text
from lostmotion.io.toml import key_step, key_steps, quoted, source_of
from lostmotion.io.toml_lines import names_lines
from lostmotion.io.urdf_xml import parse_robot
from lostmotion.io.xacro_file import TABLE as XACRO

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence

    from lostmotion.mechanism.arm import Arm

_DEEPEST: Final = 12
# An arm's file, or a dictionary with what the TOML would hold.
Stated: TypeAlias = "Path | Mapping[str, Any]"
# What the text of a dictionary is called where it is stored.
OF_DICTIONARY: Final = "arm.toml"
_URDF: Final = ".urdf"
# What a file may name beside itself: tables of reducers, matrices.
_NAMED_ENDINGS: Final = (".toml", ".csv")
# No store takes more than twenty of all files together (`runs.store`).
_MEGABYTES: Final = 20


def read_design(path: Path, sidecar: Path | None, stated: Mapping[str, Any]) -> Arm:
    """Return the arm with these values at these keys. Keys of a URDF's arm are those of its
    sidecar.

    Raises InputError with every mistake, in the reader's words.
    """
    return _arm(path, sidecar, _tree(path, sidecar), stated)


def find_tree(path: Stated, sidecar: Path | None) -> Stated | None:
    """Return the TOML whose keys can be swept: the arm file itself, or a URDF's sidecar. None for a
    URDF without one.
    """
    if isinstance(path, Mapping):
        return path
    return path if path.suffix.lower() == ".toml" else sidecar or find_sidecar(path)


def _tree(path: Stated, sidecar: Path | None) -> dict[str, Any]:
    source = find_tree(path, sidecar)
    tree = {} if source is None else source_of("arm", source)[1]
    tree.pop(TABLE, None)
    return tree


def _arm(
    path: Stated, sidecar: Path | None, tree: dict[str, Any], stated: Mapping[str, Any]
) -> Arm:
    tree = copy.deepcopy(tree)
    file = "arm" if isinstance(path, Mapping) else str(path)
    lost = [
        problem
        for key, value in stated.items()
        if (problem := _place(file, tree, key, copy.deepcopy(value))) is not None
    ]
    if lost:
        refuse_all(lost)
    if isinstance(path, Mapping) or path.suffix.lower() == ".toml":
        return native.arm_of(file, tree)
    return urdf.arm_of(path, sidecar or find_sidecar(path), tree)


def _place(file: str, tree: dict[str, Any], key: str, value: Any) -> Problem | None:  # noqa: ANN401 - whatever a file holds
    """Put a value where a key leads, opening tables on the way; gives what is wrong where it leads
    nowhere.
    """
    steps = key_steps(key)
    here: Any = tree
    for k, step in enumerate(steps[:-1]):
        if k > _DEEPEST:
            return Problem(file, key, f"{len(steps)} steps", f"at most {_DEEPEST}", EXAMPLE)
        inner = _inner(here, step, by_name=k == 1 and steps[0] == "joints")
        if isinstance(inner, str):
            inner = _own(tree, steps[: k + 1], inner)
            if isinstance(inner, dict):
                here[step] = inner
        if inner is None and isinstance(here, dict) and not _names(tree, steps[: k + 1]):
            inner = here[step] = {}
        if not isinstance(inner, dict | list):
            return _leads_nowhere(file, key, tree, steps[: k + 1], here)
        here = inner
    last = steps[-1]
    if isinstance(here, dict):
        forget_assumed(here, last)
        here[last] = value
    elif last.isdecimal() and int(last) < len(here):
        here[int(last)] = value
    else:
        return _leads_nowhere(file, key, tree, steps, here)
    return None


def _inner(here: Any, step: str, *, by_name: bool) -> Any:  # noqa: ANN401 - whatever a file holds
    if isinstance(here, dict):
        return here.get(step)
    if by_name:
        return next(
            (each for each in here if isinstance(each, dict) and each.get("name") == step), None
        )
    return here[int(step)] if step.isdecimal() and int(step) < len(here) else None


def _names(tree: dict[str, Any], steps: list[str]) -> dict[str, Any] | None:
    """Return the names to choose among where a key's second step must be one that exists: a joint,
    or a part that joints share.
    """
    if len(steps) != 2:  # noqa: PLR2004 - the table and the name in it
        return None
    stock = tree.get(steps[0])
    if steps[0] == "joints" and isinstance(stock, list):
        return {
            each["name"]: each
            for each in stock
            if isinstance(each, dict) and isinstance(each.get("name"), str)
        }
    return (stock if isinstance(stock, dict) else {"": None}) if steps[0] in SHARED else None


def _own(tree: dict[str, Any], steps: list[str], name: str) -> Any:  # noqa: ANN401 - whatever a file holds
    """Replace a joint's shared part by a copy of its own; a reducer of the catalogue stays named
    inside it.
    """
    table = next(
        (
            table
            for table, where in SHARED.items()
            if steps[0] == "joints" and tuple(steps[2:]) == where
        ),
        None,
    )
    stock = tree.get(table) if table else None
    if isinstance(stock, dict) and name in stock:
        return copy.deepcopy(stock[name])
    return {CATALOGUE_KEY: name} if table == "gearboxes" else name


def _leads_nowhere(
    file: str,
    key: str,
    tree: dict[str, Any],
    steps: list[str],
    here: Any,  # noqa: ANN401
) -> Problem:
    names = _names(tree, steps)
    if names is not None:
        known = [name for name in names if name]
        near = nearest(steps[1], known)
        expected = (
            f"one of {listed(known, plain)}"
            if known
            else f"a table [{steps[0]}.NAME] in the arm file"
        )
        example = quoted(
            ".".join(
                key_step(step)
                for step in (steps[0], near or (known or ["NAME"])[0], *key_steps(key)[2:])
            )
        )
        return Problem(
            file, key, f"no '{plain(steps[1])}' under {steps[0]}", expected, example, near
        )
    found = here.get(steps[-1]) if isinstance(here, dict) else here
    return Problem(
        file,
        key,
        f"{shown(found)} at '{plain('.'.join(steps))}'",
        "a key that leads from table to table",
        EXAMPLE,
    )


@names_lines
def read_sweep(
    path: Stated,
    sidecar: Path | None = None,
    by: Stated | None = None,
    progress: Callable[[str, int, int], None] | None = None,
    look: Callable[[Arm], None] | None = None,
) -> tuple[Arm, tuple[Axis, ...]]:
    """Return the arm of the first design, and the swept keys with their values. One design where
    nothing is swept.

    The arm file as it stands is read first. Then raises InputError with every mistake in the table
    and in each value by itself, under its key; where those pass, in the combinations. `look` is
    called with the arm of every design, in order.
    """
    arm = read(path, sidecar)
    tree = _tree(path, sidecar)
    axes, mistakes, file = read_axes(find_tree(path, sidecar), by)
    for axis in axes:
        mistakes += (
            [_of_xacro(axis, file, path)]
            if axis.steps[0] == XACRO
            else _of_axis(path, sidecar, tree, axis, file)
        )
    if mistakes:
        refuse_all(list(dict.fromkeys(mistakes)))
    count = designs(axes)
    for design in range(count):
        stated = changes(axes, design)
        try:
            found = _arm(path, sidecar, tree, stated)
        except InputError as error:
            together = ", ".join(f"{key} = {shown(value)}" for key, value in stated.items())
            mistakes += [
                Problem(
                    file,
                    TABLE,
                    f"{together}: {each.key}: {each.found}",
                    each.expected,
                    each.example,
                )
                for each in error.problems
            ]
            if len(mistakes) > MOST_MISTAKES:
                break
            continue
        if len(found.driven) != len(arm.driven):
            mistakes.append(
                Problem(
                    file,
                    TABLE,
                    f"{len(found.driven)} driven joints in design {design}",
                    f"as many as in the others, {len(arm.driven)}",
                )
            )
        arm = found if design == 0 else arm
        if look is not None:
            look(found)
        if progress is not None:
            progress("reading designs", design + 1, count)
    if mistakes:
        refuse_all(mistakes)
    return arm, axes


def _of_xacro(axis: Axis, file: str, path: Stated) -> Problem:
    """Refuse to sweep an argument of xacro: what is stored of a run is one expanded file."""
    found, expected = (
        "an argument of xacro, which a sweep cannot change",
        "a key of another table, or a sidecar for each value and a comparison",
    )
    name = "arm.urdf" if isinstance(path, Mapping) else path.name
    example = f"lostmotion compare {name} {name} --sidecar one.toml --sidecar two.toml"
    return Problem(file, f"{TABLE}.{key_text(axis.key)}", found, expected, example)


def _of_axis(
    path: Stated, sidecar: Path | None, tree: dict[str, Any], axis: Axis, file: str
) -> list[Problem]:
    """Return the values of a key that the arm does not accept. What is wrong with the key itself is
    reported once.
    """
    out: list[Problem] = []
    where = f"{TABLE}.{key_text(axis.key)}"
    for k, value in enumerate(axis.values):
        if len(out) > MOST_MISTAKES:
            break
        try:
            _arm(path, sidecar, tree, {axis.key: value})
        except InputError as error:
            for problem in error.problems:
                found = (
                    problem.found
                    if problem.key.endswith(axis.steps[-1])
                    else f"{problem.found} (at {problem.key})"
                )
                if problem.found.startswith(("an unknown key", "an unknown joint", "no '")):
                    return [
                        Problem(
                            file, where, found, problem.expected, problem.example, problem.nearest
                        )
                    ]
                out.append(
                    Problem(
                        file,
                        f"{where}[{k}]",
                        found,
                        problem.expected,
                        problem.example,
                        problem.nearest,
                    )
                )
    return out


def texts(path: Stated, sidecar: Path | None, axes: Sequence[Axis]) -> dict[str, str]:
    """Return the texts of all files from which this arm, and every design of it, is read. Text by
    name, first the arm; its folder is the root.

    A sidecar is put beside its URDF under its own name; xacro is expanded, and MJCF includes what
    it names. Files that the arm names beside itself, or that the sweep puts there, come along.
    """
    tree = _tree(path, sidecar)
    if isinstance(path, Mapping):
        return {OF_DICTIONARY: tomlkit.dumps(tree), **_named_in("arm", tree, axes)}
    source = path if path.suffix.lower() == ".toml" else sidecar or find_sidecar(path)
    name, text = path.name, _text(path)
    if source != path:
        kind, text = urdf.self_contained(path, text, dict(tree), source)
        name = sidecar_place(path).with_suffix(kind).name
    out = {name: text}
    if (
        name.endswith(_URDF)
        and (srdf := find_srdf(path, parse_robot(text, str(path))[0].get("name", ""))) is not None
    ):
        out[Path(name).with_suffix(srdf.suffix.lower()).name] = _text(srdf)
    if source is not None and source != path:
        out[sidecar_place(path).name] = _without_root(_text(source))
    return out if source is None else {**out, **_named_in(str(source), tree, axes), **out}


def _named_in(file: str, tree: dict[str, Any], axes: Sequence[Axis]) -> dict[str, str]:
    """Return the texts of the files that an arm and its sweep name beside it, by name."""
    out = {}
    for text in _texts_in([tree, *(list(axis.values) for axis in axes)]):
        named = beside(file, text) if Path(text).suffix.lower() in _NAMED_ENDINGS else None
        if named is not None and named.is_file():
            out[Path(text).as_posix()] = _text(named)
    return out


def _without_root(text: str) -> str:
    """Return the text of a sidecar without the folder of its project: what is stored names no file
    any more.
    """
    if ROOT not in tomllib.loads(text):
        return text
    document = tomlkit.parse(text)
    document.pop(ROOT)
    return tomlkit.dumps(document)


def _text(path: Path) -> str:
    """Read a file of the arm, with line ends as they are inside Python."""
    text = (
        read_text(path, _MEGABYTES)
        if path.suffix.lower() in _NAMED_ENDINGS
        else read_old_text(path, _MEGABYTES)[0]
    )
    return text.replace("\r\n", "\n").replace("\r", "\n")


def _texts_in(value: Any) -> Iterator[str]:  # noqa: ANN401 - whatever a file holds
    if isinstance(value, str):
        yield value
    elif isinstance(value, dict | list):
        for each in value.values() if isinstance(value, dict) else value:
            yield from _texts_in(each)
