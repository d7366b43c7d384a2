"""Symbols compute what numbers compute, and what is written of them is short."""

from __future__ import annotations

import math
import operator

import numpy as np
import pytest

from lostmotion.controller_model.expressions import Expressions


def run(lines, values):
    """Return the outputs of lines of C, whose arithmetic is that of Python."""
    known = {
        "LM_COS": math.cos,
        "LM_SIN": math.sin,
        "clip": lambda x, low, high: min(max(x, low), high),
    } | values
    for line in lines:
        target, _, text = line.removesuffix(";").partition(" = ")
        known[target.split()[-1]] = eval(text, {}, known)  # noqa: S307 - lines that this test has made
    return known


@pytest.mark.parametrize("seed", range(20))
def test_lines_compute_what_the_operations_compute(seed):
    """Random sums, differences, products and negatives of symbols and constants, zero and one among
    them.
    """
    rng, found = np.random.default_rng(seed), Expressions(repr)
    values = {name: rng.uniform(-2, 2) for name in "abc"}
    pairs = [(found.text(name), value) for name, value in values.items()] + [
        (k, k) for k in (0.0, 1.0, -1.0, 0.3, -0.7)
    ]
    for _ in range(60):
        operation = (operator.add, operator.sub, operator.mul)[rng.integers(3)]
        (x, u), (y, v) = (pairs[rng.integers(len(pairs))] for _ in range(2))
        pairs += (
            [(operation(x, y), operation(u, v)), (-x, -u)] if abs(operation(u, v)) < 1e3 else []
        )
    known = run(found.lines([(f"out{k}", x) for k, (x, _) in enumerate(pairs)]), values)
    np.testing.assert_allclose(
        [known[f"out{k}"] for k in range(len(pairs))], [u for _, u in pairs], rtol=1e-9, atol=1e-9
    )


def test_products_of_matrices_skip_zeros_and_ones():
    """A quarter turn of a vector costs nothing; an expression that occurs twice is computed
    once.
    """
    found = Expressions(repr)
    vector = np.array([found.text(name) for name in "abc"], dtype=object)
    turned = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]) @ vector
    assert list(found.lines([(f"out{k}", x) for k, x in enumerate(turned)])) == [
        "out0 = (-b);",
        "out1 = a;",
        "out2 = c;",
    ]
    a, b, _ = vector
    lines = list(
        found.lines(
            [("x", (a * b) * (b * a)), ("y", found.call("clip", a * b, -1.0, 1.0)), ("z", a - a)]
        )
    )
    assert sum(line.count("*") for line in lines) == 2
    assert lines[-1] == "z = 0.0;"
    assert run(lines, {"a": 3.0, "b": 0.5})["y"] == 1.0
