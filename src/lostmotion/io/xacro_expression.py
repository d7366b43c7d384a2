"""Plain expressions of a xacro file: numbers, text and arithmetic, which cannot reach Python."""

from __future__ import annotations

import ast
import encodings.latin_1  # loaded before the process is confined, which ends all imports
import encodings.utf_8_sig  # noqa: F401 - loaded, not used
from typing import Final

from lostmotion.errors import shown
from lostmotion.io.text import refuse

# Expressions of numbers, text, lists and dictionaries, calls and comprehensions. No lambda and no
# generator: both lead to the inside of Python.
_PLAIN: Final = (
    *(
        ast.Expression,
        ast.Constant,
        ast.Name,
        ast.Attribute,
        ast.Subscript,
        ast.Slice,
        ast.Starred,
        ast.List,
        ast.Tuple,
        ast.Set,
        ast.Dict,
    ),
    *(
        ast.UnaryOp,
        ast.BinOp,
        ast.BoolOp,
        ast.Compare,
        ast.IfExp,
        ast.Call,
        ast.keyword,
        ast.ListComp,
        ast.SetComp,
        ast.DictComp,
    ),
    *(
        ast.comprehension,
        ast.JoinedStr,
        ast.FormattedValue,
        ast.operator,
        ast.unaryop,
        ast.boolop,
        ast.cmpop,
        ast.expr_context,
    ),
)
# Methods of text that follow attributes by name.
_FORMATTERS: Final = ("format", "format_map")


def check_plain(expression: str, file: str) -> None:
    """Raise InputError for an expression whose syntax could reach the inside of Python, and
    SyntaxError for what is no expression.
    """
    for node in ast.walk(ast.parse(expression.strip(), mode="eval")):
        name = getattr(node, "id", "") or getattr(node, "attr", "")
        hidden = name.startswith("_") if isinstance(node, ast.Attribute) else name.startswith("__")
        if (
            hidden
            or not isinstance(node, _PLAIN)
            or (isinstance(node, ast.Attribute) and name in _FORMATTERS)
        ):
            expected = (
                "arithmetic, text, lists, dictionaries and functions of xacro; nothing that leads "
                "to the inside of Python"
            )
            refuse(file, "", f"the expression {shown(expression)}", expected, "${pi / 2}")
