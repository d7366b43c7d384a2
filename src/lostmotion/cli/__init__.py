"""The command line: one command per question, generated from its signature."""

import os

from lostmotion.cli.loading import not_loaded

# Read when NumPy is loaded. The matrices are small: threads of the linear algebra cost more than
# they save, and with their number the last digits would change.
for _library in ("OPENBLAS", "MKL"):
    os.environ.setdefault(f"{_library}_NUM_THREADS", "1")

try:
    from lostmotion.cli.app import app, main
except (ImportError, MemoryError, OSError) as error:
    _message = not_loaded(error)

    def main() -> None:
        """Report that the command line cannot be loaded."""
        import sys

        sys.stderr.write(f"lostmotion: {_message}\n")
        sys.exit(2)


__all__ = ["app", "main"]
