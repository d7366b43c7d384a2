"""Scrambled Sobol sequences."""

import subprocess
import sys

import numpy as np
import pytest
from scipy.stats import qmc

from lostmotion.error_model.draws import key, sobol
from lostmotion.error_model.sobol import BITS
from lostmotion.mechanism.arm import MOST_JOINTS


@pytest.mark.parametrize("columns", [1, 2, 6, 17, MOST_JOINTS])
@pytest.mark.parametrize("power", [0, 1, 8])
def test_a_sequence_is_that_of_scipy(columns, power):
    """Bit for bit, in every dimension: the same poses whichever library draws them."""
    name = f"poses.sobol.{power}"
    generator = np.random.Generator(np.random.Philox(seed=key(3, name)))
    expected = qmc.Sobol(columns, scramble=True, rng=generator, bits=BITS).random_base2(power)
    np.testing.assert_array_equal(sobol(3, name, columns).points(power), expected)


def test_no_arm_has_more_joints_than_dimensions():
    """More dimensions would need further direction numbers."""
    with pytest.raises(ValueError, match="65 dimensions"):
        sobol(1, "any", MOST_JOINTS + 1)


def test_a_stretch_is_cut_from_the_sequence():
    """Any of its points are found without those before."""
    sequence = sobol(1, "any", 5)
    np.testing.assert_array_equal(sequence.stretch(300, 900), sequence.points(10)[300:900])


def test_every_interval_of_a_binary_grid_has_one_point():
    """The definition of a (0, m, 1)-net: in each coordinate, 2^m points are one in each of as many
    intervals.
    """
    points = sobol(2, "any", MOST_JOINTS).points(9)
    assert (np.sort(np.floor(points * 512), axis=0) == np.arange(512)[:, None]).all()


UNUSED = ("scipy.stats", "pandas", "xarray", "matplotlib")


def test_poses_are_chosen_without_heavy_libraries():
    """Whoever reads an arm and chooses its poses loads none of what only reports need."""
    code = (
        "import sys; from lostmotion.analyses.arguments import chosen_poses; "
        "from lostmotion.error_model.poses import sample_poses; import lostmotion; "
        "sample_poses(lostmotion.read('examples/z-arm.toml'), 64); "
        f"print([each for each in {UNUSED} if each in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
