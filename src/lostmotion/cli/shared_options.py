"""The options that commands have besides the arguments of their question."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, Literal

from lostmotion.analyses.signature import Argument, QuestionParameter

if TYPE_CHECKING:
    from lostmotion.analyses.signature import Question

# What every command has besides the arguments of its question.
SHARED: Final = (
    QuestionParameter(
        "out",
        str,
        Argument(
            "Folder for report.html, result.json and what else the command writes.",
            metavar="FOLDER",
        ),
        None,
    ),
    QuestionParameter(
        "figures",
        Literal["svg", "pdf", "png"],
        Argument("Also write every figure of the report as a file into FOLDER/figures."),
        None,
    ),
    QuestionParameter(
        "tables",
        Literal["csv", "latex"],
        Argument("Also write every table as a file into FOLDER/tables; LaTeX for booktabs."),
        None,
    ),
    QuestionParameter("force", bool, Argument("Replace an existing output folder."), default=False),
    QuestionParameter(
        "json",
        bool,
        Argument(
            "Print result.json in place of the figures; then a folder is written only where "
            "--out names one."
        ),
        default=False,
    ),
    QuestionParameter(
        "full", bool, Argument("Print every figure in place of one screen."), default=False
    ),
    QuestionParameter(
        "quiet", bool, Argument("Print the answer alone, on one line."), default=False
    ),
)
# What a command has whose result is data that it states in words.
_AS_JSON: Final = QuestionParameter(
    "json", bool, Argument("Print the result as JSON."), default=False
)
# Of these, what a report's folder holds besides the report.
COPIES: Final = frozenset({"figures", "tables"})


def shared_options(question: Question) -> tuple[QuestionParameter, ...]:
    """Return the options that a command has besides the arguments of its question: where its result
    is data alone, only one to print it as such.
    """
    own = {each.name for each in question.options}
    if question.folder is None:
        return () if question.in_words is None else (_AS_JSON,)
    own |= {"force"} if "out" in own else set()
    # what it writes is one file, and no report
    own |= COPIES if "out" in own and not question.folder else set()
    return tuple(each for each in SHARED if each.name not in own)
