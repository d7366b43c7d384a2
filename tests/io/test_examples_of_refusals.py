"""What a refusal shows as an example is accepted when it is pasted where the mistake was.

Files of the project are spoiled key by key: a value of another kind, an empty table or list, no
value at all, a name that is unknown. Each example is put in place of the mistake, and the file read
again: nothing is wrong there any more.
"""

from __future__ import annotations

import copy
import itertools
import re
import tomllib
from pathlib import Path

import pytest

import lostmotion
from lostmotion.errors import InputError
from lostmotion.io.task_file import read_task

EXAMPLES = Path(__file__).parents[2] / "examples"
WRONG = (True, -7.5, "wrong", "-1 mm", [], {}, ["wrong"], {"wrong": 1}, None)


def paths(tree, path=()):
    """Yield the path of each table, list and value of a file."""
    steps = (
        tree.items()
        if isinstance(tree, dict)
        else enumerate(tree)
        if isinstance(tree, list)
        else ()
    )
    for step, below in steps:
        yield (*path, step)
        yield from paths(below, (*path, step))


def spoiled(tree):
    """Yield the file with one key after the other spoiled in each way."""
    for path in list(paths(tree)):
        for value in WRONG:
            out = copy.deepcopy(tree)
            inside = at(out, path[:-1])
            if value is not None:
                inside[path[-1]] = value
            elif isinstance(inside, dict):
                del inside[path[-1]]
            else:
                continue
            yield path, value, out
        if isinstance(path[-1], str):
            out = copy.deepcopy(tree)
            inside = at(out, path[:-1])
            inside[f"{path[-1]}x"] = inside.pop(path[-1])
            yield path, "x", out


def at(tree, path):
    """Return what is at a path."""
    for step in path:
        tree = tree[step]
    return tree


def steps_of(key, tree):
    """Return the path of a key as messages spell it: joints and features by name or number; None
    where it leads nowhere.
    """
    out = []
    for step in re.findall(r'"(?:[^"\\]|\\.)*"|[^.\[\]]+|\[\d+\]', key):
        here = at(tree, out) if all_there(tree, out) else None
        if step.startswith("["):
            out.append(int(step[1:-1]))
        elif isinstance(here, list):
            named = [
                k
                for k, each in enumerate(here)
                if isinstance(each, dict) and each.get("name") == step.strip('"')
            ]
            if not named:
                return None
            out.append(named[0])
        else:
            out.append(step.strip('"'))
    return tuple(out)


def all_there(tree, path):
    """Return whether a path leads somewhere."""
    try:
        at(tree, path)
    except (KeyError, IndexError, TypeError):
        return False
    return True


def stated_by(example, last):
    """Return the keys of an example, and the header that it names; None where it is no TOML.

    It is an assignment, several with commas between, a value alone, or "[header] with" any of them.
    """
    header, _, rest = example.rpartition("] with ")
    for text in (rest, f"x = {{ {rest} }}"):
        try:
            found = tomllib.loads(text)
            return found.get("x", found) if text is not rest else found, header.strip("[")
        except tomllib.TOMLDecodeError:
            continue
    try:
        return {last: tomllib.loads(f"x = {rest}")["x"]}, header.strip("[")
    except tomllib.TOMLDecodeError:
        return None


def pasted(problem, tree):
    """Return the files with the example in place of the mistake, or in the table that is mistaken;
    none where it is no TOML, or where the mistake has no place in the file.
    """
    path = steps_of(problem.key, tree)
    if path is None or not path or not all_there(tree, path[:-1]):
        return []
    given = stated_by(problem.example, path[-1])
    if given is None:
        return []
    stated, header = given
    if header:
        return under_header(tree, path, problem.example, stated, header)
    out, last, found = copy.deepcopy(tree), path[-1], []
    inside = at(out, path[:-1])
    if isinstance(inside, list) and isinstance(last, int) and last < len(inside):
        value = stated.get(last, next(iter(stated.values())) if len(stated) == 1 else None)
        inside[last] = value if value is not None else {**inside[last], **stated}
        found.append(out)
    elif isinstance(inside, dict):
        if last not in stated:
            inside.pop(last, None)
        inside |= stated
        found.append(out)
    if last not in stated and all_there(tree, path) and isinstance(at(tree, path), dict):
        out = copy.deepcopy(tree)
        at(out, path).update(stated)
        found.append(out)
    return found


def under_header(tree, path, example, stated, header):
    """Return the file with the keys of an example under its header, and without the mistake."""
    out = copy.deepcopy(tree)
    at(out, path[:-1]).pop(path[-1], None)
    *outer, last = header.strip("[]").split(".")
    inside = out
    for step in outer:
        inside = inside.setdefault(step, {})
    inside[last] = [stated] if example.startswith("[[") else stated
    return [out]


def mistakes_of(read, tree):
    """Return the mistakes that are found in a file."""
    try:
        read(copy.deepcopy(tree))
    except InputError as error:
        return error.problems
    return ()


def remains(problem, others, tree, read):
    """Return the mistake that remains where an example was pasted; None without one, or where it
    cannot be pasted. The `others` of the file may remain.
    """
    left = None
    others = {each.key for each in others} - {problem.key}
    for again in pasted(problem, tree):
        step = problem.key.rpartition(".")[0]
        given = re.match(r'([\w"]+) = ', problem.example)
        keys = [problem.key, *([f"{step}.{given[1]}" if step else given[1]] if given else [])]
        found = [
            each
            for each in mistakes_of(read, again)
            if each.key not in others
            and any(each.key == key or each.key.startswith((f"{key}.", f"{key}[")) for key in keys)
        ]
        if not found:
            return None
        left = found[0]
    return left


def mistaken_examples(read, tree, every, first):
    """Return how many examples were pasted, and those that are no sound input, of every so manieth
    spoiled file from the first.
    """
    count, wrong = 0, []
    for path, value, out in itertools.islice(spoiled(tree), first, None, every):
        problems = mistakes_of(read, out)
        for problem in problems:
            if problem.example and pasted(problem, out):
                count += 1
                left = remains(problem, problems, out, read)
                if left is not None:
                    wrong.append(f"{path} = {value!r}\n{problem}\nleaves\n{left}")
    return count, wrong


@pytest.mark.parametrize("name", ["circle", "hole-pattern", "peg-in-hole", "seam", "warm-up"])
def test_examples_in_refusals_of_tasks_are_sound_tasks(name):
    """Of a task, with the names of its own features and of the arm's joints."""
    arm = lostmotion.read(EXAMPLES / "six-axis.toml")
    tree = tomllib.loads((EXAMPLES / "tasks" / f"{name}.toml").read_text(encoding="utf-8"))
    count, wrong = mistaken_examples(lambda by: read_task(by, arm), tree, 3, 0)
    assert count > 60
    assert not wrong, wrong[0]


@pytest.mark.parametrize(
    ("name", "every"),
    [
        ("printed-hobby-arm", 17),
        ("servo-arm", 17),
        ("gantry", 61),
        ("arm-in-the-sun", 41),
        ("z-arm", 41),
    ],
)
def test_examples_in_refusals_of_arms_are_sound_arms(name, every):
    """Of an arm: parts, links, joints, presets."""
    tree = tomllib.loads((EXAMPLES / f"{name}.toml").read_text(encoding="utf-8"))
    count, wrong = mistaken_examples(lostmotion.read, tree, every, 3)
    assert count > 20
    assert not wrong, wrong[0]


def test_an_empty_task_is_answered_with_tolerances_that_it_takes(tmp_path):
    """The example holds, but for the places that are missing as well."""
    arm = lostmotion.read(EXAMPLES / "six-axis.toml")
    (first,) = mistakes_of(lambda by: read_task(by, arm), {})
    assert first.example == 'tolerances = [{ cylinder = "0.4 mm" }]'
    (second,) = mistakes_of(lambda by: read_task(by, arm), tomllib.loads(first.example))
    assert second.example == 'poses = "path.csv"'
    path = tmp_path / "path.csv"
    path.write_text("x,y,z,force along\n600,0,400,5\n620,0,400,5\n", encoding="utf-8")
    by = tmp_path / "task.toml"
    by.write_text(f"{second.example}\n{first.example}\n", encoding="utf-8")
    with pytest.raises(InputError) as refused:
        read_task(by, arm)
    (third,) = refused.value.problems
    assert third.found == "no unit of x, y, z, force along"
    path.write_text(f"{third.example}\n600,0,400,5\n620,0,400,5\n", encoding="utf-8")
    assert len(read_task(by, arm).poses) == 2
