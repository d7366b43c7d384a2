"""Too little memory, and libraries that cannot be loaded: one clear message, exit code 2, and
nothing written.
"""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from lostmotion.analyses.accuracy.result import Study
from lostmotion.analyses.result import Result
from lostmotion.cli import answering
from lostmotion.cli.app import _carried_out
from lostmotion.cli.loading import is_of_loading, is_of_memory, not_loaded

EXAMPLE = Path(__file__).parents[2] / "examples" / "planar-2r.toml"
LIMITED = (
    "import resource, sys; resource.setrlimit(resource.RLIMIT_AS, ({0}, {0})); from "
    "lostmotion.cli import main; sys.argv[0] = 'lostmotion'; main()"
)


def caused(*texts: str) -> ImportError:
    """Return an error that followed from others, the first text last."""
    error: ImportError | None = None
    for text in reversed(texts):
        later = ImportError(text)
        later.__cause__ = error
        error = later
    assert error is not None
    return error


@pytest.mark.parametrize(
    ("error", "message"),
    [
        (
            caused(
                "\n\nIMPORTANT: PLEASE READ THIS",
                "/a b/lib.so.0: failed to map segment from shared object",
            ),
            "not enough memory to load lib.so.0",
        ),
        (
            ImportError("libopenblas-1.so: cannot allocate memory in static TLS block"),
            "not enough memory to load libopenblas-1.so",
        ),
        (
            ImportError("DLL load failed while importing x: The paging file is too small"),
            "not enough memory to load a package",
        ),
        (RuntimeError("can't start new thread"), "not enough memory to load a package"),
        (
            caused("head", "x.so: undefined symbol: y"),
            (
                "a package cannot be loaded: x.so: undefined symbol: y\n  free memory, or install "
                "it again"
            ),
        ),
        (
            ModuleNotFoundError("No module named 'numpy'"),
            (
                "a package cannot be loaded: No module named 'numpy'\n  free memory, or install "
                "it again"
            ),
        ),
    ],
)
def test_the_first_cause_is_named_in_one_line(error, message):
    """Not the last one, which NumPy for one writes over a whole page."""
    assert not_loaded(error).startswith(message)
    assert is_of_memory(error) == message.startswith("not enough")


def test_other_errors_are_no_matter_of_loading():
    """A mistake of this package keeps its traceback."""
    assert not is_of_loading(RuntimeError("a mistake"))
    assert not is_of_memory(RuntimeError("a mistake"))
    assert not is_of_loading(OSError(2, "No such file or directory", "arm.toml"))


IGNORED = """
import sys
from lostmotion.error_model.sobol import Sobol
from lostmotion.cli import main
drawn = Sobol.columns
class Ignored:
    def __del__(self):
        raise MemoryError
def random(*given, **named):
    Ignored()
    return drawn(*given, **named)
Sobol.columns = random
main()
"""


def test_memory_that_runs_out_unnoticed_is_no_result(tmp_path):
    """Where a library cannot raise the error and continues, nothing is written of what it then
    computes.
    """
    out = tmp_path / "out"
    words = [
        "study",
        str(EXAMPLE),
        "--poses",
        "16",
        "--robots",
        "8",
        "--visits",
        "2",
        "--quiet",
        "--out",
        str(out),
    ]
    done = subprocess.run(
        [sys.executable, "-c", IGNORED, *words],
        capture_output=True,
        text=True,
        check=False,
        timeout=300,
    )
    assert done.returncode == 2
    assert "not enough memory" in done.stderr
    assert "Traceback" not in done.stderr
    assert not out.exists()


@pytest.mark.skipif(sys.platform != "linux", reason="limits of the address space as on Linux")
@pytest.mark.parametrize("megabytes", [60, 250, 450, 999])
def test_too_little_address_space_is_one_message_at_once(tmp_path, megabytes):
    """Before libraries are loaded that would end the process themselves (OpenBLAS, LLVM), or wait
    for memory for ever, as OpenBLAS does at 450 MB.
    """
    out = tmp_path / "out"
    done = subprocess.run(
        [
            sys.executable,
            "-c",
            LIMITED.format(megabytes * 10**6),
            *("study", str(EXAMPLE), "--quiet", "--out", str(out)),
        ],
        capture_output=True,
        text=True,
        check=False,
        timeout=60,
    )
    assert done.returncode == 2
    assert done.stderr.startswith(f"lostmotion: not enough memory: {megabytes} MB")
    assert len(done.stderr.splitlines()) == 2
    assert not out.exists()


@pytest.mark.parametrize(
    "error", [MemoryError(), ImportError("x.so: failed to map segment from shared object")]
)
def test_memory_that_ends_after_the_results_are_written_leaves_them(tmp_path, monkeypatch, error):
    """What cannot be printed any more is written, and the message says so."""

    def fails(*_given, **_named):
        raise error

    out = tmp_path / "out"
    monkeypatch.setattr(answering, "_show_answers", fails)
    monkeypatch.setattr(Study, "plots", ())
    monkeypatch.setattr(
        sys,
        "argv",
        [
            *("lostmotion", "study", str(EXAMPLE), "--poses", "16", "--robots", "8"),
            *("--visits", "2", "--quiet", "--out", str(out)),
        ],
    )
    assert _carried_out() == (1, "not enough memory to print all of it; the results are written")
    assert (out / "result.json").exists()


def test_the_first_screen_is_printed_before_the_report_is_drawn(tmp_path, monkeypatch, capsys):
    """What the user asked is on the screen while the report is drawn."""
    seen = []

    def drawn(*_given, **_named):
        seen.append(capsys.readouterr().out)
        raise MemoryError

    monkeypatch.setattr(Result, "report", drawn)
    words = ["study", str(EXAMPLE), "--poses", "16", "--robots", "8", "--visits", "2"]
    monkeypatch.setattr(sys, "argv", ["lostmotion", *words, "--out", str(tmp_path / "out")])
    code, message = _carried_out()
    assert code == 2
    assert "nothing was written" in message
    assert "95 % of positions within" in seen[0]
