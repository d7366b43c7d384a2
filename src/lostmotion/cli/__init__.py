"""The command line: one command per question, generated from its signature."""

import os

# Read when NumPy is loaded. The matrices are small: threads of the linear algebra cost more than they save, and with their number the last digits
# would change.
for _library in ("OPENBLAS", "MKL"):
    os.environ.setdefault(f"{_library}_NUM_THREADS", "1")

from lostmotion.cli.app import app, main  # noqa: E402

__all__ = ["app", "main"]
