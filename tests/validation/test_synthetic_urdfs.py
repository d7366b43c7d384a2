"""Synthetic URDF trees, read here and by Pinocchio: the same tool frame and the same static
torques, whatever hangs beside the chain.
"""

from __future__ import annotations

import numpy as np
import pytest

from lostmotion.errors import InputError
from lostmotion.io import read
from tests.io.urdfs import agrees_with_pinocchio, link, robot

KINDS = (
    "revolute",
    "revolute",
    "revolute",
    "revolute",
    "continuous",
    "prismatic",
    "fixed",
    "fixed",
)
FROM, TO = -1.3, 0.9


def synthetic(rng: np.random.Generator) -> tuple[str, list[str], dict[str, float]]:
    """Return a tree of a chain and side branches, its links, and the values of the joints that
    cannot move.
    """
    links, locked = ["root"], {}
    parts = [link("root", 3.0)]
    for k in range(int(rng.integers(4, 14))):
        parent = links[-1] if rng.random() < 0.7 else links[int(rng.integers(len(links)))]
        kind = KINDS[int(rng.integers(len(KINDS)))]
        low, high = FROM, TO
        if kind in {"revolute", "prismatic"} and rng.random() < 0.1:
            low = high = round(float(rng.uniform(-1, 1)), 3)
            locked[f"j{k}"] = low
        x, y, z, r, p, w, a, b, c = (repr(float(value)) for value in rng.uniform(-1, 1, 9))
        own = (
            f'<axis xyz="{a} {b} {c}"/><limit lower="{low}" upper="{high}" effort="1" '
            'velocity="1"/>'
        )
        ends = (
            f'<parent link="{parent}"/><child link="l{k}"/><origin xyz="{x} {y} {z}" rpy="{r} {p} '
            f'{w}"/>'
        )
        parts.append(f'<joint name="j{k}" type="{kind}">{ends}{own}</joint>')
        parts.append(link(f"l{k}", round(float(rng.uniform(0, 5)), 3), f"{y} {w} {a}"))
        links.append(f"l{k}")
    return robot(*parts), links, locked


@pytest.mark.parametrize("seed", range(40))
def test_a_synthetic_tree_has_the_frames_and_torques_of_pinocchio(tmp_path, seed):
    """To any of its links, from the root and from any link before; joints beside the chain stand at
    zero, those that cannot move at their limit.
    """
    rng = np.random.default_rng(seed)
    text, links, locked = synthetic(rng)
    path = tmp_path / "r.urdf"
    path.write_text(text, encoding="utf-8")
    compared = 0
    for tip in links[-3:]:
        for base in ("root", links[1], links[len(links) // 2]):
            path.with_suffix(".toml").write_text(
                f'tip = "{tip}"\nbase = "{base}"\n', encoding="utf-8"
            )
            try:
                found = read(path)
            except InputError:
                # no joint that moves between the two, or no way from one to the other
                continue
            on_chain = {joint.name for joint in found.joints}
            held = {name: value for name, value in locked.items() if name in on_chain}
            agrees_with_pinocchio(path, found, tip, base, held)
            compared += 1
    assert compared
