"""What share of small faults in the numeric core do the tests see?

Draws mutants of laws, mechanism, error model and propagation by a seed, so many of each package:
every place in the code that an operator of cosmic-ray can change is equally likely, and so is each
of its changes there. For each mutant it runs the tests of that module, in a copy of the tree: the
test files that name the module, or where none does, those that name a module which imports it. What
only other tests would see counts as survived, and so does what runs into the time limit: the score
is a lower bound. Kernels, and what they import, are compiled anew for each mutant.

Left out before the draw, because they change no figure: annotations, decorators (caches,
dataclasses), texts and their numbers, what is raised, `strict=`, imports for type checking, options
of Numba. Left out as seen for certain: operators that floats do not have. `jax_kernel.py` needs
JAX.

    pip install -e '.[test,mutation]'; python benchmarks/mutation.py [--mutants 40] [--seed 1]
    [--package laws ...] [--only MODULE]
"""

from __future__ import annotations

import argparse
import ast
import contextlib
import os
import random
import re
import shutil
import subprocess
import sys
import tempfile
import time
from collections import Counter, defaultdict
from difflib import unified_diff
from pathlib import Path

from cosmic_ray.ast import ast_nodes, get_ast
from cosmic_ray.mutating import mutate_code
from cosmic_ray.plugins import get_operator, operator_names
from scipy.stats import binomtest

ROOT = Path(__file__).resolve().parents[1]
PACKAGES = ("laws", "mechanism", "error_model", "propagation")
# folders of tests; others ask for whole studies, and run where there are none
ROOMS = (*PACKAGES, "parts", "validation")
NOT_ASKED = re.compile(
    r"ExceptionReplacer|RemoveDecorator|_(RShift|LShift|BitOr|BitAnd|BitXor|Mod|FloorDiv)$|Comparison.*(?<!_Is)(?<!_IsNot)_(Is|IsNot)$|_Is(Not)?_(?!Is)"
)
QUIET = {"refuse_argument", "Problem", "InputError", "njit", "TypeVar"}


def left_out(tree: ast.AST):
    """Yield the syntax in which a change is no fault of a figure."""
    for node in ast.walk(tree):
        yield from (getattr(node, name, None) for name in ("annotation", "returns"))
        yield from getattr(node, "decorator_list", [])
        types = isinstance(node, ast.If) and getattr(node.test, "id", "") == "TYPE_CHECKING"
        message = isinstance(node, ast.Raise | ast.JoinedStr) or (
            isinstance(node, ast.Call) and getattr(node.func, "id", "") in QUIET
        )
        if types or message or (isinstance(node, ast.keyword) and node.arg == "strict"):
            yield node


def mutants(path: Path) -> list[list[tuple[str, int]]]:
    """Return the places in a file that can be changed, each with its changes: operator and
    occurrence.
    """
    source = path.read_text(encoding="utf-8")
    lines = [line.encode() for line in source.split("\n")]

    def at(line: int, column: int) -> tuple[int, int]:  # ast counts bytes, parso characters
        return line, len(lines[line - 1][:column].decode())

    quiet = [
        (at(n.lineno, n.col_offset), at(n.end_lineno, n.end_col_offset))
        for n in left_out(ast.parse(source))
        if n is not None
    ]
    nodes, places = list(ast_nodes(get_ast(source))), defaultdict(list)
    for name in operator_names():
        operator = get_operator(name)
        if NOT_ASKED.search(name) or operator.arguments():
            continue
        for occurrence, (start, end) in enumerate(
            where for node in nodes for where in operator().mutation_positions(node)
        ):
            if not any(first <= start and end <= last for first, last in quiet):
                places[start, end].append((name, occurrence))
    return list(places.values())


def tests_of() -> dict[str, list[str]]:
    """Return the test files of each module: those that name it or else a module that imports it,
    and so on.
    """

    def named(path: Path) -> set[str]:
        found = set()
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ImportFrom) and node.module:
                found |= {node.module, *(f"{node.module}.{each.name}" for each in node.names)}
        return found

    src = {
        ".".join(path.relative_to(ROOT / "src").with_suffix("").parts): named(path)
        for path in (ROOT / "src").rglob("*.py")
    }
    tests = {
        str(path.relative_to(ROOT)): named(path)
        for path in sorted((ROOT / "tests").rglob("test_*.py"))
    }
    out = {}
    for module in src:
        ring, seen, found = {module}, {module}, []
        while ring and not found:
            found = [test for test, names in tests.items() if names & ring]
            found = [test for test in found if test.split("/")[1] in ROOMS] or found
            ring = {other for other, names in src.items() if names & ring} - seen
            seen |= ring
        out[module] = found or [f"tests/{room}" for room in ROOMS]
    return out


def run(tree: Path, tests: list[str], *, fresh: bool, limit: float) -> tuple[str, str]:
    """Return how the tests end on a changed tree: killed, survived or timeout, and the first test
    that fails.
    """
    with tempfile.TemporaryDirectory() as cache:
        env = {**os.environ, "PYTHONPATH": str(tree / "src"), "PYTHONDONTWRITEBYTECODE": "1"} | (
            {"NUMBA_CACHE_DIR": cache} if fresh else {}
        )
        command = [
            sys.executable,
            "-m",
            "pytest",
            "-x",
            "-q",
            "-n",
            "0",
            "-p",
            "no:cacheprovider",
            *tests,
        ]
        try:
            done = subprocess.run(
                command,
                cwd=tree,
                env=env,
                capture_output=True,
                text=True,
                timeout=limit,
                check=False,
            )
        except subprocess.TimeoutExpired:
            return "timeout", ""
    return "survived" if done.returncode == 0 else "killed", next(
        iter(re.findall(r"^(?:FAILED|ERROR) (\S+)", done.stdout, re.MULTILINE)), ""
    )


def try_one(
    tree: Path, path: Path, change: tuple[str, int], tests: list[str], *, fresh: bool, limit: float
) -> str:
    """Change a file of the tree, run its tests, print how they end, and put the file back."""
    source, inside, stamp, began = (
        path.read_text(encoding="utf-8"),
        path.relative_to(tree),
        path.stat(),
        time.monotonic(),
    )
    changed = mutate_code(source, get_operator(change[0])(), change[1])
    path.write_text(changed, encoding="utf-8")
    outcome, test = run(tree, tests, fresh=fresh, limit=limit)
    path.write_text(source, encoding="utf-8")
    os.utime(path, ns=(stamp.st_atime_ns, stamp.st_mtime_ns))  # compiled kernels stay valid
    print(
        f"{outcome} {inside} {change[0].split('/')[1]} {time.monotonic() - began:.0f} s {test}",
        flush=True,
    )
    if outcome == "survived":
        print(
            "\n".join(
                unified_diff(
                    source.split("\n"),
                    changed.split("\n"),
                    str(inside),
                    str(inside),
                    lineterm="",
                    n=1,
                )
            ),
            flush=True,
        )
    return outcome


def main() -> None:
    """Draw, run, count: the packages take turns, so that a run that is interrupted has drawn
    evenly.
    """
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--mutants", type=int, default=40, help="of each package")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--package", nargs="+", choices=PACKAGES, default=PACKAGES)
    parser.add_argument("--only", default="", help="modules with this in their path")
    parser.add_argument("--limit", type=float, default=300.0, help="seconds per mutant")
    asked = parser.parse_args()
    tests, kernels = (
        tests_of(),
        "".join(path.read_text(encoding="utf-8") for path in (ROOT / "src").rglob("*kernel.py")),
    )
    outcomes: dict[str, Counter[str]] = {package: Counter() for package in asked.package}
    with tempfile.TemporaryDirectory() as folder:
        tree = Path(folder) / "tree"
        shutil.copytree(ROOT, tree, ignore=shutil.ignore_patterns(".git", ".*_cache"))
        if (
            run(
                tree,
                ["--collect-only", *(f"tests/{room}" for room in ROOMS)],
                fresh=False,
                limit=600,
            )[0]
            != "survived"
        ):
            sys.exit("the tests do not start here: every mutant would count as seen")
        drawn = {}
        for package in asked.package:
            files = [
                path
                for path in sorted((tree / "src/lostmotion" / package).rglob("*.py"))
                if path.name != "jax_kernel.py"
            ]
            places = [
                (path, changes)
                for path in files
                if asked.only in str(path.relative_to(tree))
                for changes in mutants(path)
            ]
            print(f"{package}: {len(places)} places", flush=True)
            rng = random.Random(f"{asked.seed} {package}")  # noqa: S311
            rng.shuffle(places)
            drawn[package] = [
                (path, rng.choice(changes)) for path, changes in places[: asked.mutants]
            ]
        with contextlib.suppress(KeyboardInterrupt):
            for turn in range(asked.mutants):
                for package in [package for package in asked.package if turn < len(drawn[package])]:
                    path, change = drawn[package][turn]
                    module = ".".join(path.relative_to(tree / "src").with_suffix("").parts)
                    fresh = path.name.endswith("kernel.py") or f"from {module} import" in kernels
                    outcomes[package][
                        try_one(tree, path, change, tests[module], fresh=fresh, limit=asked.limit)
                    ] += 1
    for package, counts in [*outcomes.items(), ("all", sum(outcomes.values(), Counter()))]:
        seen, count = counts["killed"], max(counts.total(), 1)
        low, high = binomtest(seen, count).proportion_ci(method="wilson")
        print(
            f"{package}: {seen} of {count} seen, {seen / count:.0%} ({low:.0%} to {high:.0%}); "
            f"{dict(counts)}"
        )


if __name__ == "__main__":
    main()
