"""The package for ROS 2: what it declares belongs to the arm, and its source compiles."""

from __future__ import annotations

import ast
import re
import shutil
import subprocess
from pathlib import Path

import pytest
from lxml import etree

import lostmotion
from lostmotion.io.ros2_package import package_name
from tests.parts.random_arms import EXAMPLES

yaml = pytest.importorskip("yaml")
HEADERS = Path(__file__).with_name("ros2_headers")


@pytest.fixture(scope="module")
def package(tmp_path_factory):
    """Return the folder of a package for the z-arm, and the arm."""
    folder, arm = tmp_path_factory.mktemp("ros2"), lostmotion.read(EXAMPLES / "z-arm.toml")
    lostmotion.export_ros2(arm, out=folder)
    return folder, arm


def test_the_package_has_names_and_limits_of_the_joints(package):
    """YAML, XML and the launch file can be read, and name one package and the joints in order."""
    folder, arm = package
    config = yaml.safe_load((folder / "config/controllers.yaml").read_text(encoding="utf-8"))
    names = [joint.name for joint in arm.driven]
    assert config["compensation"]["ros__parameters"]["joints"] == names
    trajectory = config["trajectory"]["ros__parameters"]
    assert trajectory["joints"] == names
    assert trajectory["command_joints"] == [f"compensation/{name}" for name in names]
    limits = yaml.safe_load((folder / "config/joint_limits.yaml").read_text(encoding="utf-8"))
    for joint in arm.driven:
        own = limits["joint_limits"][joint.name]
        assert (own["min_position"], own["max_position"]) == pytest.approx(joint.limits, abs=0)
    name = etree.parse(folder / "package.xml").getroot().findtext("name")
    assert name == "z_arm_compensation"
    # the spawner reads a controller's type in the section of that controller alone
    types = config["compensation"]["ros__parameters"]["type"]
    assert trajectory["type"] == "joint_trajectory_controller/JointTrajectoryController"
    assert set(config) == {"compensation", "trajectory"}
    plugin = etree.parse(folder / "plugin.xml").getroot()
    assert plugin.attrib["path"] == name
    assert plugin[0].attrib["name"] == types == f"{name}/CompensationController"
    launch = (folder / "launch/compensation.launch.py").read_text(encoding="utf-8")
    ast.parse(launch)
    assert f'get_package_share_directory("{name}")' in launch
    assert not any("@" in re.sub(r"\S+@\S+\.\w+", "", text) for text in texts(folder))


def texts(folder):
    """Return the texts of the package's own files."""
    own = (path for path in folder.rglob("*") if path.is_file() and "model" not in path.parts)
    return [path.read_text(encoding="utf-8") for path in own]


@pytest.mark.parametrize(
    ("arm", "name"),
    [
        ("Z-arm", "z_arm_compensation"),
        ("7 axes!", "arm_7_axes_compensation"),
        ("ü", "arm_compensation"),
    ],
)
def test_a_package_name_is_one_that_ros_accepts(arm, name):
    """Lower-case letters, digits and single underscores, with a letter first."""
    assert package_name(arm) == name


@pytest.mark.skipif(not shutil.which("g++"), reason="g++ is not installed")
def test_the_controller_compiles(package, tmp_path):
    """Against stand-ins for the headers of ROS 2, every function of the controller, without a
    warning.
    """
    folder, _ = package
    source = folder / "src/compensation_controller.cpp"
    included = re.findall(r'#include "([^"]+)"', source.read_text(encoding="utf-8"))
    for name in included:
        if name != "lm_core.h":
            (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
            (tmp_path / name).write_text('#include "all.hpp"\n', encoding="utf-8")
    folders = [f"-I{each}" for each in (tmp_path, HEADERS, folder / "model/src")]
    words = ["g++", "-std=c++17", "-Wall", "-Wextra", "-Werror", "-c", *folders, str(source)]
    subprocess.run([*words, "-o", str(tmp_path / "out.o")], check=True)
