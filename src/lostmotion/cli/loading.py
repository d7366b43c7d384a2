"""The message for a package that cannot be loaded, most often for want of memory. It needs no
package itself.
"""

from __future__ import annotations

import re
from contextlib import suppress
from typing import Final

# What loaders, threads and allocators report where memory runs out, on Linux, macOS and Windows.
_OF_MEMORY: Final = re.compile(
    (
        "failed to map segment|cannot allocate|cannot create shared object|can't start new "
        "thread|bad_alloc|paging file"
    ),
    re.IGNORECASE,
)
# Address space that a command takes with its libraries on two threads, bytes.
_TAKEN: Final = 1_000_000_000


def is_of_memory(error: BaseException) -> bool:
    """Return whether an error follows from too little memory."""
    return any(
        _OF_MEMORY.search(str(each)) or isinstance(each, MemoryError) for each in _causes(error)
    )


def is_of_loading(error: BaseException) -> bool:
    """Return whether an error follows from a library that cannot be loaded."""
    return any(
        isinstance(each, ImportError) or "shared object" in str(each) for each in _causes(error)
    )


def not_loaded(error: BaseException) -> str:
    """Return the message for an error while a package is loaded."""
    text = next(
        (line.strip() for line in str(_causes(error)[-1]).splitlines() if line.strip()),
        type(error).__name__,
    )
    library = re.match(r"(?:.*[/\\])?(\S+\.(?:so|dylib|dll|pyd)[.\d]*):", text)
    if is_of_memory(error):
        return (
            f"not enough memory to load {library[1] if library else 'a package'}; nothing was "
            "written"
        )
    hint = "free memory, or install it again, for example: pip install --force-reinstall lostmotion"
    return f"a package cannot be loaded: {text.partition('. ')[0]}\n  {hint}"


def too_little_space() -> str:
    """Return the message for a limit of the address space under which libraries do not load; empty
    without one. OpenBLAS and LLVM would end the process, or wait for memory for ever.
    """
    with suppress(ImportError):  # there is none on Windows
        import resource

        most = resource.getrlimit(resource.RLIMIT_AS)[0]
        if most != resource.RLIM_INFINITY and most < _TAKEN:
            return (
                f"not enough memory: {most / 1e6:.0f} MB of address space are allowed, and a "
                f"command takes {_TAKEN / 1e6:.0f} MB; nothing was written\n  raise the limit, for "
                "example: ulimit -v unlimited"
            )
    return ""


def _causes(error: BaseException) -> list[BaseException]:
    """Return an error and those that it followed from, the first one last."""
    found = [error]
    while (
        cause := found[-1].__cause__ or found[-1].__context__
    ) is not None and cause not in found:
        found.append(cause)
    return found
