"""The command line in the process of the tests: the same as in one of its own, without the two
seconds that it takes to load the libraries. `tests/cli` starts processes.
"""

import contextlib
import io
import os
import subprocess
import sys
from unittest import mock

from lostmotion.cli.app import _carried_out
from lostmotion.cli.terminal import say


def carried_out(*words, cwd, columns=80):
    """Return exit code and output of `lostmotion WORDS` in a folder, on a terminal so wide."""
    command = ["lostmotion", *map(str, words)]
    out, err = io.StringIO(), io.StringIO()
    with (
        contextlib.chdir(cwd),
        contextlib.redirect_stdout(out),
        contextlib.redirect_stderr(err),
        mock.patch.object(sys, "argv", command),
        mock.patch.dict(os.environ, {"COLUMNS": str(columns)}),
    ):
        code, message = _carried_out()
        if message:
            say(f"lostmotion: {message}", error=True)
    return subprocess.CompletedProcess(command, code, out.getvalue(), err.getvalue())


def carried_out_by_process(*words, cwd):
    """Return the same of a process of its own, which hashes texts by another seed."""
    return subprocess.run(
        [sys.executable, "-m", "lostmotion", *map(str, words)],
        cwd=cwd,
        capture_output=True,
        text=True,
        check=False,
    )
