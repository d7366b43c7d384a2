"""Arithmetic on symbols, written out as C: constants are folded, products with zero and one vanish,
and each expression is stored once.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, TypeAlias

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence

# Characters of an expression from which on it has a line of its own.
_LONG: Final = 80


class Symbol:
    """A number that is known when the C source runs: what NumPy adds and multiplies in an array of
    objects.
    """

    __slots__ = ("index", "of")

    def __init__(self, of: Expressions, index: int) -> None:
        """Take the index of an expression."""
        self.of, self.index = of, index

    def __neg__(self) -> Number:
        """Return its negative."""
        operation, *operands = self.of.nodes[self.index]
        if operation == "neg":
            return Symbol(self.of, operands[0])  # type: ignore[arg-type]
        return self.of.symbol("neg", self.index)

    def __add__(self, other: Number) -> Number:
        """Return a sum."""
        if not isinstance(other, Symbol):
            constant = float(other)
            return (
                self
                if constant == 0
                else self.of.symbol(
                    "+" if constant > 0 else "-", self.index, self.of.number(abs(constant))
                )
            )
        mine, its = self.of.positive(self), self.of.positive(other)
        if its is not None:
            return self - its
        return (
            other - mine
            if mine is not None
            else self.of.symbol("+", *sorted((self.index, other.index)))
        )

    __radd__ = __add__

    def __sub__(self, other: Number) -> Number:
        """Return a difference."""
        if not isinstance(other, Symbol):
            return self + -other
        its = self.of.positive(other)
        if its is not None:
            return self + its
        return 0.0 if self.index == other.index else self.of.symbol("-", self.index, other.index)

    def __rsub__(self, other: float) -> Number:
        """Return the difference from a constant."""
        return -self + other

    def __mul__(self, other: Number) -> Number:
        """Return a product."""
        mine = self.of.positive(self)
        if mine is not None:
            return -(mine * other)
        if isinstance(other, Symbol):
            its = self.of.positive(other)
            return (
                -(self * its)
                if its is not None
                else self.of.symbol("*", *sorted((self.index, other.index)))
            )
        if other in {0, 1, -1}:
            return 0.0 if other == 0 else self if other == 1 else -self
        return (
            self.of.symbol("*", self.index, self.of.number(float(other)))
            if other > 0
            else -(self * -other)
        )

    __rmul__ = __mul__

    def cos(self) -> Number:
        """Return the cosine, as NumPy asks for it."""
        return self.of.symbol("call", "LM_COS", self.index)

    def sin(self) -> Number:
        """Return the sine."""
        return self.of.symbol("call", "LM_SIN", self.index)


Number: TypeAlias = "Symbol | float"
# Operation and operands: the index of an expression, or text of C. A constant is text, because 2
# and 2.0 are one key.
Node: TypeAlias = "tuple[str | int, ...]"


class Expressions:
    """Expressions of C, each stored once; `number` spells a constant."""

    def __init__(self, number: Callable[[float], str]) -> None:
        """Start without any."""
        self.nodes: list[Node] = []
        self._known: dict[Node, int] = {}
        self.number = number

    def symbol(self, *node: str | int) -> Symbol:
        """Return the symbol of an operation and its operands: integers are indices of
        expressions.
        """
        if node not in self._known:
            self._known[node] = len(self.nodes)
            self.nodes.append(node)
        return Symbol(self, self._known[node])

    def text(self, text: str) -> Symbol:
        """Return the symbol of a term of C."""
        return self.symbol("text", text)

    def call(self, function: str, *operands: Number) -> Symbol:
        """Return the symbol of a call of a C function."""
        return self.symbol(
            "call",
            function,
            *(
                each.index if isinstance(each, Symbol) else self.number(float(each))
                for each in operands
            ),
        )

    def statement(self, template: str, *operands: Number) -> Symbol:
        """Return the symbol of a statement, {0}, {1} ... being its operands; what it computes are
        `results` of it.
        """
        return self.symbol(
            "statement",
            template,
            *(
                each.index if isinstance(each, Symbol) else self.number(float(each))
                for each in operands
            ),
        )

    def result(self, statement: Symbol, text: str) -> Symbol:
        """Return the symbol of a term of C that has its value right after a statement."""
        return self.symbol("result", text, statement.index)

    def positive(self, symbol: Symbol) -> Symbol | None:
        """Return the symbol of which this one is the negative."""
        operation, *operands = self.nodes[symbol.index]
        return Symbol(self, operands[0]) if operation == "neg" else None  # type: ignore[arg-type]

    def lines(self, outputs: Sequence[tuple[str, Number]]) -> Iterator[str]:
        """Yield the statements of C that compute the outputs, pairs of a place to store and what to
        store there.
        """
        uses = self._uses([value.index for _, value in outputs if isinstance(value, Symbol)])
        texts: dict[int, str] = {}

        def spelt(operand: str | int) -> str:
            return texts[operand] if isinstance(operand, int) else operand

        for index in sorted(uses):
            operation, *operands = self.nodes[index]
            own = [spelt(each) for each in operands]
            match operation:
                case "statement":
                    texts[index] = ""
                    yield own[0].format(*own[1:])
                    continue
                case "text":
                    texts[index] = own[0]
                    continue
                case "result":
                    text = own[0]
                case "call":
                    text = f"{own[0]}({', '.join(own[1:])})"
                case "neg":
                    text = f"(-{own[0]})"
                case _:
                    text = f"({own[0]} {operation} {own[1]})"
            if (
                operation in {"result", "call"}
                or (uses[index] > 1 and operation != "neg")
                or len(text) > _LONG
            ):
                texts[index] = f"v{index}"
                yield (
                    f"const lm_real v{index} = "
                    f"{text.removeprefix('(').removesuffix(')') if text.startswith('(') else text};"
                )
            else:
                texts[index] = text
        for place, value in outputs:
            yield (
                f"{place} = "
                f"{texts[value.index] if isinstance(value, Symbol) else self.number(float(value))};"
            )

    def _uses(self, outputs: Sequence[int]) -> dict[int, int]:
        """Return how often each expression that the outputs need is used."""
        uses: dict[int, int] = {}
        open_ends = list(outputs)
        while open_ends:
            index = open_ends.pop()
            uses[index] = uses.get(index, 0) + 1
            if uses[index] == 1:
                open_ends += [each for each in self.nodes[index][1:] if isinstance(each, int)]
        return uses
