"""The command line as a user meets it: what it prints, what it writes, how it refuses."""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from lostmotion.analyses.accuracy.result import Study
from tests.command import carried_out

EXAMPLES = Path(__file__).parents[2] / "examples"
ARM = EXAMPLES / "z-arm.toml"
LIGHT = EXAMPLES / "planar-2r.toml"
QUICK = ("--poses", "16", "--robots", "20", "--visits", "3")


def process(*words, cwd):
    """Run Python in a folder."""
    return subprocess.run(
        [sys.executable, *map(str, words)],
        cwd=cwd,
        capture_output=True,
        text=True,
        check=False,
        env={**os.environ, "COLUMNS": "200"},
    )


AND_NAME_MODULES = """
import sys
from lostmotion.cli import main
sys.argv[0] = 'lostmotion'
try:
    main()
finally:
    print(*sys.modules, file=sys.stderr)
"""


@pytest.fixture(scope="module")
def ran(tmp_path_factory):
    """Run the example once, on two threads, and name the modules that it loaded."""
    folder = tmp_path_factory.mktemp("run")
    words = ("run", LIGHT, *QUICK, "--full", "--threads", "2")
    return folder, process("-c", AND_NAME_MODULES, *words, cwd=folder)


@pytest.fixture(scope="module")
def written(ran):
    """Return the content of each file that it wrote."""
    return {path.name: path.read_bytes() for path in (ran[0] / "planar-2r-accuracy").iterdir()}


def test_run_prints_the_answer_and_writes_three_files(ran, written):
    """Every section an engineer asks for is printed, and the folder holds report, figures and
    arrays, nothing else.
    """
    folder, done = ran
    assert done.returncode == 0, done.stderr
    for title in (
        "Workspace",
        "Position error",
        "ISO 9283",
        "What can be compensated",
        "Which part is to blame",
        "Joints",
        "First order",
    ):
        assert title in done.stdout
    assert sorted(written) == ["arrays.nc", "report.html", "result.json"]
    assert [path.name for path in folder.iterdir()] == ["planar-2r-accuracy"]


def test_writing_results_loads_no_data_of_other_libraries(ran, written):
    """A study writes its arrays without xarray and what that loads: pandas, pint, and dask, which
    is for many machines.
    """
    loaded = set(ran[1].stderr.split())
    assert {"lostmotion", "numpy"} <= loaded
    assert not loaded & {"xarray", "pandas", "pint", "dask", "distributed"}
    assert len(written["arrays.nc"]) > 0


@pytest.mark.usual_counts
def test_two_runs_write_the_same_bytes(ran, written, tmp_path):
    """Same file, version and seed: result.json and arrays.nc are equal byte by byte, on one thread
    or two, in two processes.
    """
    assert ran[1].returncode == 0, ran[1].stderr
    words = (*QUICK, "--threads", "1", "--out", "again", "--quiet")
    done = carried_out("run", LIGHT, *words, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    for file in ("result.json", "arrays.nc", "report.html"):
        assert (tmp_path / "again" / file).read_bytes() == written[file], file


@pytest.mark.usefixtures("written")
def test_an_existing_folder_is_left_alone_without_force(ran, monkeypatch):
    """A second run refuses before it works, exit code 2, and names --force; with --force it
    replaces.
    """
    monkeypatch.setattr(Study, "plots", ())
    folder, _ = ran
    result = folder / "planar-2r-accuracy" / "result.json"
    before = result.read_bytes()
    again = carried_out("run", LIGHT, *QUICK, "--seed", "2", cwd=folder)
    assert again.returncode == 2
    assert "--force" in again.stderr
    assert result.read_bytes() == before
    words = ("--seed", "2", "--force", "--quiet")
    forced = carried_out("run", LIGHT, *QUICK, *words, cwd=folder)
    assert forced.returncode == 0
    assert json.loads(result.read_text())["seed"] == 2


def test_a_file_that_is_read_is_not_replaced_by_the_results(tmp_path):
    """A sized arm lies beside the report of its sizing, measured poses beside their plan: --force
    spares whatever the command reads.
    """
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "result.json").write_text("{}")
    arm, poses = (tmp_path / "out" / name for name in ("sized.toml", "poses.csv"))
    arm.write_text((EXAMPLES / "z-arm.toml").read_text("utf-8"), "utf-8")
    poses.write_text("measured")
    for words in (("study", "out/sized.toml"), ("calibrate", ARM, "--measured", "out/poses.csv")):
        done = carried_out(*words, "--out", "out", "--force", cwd=tmp_path, columns=200)
        assert done.returncode == 2
        assert f"another folder than that of '{words[-1]}', which is read" in done.stderr
    assert arm.exists()
    assert poses.read_text() == "measured"


WRONG = {
    "three mistakes": (
        ARM.read_text()
        + (
            '\n[[joints]]\nname = "E"\ntype = "revolute"\naxis = "y"\nlimits = ["1 deg", "2 m"]\n'
            'gearbocks = "drive"\nmass = "-1 kg"\n'
        ),
        ("limits", "gearbocks", "gearbox", "mass"),
    ),
    "not TOML": ("name = \n", ("wrong.toml:1: column",)),
    "nothing in it": ("", ("name", "joints")),
}


@pytest.mark.parametrize("case", WRONG)
def test_wrong_files_get_one_clear_message(case, tmp_path):
    """Exit code 2, every mistake in one message with file and key, no traceback, nothing
    written.
    """
    text, words = WRONG[case]
    (tmp_path / "wrong.toml").write_text(text, encoding="utf-8")
    done = carried_out("run", "wrong.toml", cwd=tmp_path, columns=200)
    assert done.returncode == 2
    assert "Traceback" not in done.stderr
    assert "wrong.toml" in done.stderr
    for word in words:
        assert word in done.stderr
    assert [path.name for path in tmp_path.iterdir()] == ["wrong.toml"]


def test_a_missing_file_and_a_wrong_option_are_refused(tmp_path):
    """A file that is not there and a count below one: exit code 2 and a sentence."""
    missing = carried_out("run", "nowhere.toml", cwd=tmp_path)
    assert missing.returncode == 2
    assert "nowhere.toml" in missing.stderr
    assert carried_out("run", ARM, "--robots", "0", cwd=tmp_path).returncode == 2
    assert not list(tmp_path.iterdir())


def test_poses_can_come_from_a_file(tmp_path, monkeypatch):
    """A CSV of poses is visited as it stands, and a wrong one is refused."""
    monkeypatch.setattr(Study, "plots", ())
    import lostmotion as package

    arm = package.read(LIGHT)
    names = [joint.name for joint in arm.moving]
    middle = arm.limits.mean(axis=1)
    rows = [
        ",".join(f"{name} [rad]" for name in names),
        *[",".join(f"{value:.6f}" for value in middle)] * 3,
    ]
    (tmp_path / "poses.csv").write_text("\n".join(rows) + "\n", encoding="utf-8")
    words = ("run", LIGHT, "--poses-file", "poses.csv")
    done = carried_out(*words, "--robots", "20", "--visits", "3", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "3 poses (given)" in json.dumps(
        json.loads((tmp_path / "planar-2r-accuracy" / "result.json").read_text())
    )
    (tmp_path / "poses.csv").write_text(
        "\n".join(rows).replace("rad", "kg") + "\n", encoding="utf-8"
    )
    assert carried_out(*words, "--force", cwd=tmp_path).returncode == 2


def test_the_schema_is_printed_as_json(tmp_path):
    """`lostmotion schema` prints a JSON Schema with the joints in it."""
    done = carried_out("schema", cwd=tmp_path)
    assert done.returncode == 0
    assert "joints" in json.loads(done.stdout)["properties"]


@pytest.mark.parametrize(
    ("words", "key", "found", "example"),
    [
        (["study", ARM, "--quiet", "--json"], "--json, --quiet", "'2 of them'", "--json"),
        (["study", ARM, "--out", ""], "--out", "''", "--out results"),
        (["study", ARM, "--until", "", "--out", "x"], "--until", "''", '--until "1 %"'),
        (["export", "c", ARM], "--out", "nothing", "--out model"),
        (["export", "fmu", ARM], "--out", "nothing", '--out "arm.fmu"'),
    ],
    ids=["two ways to print", "no folder", "no precision", "no folder for C", "no file for an FMU"],
)
def test_options_that_contradict_or_lack_a_value_are_refused(tmp_path, words, key, found, example):
    """Two ways to print, an option with an empty text and an export without a place each give one
    message with an example, and write nothing.
    """
    done = carried_out(*words, cwd=tmp_path, columns=200)
    assert done.returncode == 2
    lines = [line.strip() for line in done.stderr.splitlines()]
    assert lines[:3] == ["lostmotion: 1 mistake", key, f"found     {found}"]
    assert f"example   {example}" in lines
    assert not list(tmp_path.iterdir())


def test_importing_the_package_loads_no_heavy_library():
    """`import lostmotion` loads neither NumPy nor Numba nor matplotlib: the start stays fast."""
    code = (
        "import sys, lostmotion; print([m for m in ('numpy', 'numba', 'scipy', 'pydantic', "
        "'matplotlib', 'xarray', 'rich') if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_reading_an_arm_compiles_nothing():
    """Parts and formats load neither Numba nor matplotlib nor xarray, though parts are full of
    laws, nor pint for the units of most files.
    """
    code = (
        "import sys; from pathlib import Path; from lostmotion.io import read; "
        f"read(Path({str(EXAMPLES / 'z-arm.toml')!r})); "
        "print([m for m in ('numba', 'matplotlib', 'xarray', 'scipy.stats', 'pint') "
        "if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_the_version_is_printed(tmp_path):
    """`lostmotion --version` prints the package's version."""
    import lostmotion as package

    done = process("-m", "lostmotion", "--version", cwd=tmp_path)
    assert done.stdout.strip() == f"lostmotion {package.__version__}"


AND_SAY_WHEN = """
import sys
from lostmotion.cli import main
from lostmotion.propagation.montecarlo import montecarlo
batches = montecarlo._batches
def started(*given):
    print('started', flush=True)
    return batches(*given)
montecarlo._batches = started
sys.argv[0] = 'lostmotion'
main()
"""


def test_a_stopped_run_leaves_nothing_behind(tmp_path):
    """Ctrl-C in mid-run: exit code 130, one word about it, no traceback, no file."""
    command = [sys.executable, "-c", AND_SAY_WHEN, "run", str(ARM), "--poses", "16384"]
    with subprocess.Popen(
        command, cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as process:
        assert process.stdout is not None
        assert process.stdout.readline().strip() == "started"
        time.sleep(0.2)
        process.send_signal(signal.SIGINT)
        _, told = process.communicate(timeout=60)
    assert process.returncode == 130
    assert "stopped" in told
    assert "nothing was written" in told
    assert "Traceback" not in told
    assert not list(tmp_path.iterdir())
