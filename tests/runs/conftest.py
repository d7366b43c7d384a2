"""A small arm, small enough that a run of many blocks takes a second."""

from __future__ import annotations

import hashlib

import pytest

ARM = """
name = "tiny"

[payload]
mass = "2 kg"

[gearboxes.small]
ratio = 50
rated_torque = "40 N m"
stiffness = "10 N m/arcmin"
backlash = "1 arcmin ± 0.3 arcmin"

[[joints]]
name = "A"
type = "revolute"
axis = "z"
limits = ["-90 deg", "90 deg"]
gearbox = "small"
link = { length = "300 mm ± 50 µm" }

[[joints]]
name = "B"
type = "revolute"
axis = "y"
limits = ["-60 deg", "60 deg"]
gearbox = "small"
link = { length = "200 mm ± 50 µm" }
"""
SWEEP = """
[sweep]
"gearboxes.small.backlash" = ["0.5 arcmin", "1 arcmin ± 0.3 arcmin"]
payload.mass = { from = "1 kg", to = "3 kg", steps = 2 }
"""
COUNTS = ("--poses", "64", "--robots", "20", "--visits", "3", "--block", "4")


@pytest.fixture
def arm(tmp_path):
    """Return the path of a small arm that sweeps four designs."""
    path = tmp_path / "tiny.toml"
    path.write_text(ARM + SWEEP, encoding="utf-8")
    return path


def tree(folder):
    """Return what every file of a folder holds, by its place."""
    return {
        str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in sorted(folder.rglob("*"))
        if path.is_file()
    }
