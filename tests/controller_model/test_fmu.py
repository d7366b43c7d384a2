"""FMUs of an arm, as other tools read and run them."""

from __future__ import annotations

import math
import shutil
import zipfile
from typing import TYPE_CHECKING

import numpy as np
import pytest

import lostmotion
from tests.parts.random_arms import EXAMPLES

if TYPE_CHECKING:
    from pathlib import Path

# A row of docs/validation.md each: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "FMUs of a model, FMI 2.0 and 3.0",
        "FMPy 0.3.32: schema, references, units; run at random poses beside the Python model",
        "no fault found; 1e-10; the same bytes each time",
    ),
)

fmpy = pytest.importorskip("fmpy")
pytestmark = pytest.mark.skipif(
    not any(shutil.which(name) for name in ("cc", "gcc", "clang")), reason="no C compiler"
)
VERSIONS = ("2.0", "3.0")


@pytest.fixture(scope="module", params=VERSIONS)
def exported(request, tmp_path_factory) -> tuple[str, Path]:
    """Return the version and the FMU of the UR5e."""
    path = tmp_path_factory.mktemp("fmu") / "ur5e.fmu"
    lostmotion.export_fmu(EXAMPLES / "ur5e.urdf", out=path, version=request.param)
    return request.param, path


class Running:
    """An FMU that runs, with variables by name."""

    def __init__(self, path: Path) -> None:
        """Unpack and initialise it."""
        self.description = fmpy.read_model_description(str(path))
        self.unpacked = fmpy.extract(str(path))
        self.references = {
            each.name: each.valueReference for each in self.description.modelVariables
        }
        arguments = {
            "guid": self.description.guid,
            "unzipDirectory": self.unpacked,
            "modelIdentifier": self.description.coSimulation.modelIdentifier,
        }
        is_second = self.description.fmiVersion == "2.0"
        self.fmu = (
            fmpy.fmi2.FMU2Slave(**arguments) if is_second else fmpy.fmi3.FMU3Slave(**arguments)
        )
        self.fmu.instantiate()
        if is_second:
            self.fmu.setupExperiment(startTime=0.0)
        self.fmu.enterInitializationMode()
        self.fmu.exitInitializationMode()
        self.get, self.put = (
            (self.fmu.getReal, self.fmu.setReal)
            if is_second
            else (self.fmu.getFloat64, self.fmu.setFloat64)
        )
        self.get_integer = self.fmu.getInteger if is_second else self.fmu.getInt32

    def set(self, **values: float) -> None:
        """Set variables."""
        self.put([self.references[name] for name in values], list(values.values()))

    def values(self, *names: str) -> np.ndarray:
        """Return variables."""
        return np.array(self.get([self.references[name] for name in names]))

    def status(self) -> int:
        """Return the status of the model."""
        return int(self.get_integer([self.references["status"]])[0])

    def close(self) -> None:
        """End it and remove its files."""
        self.fmu.terminate()
        self.fmu.freeInstance()
        shutil.rmtree(self.unpacked)


@pytest.fixture
def running(exported):
    """Return a running FMU."""
    out = Running(exported[1])
    yield out
    out.close()


def joints() -> list[str]:
    """Return the names of the joints."""
    return [joint.name for joint in lostmotion.read(EXAMPLES / "ur5e.urdf").moving]


def test_fmpy_finds_no_fault(exported):
    """FMPy checks the description against the standard's schema, and names, references, units and
    structure.
    """
    version, path = exported
    from fmpy.validation import validate_fmu

    assert validate_fmu(str(path)) == []
    description = fmpy.read_model_description(str(path))
    assert description.fmiVersion == version
    with zipfile.ZipFile(path) as archive:
        names = set(archive.namelist())
    assert {
        "modelDescription.xml",
        "sources/lm_core.c",
        "sources/lm_model.c",
        "documentation/README.md",
    } <= names
    assert any(name.startswith("binaries/") for name in names)


def test_an_fmu_computes_what_python_computes(running):
    """Prediction and corrected command at random poses, to rounding; outputs follow the inputs at
    once, without a step.
    """
    model, names = lostmotion.controller(EXAMPLES / "ur5e.urdf"), joints()
    poses = np.random.default_rng(1).uniform(-2.5, 2.5, size=(50, len(names)))
    found, sent = model.predict(poses), model.compensate(poses)
    for k, q in enumerate(poses):
        running.set(**{f"q.{name}": value for name, value in zip(names, q, strict=True)})
        assert running.status() == sent.status[k]
        np.testing.assert_allclose(
            running.values("point.x", "point.y", "point.z"), found.point[k], atol=1e-12
        )
        moved = running.values(*(f"expected.displacement.{axis}" for axis in "xyz"))
        np.testing.assert_allclose(moved, found.screw[k, 3:], rtol=1e-10, atol=1e-14)
        np.testing.assert_allclose(running.values("length95"), found.length95[k], rtol=1e-10)
        np.testing.assert_allclose(
            running.values(*(f"torque.{name}" for name in names)),
            found.torques[k],
            rtol=1e-10,
            atol=1e-10,
        )
        np.testing.assert_allclose(
            running.values(*(f"command.{name}" for name in names)), sent.command[k], atol=1e-12
        )
        np.testing.assert_allclose(
            running.values(*(f"left.displacement.{axis}" for axis in "xyz")),
            sent.left[k, 3:],
            rtol=1e-8,
            atol=1e-14,
        )


def test_payload_and_gravity_can_be_changed(running):
    """They are parameters that may be tuned while it runs."""
    model, names = lostmotion.controller(EXAMPLES / "ur5e.urdf"), joints()
    q = np.linspace(-1, 1, len(names))
    running.set(**{f"q.{name}": value for name, value in zip(names, q, strict=True)})
    running.set(
        **{
            "payload.mass": 1.5,
            "payload.centre.z": 0.05,
            "gravity.x": 1.0,
            "gravity.z": -9.0,
            f"side.{names[1]}": 1.0,
        }
    )
    load, gravity, side = (
        model.tables.load.copy(),
        model.tables.gravity.copy(),
        np.zeros(len(names)),
    )
    load[[0, 3]], gravity[[0, 2]], side[1] = (1.5, 0.05), (1.0, -9.0), 1.0
    found = model.predict(q, load, gravity, side)
    np.testing.assert_allclose(running.values("length95"), found.length95, rtol=1e-10)


def test_damping_and_the_largest_step_are_parameters(running):
    """They change the command as in Python; joint values start at zero or within their range."""
    model, names = lostmotion.controller(EXAMPLES / "ur5e.urdf"), joints()
    q = np.linspace(-1, 1, len(names))
    running.set(**{f"q.{name}": value for name, value in zip(names, q, strict=True)})
    running.set(damping=1e-2, largest_step=2e-4)
    sent = model.compensate(q, damping=1e-2, largest_step=2e-4).command[0]
    np.testing.assert_allclose(
        running.values(*(f"command.{name}" for name in names)), sent, atol=1e-12
    )
    assert np.abs(sent - model.compensate(q).command[0]).max() > 1e-6
    running.set(damping=0.0)
    assert running.status() == 1


@pytest.mark.parametrize(("value", "status"), [(math.nan, 1), (math.inf, 1), (100.0, 2)])
def test_a_bad_input_gives_a_status_and_zeros(running, value, status):
    """The step warns, and no older result remains."""
    names = joints()
    assert running.values("length95")[0] > 0
    running.set(**{f"q.{names[0]}": value})
    assert running.status() == status
    assert not running.values("length95", "point.z", f"command.{names[0]}").any()
    running.set(**{f"q.{names[0]}": 0.1})
    assert running.status() == 0
    assert running.values("length95")[0] > 0


def test_the_same_arm_gives_the_same_bytes(exported, tmp_path):
    """No clock and no folder in the zip or in its library."""
    version, path = exported
    with zipfile.ZipFile(path) as archive:
        assert {each.date_time for each in archive.infolist()} == {(1980, 1, 1, 0, 0, 0)}
        assert archive.namelist() == sorted(archive.namelist())
    again = tmp_path / "again.fmu"
    lostmotion.export_fmu(EXAMPLES / "ur5e.urdf", out=again, version=version)
    assert again.read_bytes() == path.read_bytes()


@pytest.mark.parametrize("exported", VERSIONS[:1], indirect=True)
def test_a_file_is_not_replaced_unasked(exported, tmp_path):
    """With `force` it is; another arm has another token."""
    arm = EXAMPLES / "planar-2r.toml"
    path = tmp_path / "there.fmu"
    path.write_text("mine", encoding="utf-8")
    with pytest.raises(lostmotion.errors.OutputExistsError, match="--force"):
        lostmotion.export_fmu(arm, out=path)
    assert path.read_text(encoding="utf-8") == "mine"
    lostmotion.export_fmu(arm, out=path, force=True)
    assert zipfile.is_zipfile(path)
    tokens = {fmpy.read_model_description(str(each)).guid for each in (exported[1], path)}
    assert len(tokens) == 2
