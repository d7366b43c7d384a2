"""The arms of which rules of the error model are checked: examples, and seven of the first thirty
random arms, which together have every kind of part, joint and base mount that the thirty have.
"""

from __future__ import annotations

from tests.parts.random_arms import example_arms, random_arm

SEEDS = (3, 4, 8, 9, 14, 15, 29)
ARMS = [*example_arms(), *map(random_arm, SEEDS)]
