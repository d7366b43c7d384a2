"""Files that reach new code: Atheris changes texts of one kind, and keeps those that run lines
which no text before has run.

`pip install -e '.[fuzz]'`, then `python -m tests.io.fuzzed_by_coverage KIND FOLDER [options of
libFuzzer]`, for example

    python -m tests.io.fuzzed_by_coverage arm.toml /tmp/found -max_total_time=600 -seed=1

KIND is a name of `tests.io.fuzzed_formats.formats`; FOLDER keeps the texts found, and is read again
by the next run. A find stops the run with a traceback and the text as a file `crash-...`. Command
lines are left to `tests.io.fuzzed`, which keeps them from writing elsewhere.
"""

from __future__ import annotations

import sys
import tempfile
import warnings
from pathlib import Path

import atheris

with atheris.instrument_imports(include=["lostmotion"]):
    from lostmotion.errors import LostmotionError
    from tests.io.fuzzed_formats import formats


def main() -> None:
    """Change texts of one kind until a find, or until libFuzzer's options end the run."""
    name, found = sys.argv[1], Path(sys.argv[2])
    work = Path(tempfile.mkdtemp())
    kinds = {kind.name: kind for kind in formats(work) if kind.name != "command.txt"}
    if name not in kinds:
        raise SystemExit(f"{name}: expected one of {', '.join(kinds)}")
    kind, path = kinds[name], work / name
    found.mkdir(parents=True, exist_ok=True)
    for k, text in enumerate(kind.seeds):
        (found / f"sound-{k}").write_text(text, encoding="utf-8")

    def read(raw: bytes) -> None:
        path.write_bytes(raw)
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            try:
                kind.read(path)
            except LostmotionError as error:
                message = str(error)
                if not all(line.isprintable() for line in message.split("\n")):
                    raise AssertionError(ascii(message)) from error

    atheris.Setup([sys.argv[0], str(found), "-timeout=60", *sys.argv[3:]], read)
    atheris.Fuzz()


if __name__ == "__main__":
    main()
