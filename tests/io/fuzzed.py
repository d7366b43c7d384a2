"""Files of every format, spoiled at random: examples and fragments of the tests with numbers,
units, words and lines changed, lost or mixed.

Run by itself, `python -m tests.io.fuzzed COUNT SEED [--studied SHARE] [--first NUMBER]`, it counts
the outcomes and names the slowest files; stopped, it does so for those done. Of every tenth
readable file that describes something to study, or of another share (with 0.8 a tenth of ALL files
is studied), a small study is made. A file depends on seed and number alone, not on the share, so
that a long run can be divided: `--first 5000` begins with number 5000. Finds are: any exception but
the project's own, a warning, a control character in a message, a figure that is no number, a file
left behind, more than 20 s. `tests.io.fuzzed_by_coverage` spoils by what code a file reaches.
"""

from __future__ import annotations

import argparse
import os
import random
import re
import signal
import sys
import tempfile
import time
import traceback
import warnings
from collections import Counter
from pathlib import Path
from typing import NamedTuple

from lostmotion.errors import LostmotionError
from tests.io.fuzzed_formats import Format, formats

# What stands in the place of a number.
NUMBERS = (
    *(
        "0",
        "-0",
        "-1",
        "1",
        "2",
        "0.5",
        "1e-6",
        "1e-12",
        "1e-16",
        "1e-19",
        "1e-300",
        "5e-324",
        "1e15",
        "9e14",
        "1e16",
        "1e300",
    ),
    *(
        "1.8e308",
        "1e400",
        "-1e400",
        "nan",
        "inf",
        "9" * 400,
        "0." + "0" * 390 + "1",
        "1e" + "9" * 30,
        "0x" + "f" * 300,
        "1_0",
        "٣",
    ),
    *("1,5", "", " ", "--1", "1e", "true", "2020-01-01", "[1, 2]"),
)
UNITS = (
    "mm",
    "m",
    "µm",
    "km",
    "arcmin",
    "deg",
    "rad",
    "rev",
    "N m",
    "N m/arcmin",
    "N m/rad",
    "kg",
    "g",
    "%",
    "GPa",
    "K",
    "kg/m^3",
    "",
    "quux",
    "m^9",
)
WORDS = (
    *(
        "",
        " ",
        "\0",
        "\x1b[31mred",
        "\x07",
        "\u202e",
        "\ufeff",
        "\ud7ff",
        "ä" * 300,
        "..",
        "../../etc/passwd",
        "/dev/zero",
        "a.b",
        "a\\nb",
        "'",
        '"',
    ),
    *(
        "[[",
        "]]",
        "{",
        "}",
        "=",
        "#",
        "<",
        ">",
        "&lt;",
        "&x;",
        "<!DOCTYPE x>",
        "\\ud800",
        "\\u001b[31m",
        "±",
        "(uniform)",
        "(normal)",
        "NaN",
        "null",
    ),
)
WORDS_OF_A_FILE = re.compile(r"[A-Za-z_]{2,30}")
NUMBER = re.compile(r"[-+]?\d+(?:\.\d*)?(?:[eE][-+]?\d+)?")
UNIT = re.compile(r"(?<=\d )[A-Za-zµ°%/]+(?: [a-z/]+)?")
LONGEST = 20.0  # s of the processor, that any file may take to be read
LONGEST_STUDY = 120.0  # with its study: three gearboxes from their drawings take half a minute
# Share of the readable files of which a small study is made, unless another is asked for.
STUDIED = 0.1
QUOTED = re.compile(r'"[^"\n]*"')


def spoiled(seed: str, others: tuple[str, ...], chance: random.Random) -> bytes:
    """Change a sound text at one to four places."""
    text = seed
    for _ in range(chance.choice((1, 1, 1, 1, 1, 1, 2, 2, 4))):
        text = chance.choice(_CHANGES)(text, others, chance)[:200_000]
    raw = text.encode("utf-8", "surrogatepass")
    if chance.random() < 0.05 and raw:
        at = chance.randrange(len(raw))
        raw = raw[:at] + bytes([chance.randrange(256)]) + raw[at + chance.randrange(2) :]
    return raw


def _put(text: str, pattern: re.Pattern[str], by: str, chance: random.Random) -> str:
    found = list(pattern.finditer(text))
    if not found:
        return text
    match = chance.choice(found)
    return text[: match.start()] + by + text[match.end() :]


def _number(text: str, _: tuple[str, ...], chance: random.Random) -> str:
    return _put(text, NUMBER, chance.choice(NUMBERS), chance)


def _unit(text: str, _: tuple[str, ...], chance: random.Random) -> str:
    return _put(text, UNIT, chance.choice(UNITS), chance)


def _word(text: str, others: tuple[str, ...], chance: random.Random) -> str:
    words = WORDS_OF_A_FILE.findall(chance.choice(others)) or [""]
    return _put(
        text,
        WORDS_OF_A_FILE,
        chance.choice((chance.choice(words), chance.choice(words), chance.choice(WORDS))),
        chance,
    )


def _value(text: str, others: tuple[str, ...], chance: random.Random) -> str:
    values = QUOTED.findall(chance.choice(others)) or ['""']
    other = chance.choice(
        (
            chance.choice(values),
            chance.choice(NUMBERS),
            '["1 mm", 2]',
            "{ a = 1 }",
            "[]",
            "{}",
            "false",
            '"' + "x" * 999 + '"',
        )
    )
    return _put(text, QUOTED, other, chance)


def _line(text: str, others: tuple[str, ...], chance: random.Random) -> str:
    lines = text.split("\n")
    at = chance.randrange(len(lines))
    how = chance.randrange(5)
    if how == 0:
        del lines[at]
    elif how == 1:
        lines.insert(at, lines[chance.randrange(len(lines))])
    elif how == 2:
        lines[at] = chance.choice(chance.choice(others).split("\n"))
    elif how == 3:
        other = chance.randrange(len(lines))
        lines[at], lines[other] = lines[other], lines[at]
    else:
        lines = lines[:at] + lines[at + chance.randrange(1, 8) :]
    return "\n".join(lines)


def _insert(text: str, _: tuple[str, ...], chance: random.Random) -> str:
    at = chance.randrange(len(text) + 1)
    return text[:at] + chance.choice(WORDS) + text[at + chance.choice((0, 0, 1, 5)) :]


def _cut(text: str, others: tuple[str, ...], chance: random.Random) -> str:
    at = chance.randrange(len(text) + 1)
    other = chance.choice(others)
    return text[:at] + (other[chance.randrange(len(other) + 1) :] if chance.random() < 0.5 else "")


_CHANGES = (
    _number,
    _number,
    _number,
    _unit,
    _word,
    _word,
    _value,
    _value,
    _line,
    _line,
    _insert,
    _cut,
)


class Outcome(NamedTuple):
    """What became of one file: refused, read, studied, or wrong with what was raised, and the
    processor seconds it took.
    """

    format: str
    number: int
    said: str
    seconds: float
    raw: bytes


def _rounds(kinds: tuple[Format, ...]) -> list[Format]:
    """Return the kinds in the order in which they are spoiled, those that take long less often than
    the others.
    """
    longest = max(kind.every for kind in kinds)
    return [kind for k in range(longest) for kind in kinds if k % kind.every == 0]


def outcomes(folder: Path, first: int, last: int, seed: int = 1, share: float = STUDIED):
    """Spoil files number `first` to `last`, each by itself reproducible, read each, study this
    share of those that describe something to study, and return what became of each.
    """
    kinds = formats(folder)
    rounds = _rounds(kinds)
    left = set(os.listdir(folder))  # noqa: PTH208 - names alone
    others = tuple(text for kind in kinds for text in kind.seeds)
    for number in range(first, last):
        chance = random.Random(f"{seed}.{number}")  # noqa: S311 - no secrets
        kind = rounds[number % len(rounds)]
        studied = kind.study is not None and chance.random() < share
        raw = spoiled(
            chance.choice(kind.seeds), others if chance.random() < 0.2 else kind.seeds, chance
        )
        path = folder / kind.name
        path.write_bytes(raw)
        begin = time.process_time()
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("error")
                kind.read(path)
                if studied:
                    kind.study(path)
            said = "studied" if studied else "read"
        except LostmotionError as error:
            said = (
                "refused"
                if str(error).isprintable() or _plain(str(error))
                else "wrong: control characters in the message: " + ascii(str(error))
            )
        except Exception:  # noqa: BLE001 - whatever else is raised is what is looked for
            said = "wrong: " + traceback.format_exc(limit=-6)
        seconds = time.process_time() - begin
        path.unlink(missing_ok=True)
        if set(os.listdir(folder)) != left:  # noqa: PTH208 - names alone
            said = "wrong: left files behind"
        yield Outcome(kind.name, number, said, seconds, raw)


def longest(found: Outcome) -> float:
    """Return how long an input may take, s of the processor."""
    return LONGEST_STUDY if found.said == "studied" else LONGEST


def _plain(message: str) -> bool:
    return all(line.isprintable() for line in message.split("\n"))


def main() -> None:
    """Spoil so many files from such a seed, and say what became of them."""
    asked = argparse.ArgumentParser(prog="python -m tests.io.fuzzed")
    asked.add_argument("count", type=int)
    asked.add_argument("seed", type=int)
    asked.add_argument("--studied", type=float, default=STUDIED, metavar="SHARE")
    asked.add_argument("--first", type=int, default=0, metavar="NUMBER")
    given = asked.parse_args()
    last = given.first + given.count
    counts: Counter[tuple[str, str]] = Counter()
    slowest: list[tuple[float, str, int]] = []
    wrong: Counter[str] = Counter()
    stopped: list[bool] = []
    # an exception in the middle of a file would count as a find
    for end in (signal.SIGINT, signal.SIGTERM):
        signal.signal(end, lambda *_: stopped.append(True))
    with tempfile.TemporaryDirectory() as name:
        for found in outcomes(Path(name), given.first, last, given.seed, given.studied):
            if stopped:
                break
            kind = found.said.split(":")[0]
            counts[found.format, kind] += 1
            slowest = sorted([*slowest, (found.seconds, found.format, found.number)], reverse=True)[
                :5
            ]
            if kind == "wrong":
                wrong[found.said] += 1
                if wrong[found.said] == 1:
                    sys.stdout.write(f"--- {found.format} number {found.number}\n{found.said}\n")
                    sys.stdout.flush()
            if found.seconds > longest(found):
                sys.stdout.write(
                    f"--- {found.format} number {found.number}: {found.seconds:.0f} s\n"
                )
    for each, number in sorted(counts.items()):
        sys.stdout.write(f"{each[0]:16} {each[1]:8} {number}\n")
    sys.stdout.write(f"slowest: {slowest}\n")


if __name__ == "__main__":
    main()
