"""Foreign readers in a process of their own: other people's packages read files that may be
hostile.

`ask` starts a module of this package with a request, and returns its answer. The module calls
`serve` with the function that answers. Its process has bounds on time, memory and written bytes, an
empty environment and an empty working folder; `confine` then takes files, network and processes
from it.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from typing import TYPE_CHECKING, Any, Final

from lostmotion.errors import InputError, Problem
from lostmotion.io.text import refuse

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

_WAITS: Final = 6  # times the processor's time, for a machine with other work
_MEMORY: Final = 2_000_000_000
_LONGEST_ANSWER: Final = 20_000_000
_MOST_FILES: Final = 64
# What Python reports of a program that computes, and opens or starts nothing.
_HARMLESS: Final = frozenset(
    {"builtins.id", "compile", "exec", "glob.glob", "glob.glob/2", "object.__getattr__"}
)
_LISTS: Final = frozenset({"os.listdir", "os.scandir"})


def ask(module: str, request: dict[str, Any], file: str, seconds: int) -> dict[str, Any]:
    """Return the answer of a module of this package, run in a process of its own for at most so
    many seconds of a processor.

    `file` is named where the process ends without an answer. Raises InputError with the mistakes
    that the module found, and where it reached a bound.
    """
    # The packages of this process and nothing else of its surroundings: a file may ask for
    # variables of the environment.
    bounds = (
        f"an arm that is read within {seconds} s, {_MEMORY // 10**9} GB of memory and "
        f"{_LONGEST_ANSWER // 10**6} MB of result"
    )
    environment = {
        "PYTHONPATH": os.pathsep.join(filter(None, sys.path)),
        "OPENBLAS_NUM_THREADS": "1",
        "PYTHONIOENCODING": "utf-8",
    }
    if "SYSTEMROOT" in os.environ:  # Python does not start on Windows without it
        environment["SYSTEMROOT"] = os.environ["SYSTEMROOT"]
    with tempfile.TemporaryDirectory() as folder, tempfile.TemporaryFile() as out:
        environment["NUMBA_CACHE_DIR"] = folder
        try:
            done = subprocess.run(  # noqa: S603 - this Python, with a module of this package
                [sys.executable, "-P", "-s", "-m", module],
                input=json.dumps({**request, "seconds": seconds}).encode(),
                stdout=out,
                stderr=subprocess.DEVNULL,
                env=environment,
                cwd=folder,
                timeout=_WAITS * seconds,
                check=False,
            )
        except subprocess.TimeoutExpired:
            refuse(
                file,
                "",
                f"a file that takes more than {_WAITS * seconds} s to read",
                bounds,
                "one arm per file",
            )
        out.seek(0)
        try:
            answer: dict[str, Any] = json.loads(out.read(_LONGEST_ANSWER))
        except ValueError:
            refuse(
                file,
                "",
                f"a file whose reader ended without an answer (exit code {done.returncode})",
                bounds,
                "one arm per file",
            )
    if "problems" in answer:
        raise InputError([Problem(*map(str, fields)) for fields in answer["problems"]])
    return answer


def serve(work: Callable[[dict[str, Any]], dict[str, Any]]) -> None:
    """Answer the request on standard input by what `work` makes of it, within bounds. Its
    InputError is the answer too.
    """
    request = json.load(sys.stdin)
    _bound(request["seconds"])
    # Packages print warnings: they must not get between the words of the answer.
    out = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
    try:
        answer = work(request)
    except InputError as error:
        answer = {
            "problems": [
                [each.file, each.key, each.found, each.expected, each.example, each.nearest]
                for each in error.problems
            ]
        }
    with out:
        json.dump(answer, out)


def _bound(seconds: int) -> None:
    """Set the bounds of this process; Windows has none of them but the time that `ask` waits."""
    if sys.platform != "win32":
        import resource

        for kind, most in (
            (resource.RLIMIT_CPU, seconds),
            (resource.RLIMIT_AS, _MEMORY),
            (resource.RLIMIT_FSIZE, _LONGEST_ANSWER),
            (resource.RLIMIT_NOFILE, _MOST_FILES),
            (resource.RLIMIT_CORE, 0),
        ):
            resource.setrlimit(kind, (most, most))


def confine(folders: Sequence[str]) -> list[str]:
    """From now on let this process read files in these folders only, and neither write, connect,
    import nor start anything. It cannot be undone.

    Returns the list of the places that were refused, which grows; `folders` may grow too.
    """
    refused: list[str] = []

    def watch(event: str, arguments: tuple[Any, ...]) -> None:
        if event in _HARMLESS or event.startswith("cpython."):
            return
        place = arguments[0] if event == "open" or event in _LISTS else None
        if isinstance(place, str | bytes | os.PathLike):
            path = os.path.realpath(os.fsdecode(place))
            writes = event == "open" and arguments[2] & (
                os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_TRUNC
            )
            if not writes and any(os.path.commonpath([path, each]) == each for each in folders):
                return
        refused.append(event if place is None else os.path.realpath(os.fsdecode(place)))
        raise PermissionError(1, "not allowed in an arm's file", refused[-1])

    sys.addaudithook(watch)
    return refused
