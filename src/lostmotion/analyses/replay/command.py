"""Ask how the largest errors of a run arise."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

from lostmotion.analyses.arguments import ProgressArgument, path_of
from lostmotion.analyses.signature import Argument, question, read_arguments

if TYPE_CHECKING:
    from pathlib import Path

    from lostmotion.analyses.replay.page import Replayed


@question(folder="")
def replay(
    run: Annotated[
        "str | Path",
        Argument(
            "Folder of a run, as `sweep` wrote it; nothing in it is changed.",
            path_of,
            metavar="FOLDER",
        ),
    ],
    design: Annotated[
        int | None, Argument("Number of the design, from 0. Default: all of them.", least=0)
    ] = None,
    worst: Annotated[
        int, Argument("How many of the largest errors, each of another pose.", least=1, most=1000)
    ] = 1,
    progress: ProgressArgument = None,
) -> list[Replayed]:
    """Show how the largest errors of a run arise: pose, every draw and what it contributes, the
    largest first.

    On the command line the exit code is 1 where an error is not reproduced.

    Raises
    ------
    InputError
        For a number out of range.
    LostmotionError
        For a folder that holds no run or lacks blocks.

    """
    asked = read_arguments(replay, locals())
    from lostmotion.analyses.replay.page import Replayed
    from lostmotion.runs.store import Store

    return Replayed.largest(Store.open(asked.run), asked.design, asked.worst, progress)
