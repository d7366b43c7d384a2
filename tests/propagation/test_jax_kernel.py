"""The JAX kernel, compared with the compiled kernels; the processor runs JAX in these tests."""

import importlib.util
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import lostmotion
from lostmotion import sample_poses, screws
from lostmotion.error_model import draw_kernel
from lostmotion.errors import InputError, LostmotionError
from lostmotion.mechanism.arm import Arm
from lostmotion.mechanism.state import state_of
from lostmotion.parts.joint import PrismaticJoint
from lostmotion.propagation.montecarlo import jax_kernel, kernel
from lostmotion.propagation.montecarlo.blocks import BlockPlan, sample_block
from lostmotion.propagation.montecarlo.montecarlo import run
from tests.command import carried_out

# A row of docs/validation.md each: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "Monte Carlo on a graphics processor",
        "the compiled kernel with the same draws",
        "1e-12; two samples at edges of bins",
        "propagation/montecarlo/jax_kernel.py",
    ),
)

ARM = Path(__file__).parents[2] / "examples" / "z-arm.toml"
needs_jax = pytest.mark.skipif(
    importlib.util.find_spec("jax") is None,
    reason="JAX is not installed: pip install 'lostmotion[benchmark-jax]'",
)


@needs_jax
@pytest.mark.slow
@pytest.mark.parametrize(("robots", "visits"), [(300, 1), (150, 7)])
def test_jax_returns_the_compiled_kernels_figures(arm, monkeypatch, robots, visits):
    """JAX returns the compiled kernel's figures to 1e-12 of the largest error, also where it
    computes the poses in several steps.

    The histograms may differ in samples on the edge of a bin alone.
    """
    poses = sample_poses(arm, 40)
    matrix = screws(state_of(arm, poses.q))
    plan = BlockPlan.of(arm, poses, robots, visits, 7, 0.0)
    compiled = sample_block(plan, matrix, 3)
    monkeypatch.setattr(
        jax_kernel, "_AT_ONCE", 12 * -(-robots // draw_kernel.LANES) * draw_kernel.LANES * visits
    )
    found = sample_block(replace(plan, device="gpu"), matrix, 3)
    largest = compiled.per_pose[:, kernel.LARGEST].max()
    whose = [kernel.LARGEST_ROBOT, kernel.LARGEST_VISIT]
    np.testing.assert_array_equal(found.per_pose[:, whose], compiled.per_pose[:, whose])
    for name in ("per_pose", "ap_rp", "robot_sums"):
        np.testing.assert_allclose(
            getattr(found, name),
            getattr(compiled, name),
            rtol=1e-12,
            atol=1e-12 * largest,
            err_msg=name,
        )
    assert found.group_hist.sum() == compiled.group_hist.sum() == len(poses) * robots * visits
    assert np.abs(found.whole_hist() - compiled.whole_hist()).sum() <= 2


@needs_jax
@pytest.mark.slow
@pytest.mark.parametrize(
    "law", ["normal without limits", ((-1.0, 0.0), (-0.2, 0.3), (0.4, 0.9), (2.0, 1.0))]
)
@pytest.mark.parametrize("visits", [1, 7])
def test_jax_supports_every_distribution(law, visits):
    """JAX returns the compiled kernel's figures for a normal distribution without limits and for a
    user's table, to 1e-12 of the largest error.
    """
    arm = Arm(
        name="slides",
        joints=[
            PrismaticJoint(
                name=axis, axis=axis, limits=(0, 1), encoder={"noise": 3e-3, "noise_law": law}
            )
            for axis in "xyz"
        ],
    )
    poses = sample_poses(arm, 8)
    matrix, plan = screws(state_of(arm, poses.q)), BlockPlan.of(arm, poses, 300, visits, 7, 0.0)
    compiled, found = (
        sample_block(replace(plan, device=device), matrix, 0) for device in ("cpu", "gpu")
    )
    largest = compiled.per_pose[:, kernel.LARGEST].max()
    assert largest > 3e-3
    np.testing.assert_allclose(found.per_pose, compiled.per_pose, rtol=1e-12, atol=1e-12 * largest)


def test_without_jax_one_sentence_names_what_to_install(arm, monkeypatch):
    """A study on a GPU without JAX names the missing extra before it starts."""
    monkeypatch.setattr(importlib.util, "find_spec", lambda _: None)
    with pytest.raises(
        LostmotionError, match=r"JAX, which is not installed\n  pip install 'lostmotion\[gpu\]'"
    ):
        lostmotion.study(arm, 8, 10, 2, device="gpu")


def test_the_command_refuses_with_exit_code_2_and_writes_nothing(tmp_path, monkeypatch):
    """`lostmotion run --device gpu` without JAX prints one message that names the extra, exits with
    code 2 and writes no folder.
    """
    monkeypatch.setitem(sys.modules, "jax", None)
    done = carried_out("run", ARM, "--device", "gpu", cwd=tmp_path)
    assert done.returncode == 2
    assert "pip install 'lostmotion[gpu]'" in done.stderr
    assert "Traceback" not in done.stderr
    assert not list(tmp_path.iterdir())


@needs_jax
def test_a_study_without_a_gpu_does_not_fall_back_to_the_processor(arm):
    """A study for a GPU raises an error where JAX finds the processor alone."""
    import jax

    if jax.default_backend() != "cpu":
        pytest.skip("there is a GPU")
    with pytest.raises(LostmotionError, match="finds no GPU"):
        run(arm, sample_poses(arm, 8), 10, 2, 1, device="gpu")


@needs_jax
def test_a_driver_that_does_not_load_brings_no_traceback(tmp_path):
    """A driver that does not load causes one message, which explains how to see JAX's own log."""
    script = """
import logging, sys
import jax

def broken():
    logging.getLogger("jax._src.xla_bridge").error("plugin", exc_info=RuntimeError("cuInit failed"))
    return "cpu"

jax.default_backend = broken
sys.argv = WORDS
from lostmotion.cli import main
main()
"""
    words = repr(["lostmotion", "run", str(ARM), "--device", "gpu"])
    done = subprocess.run(
        [sys.executable, "-c", script.replace("WORDS", words)],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 2
    assert "cuInit failed" not in done.stderr
    assert "jax.devices()" in done.stderr


def test_an_unknown_device_is_refused(arm):
    """A study rejects any device but processor and GPU, and a GPU for a method without sampling."""
    with pytest.raises(InputError, match="device"):
        run(arm, sample_poses(arm, 8), 10, 2, 1, device="abacus")
    with pytest.raises(InputError, match="without sampling"):
        lostmotion.study(arm, 8, 10, 2, method="analytic", device="gpu")
