"""The folder that results go into: written whole or not at all, and nobody else's files touched."""

from __future__ import annotations

import errno
import os
import re
import secrets
import stat
import tempfile
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Final

from lostmotion.errors import LostmotionError, OutputExistsError

if TYPE_CHECKING:
    from collections.abc import Mapping

# AT_FDCWD of Linux; RENAME_EXCHANGE of Linux and RENAME_SWAP of macOS, which are the same number.
_HERE: Final = -100
_SWAP: Final = 2
# So much of a folder's name goes into the names of those that stand beside it for a moment.
_LONGEST_BESIDE: Final = 60
# Fields of finite elements.
_FIELDS: Final = ("planet.vtu", "ring.vtu", "first-stage-planet.vtu", "first-stage-ring.vtu")
# Of a robot that was measured. Users have files of such names too: ours lie beside a report.
_OF_ROBOT: Final = ("robot.toml", "joints.csv", "calibrated.urdf", "mdh.csv", "poses.csv")
# Whatever a report is about, its folder holds some of these and nothing else.
FILES: Final = (
    *("report.html", "result.json", "arrays.nc", "profile.dxf", "sized.toml"),
    *_FIELDS,
    *_OF_ROBOT,
)
_REPORT: Final = ("report.html", "result.json")
# Folders within it, and the suffixes of the files there.
FOLDERS: Final = {"figures": (".svg", ".pdf", ".png"), "tables": (".csv", ".tex")}


def write_whole(contents: Mapping[str, bytes], out: str | Path, *, force: bool = False) -> Path:
    """Write these contents, by name out of `FILES` or within `FOLDERS`, into the folder `out`,
    whole or not at all, and return the folder.

    Missing parents are made. With `force` an earlier output folder is replaced, once the new one is
    complete.
    Raises OutputExistsError as `refuse_existing`, LostmotionError where the folder cannot be
    written; then nothing is left behind.
    """
    target = refuse_existing(out, force=force)
    made: list[Path] = []
    try:
        for parent in reversed([parent for parent in target.parents if not parent.exists()]):
            parent.mkdir()
            made.append(parent)
        _place(contents, target, force=force)
    except BaseException as error:
        for parent in reversed(made):
            _remove_if_empty(parent)
        if isinstance(error, OSError):
            raise LostmotionError(
                f"'{target}' could not be written: {error.strerror or error}\n  nothing was "
                "left behind; name a folder that can be written with --out"
            ) from error
        raise
    return target


def refuse_existing(out: str | Path, *, force: bool) -> Path:
    """Return the folder for results as an absolute path.

    Raises OutputExistsError where something is there already: a file or a link always, a folder
    unless `force` is set and it holds only our files; LostmotionError where no folder can be made
    there, so that nobody works for results that then have no place.
    """
    target = Path(out)
    target = target.absolute() if target.name not in {"", ".."} else target.resolve()
    _put_back(target)
    try:
        kind = target.lstat().st_mode
    except (FileNotFoundError, NotADirectoryError):
        _try_beside(target)
        return target
    except OSError as error:
        raise LostmotionError(f"'{target}' cannot be read: {error.strerror}") from error
    if stat.S_ISLNK(kind):
        raise OutputExistsError(
            f"'{target}' is a symbolic link, which is never replaced\n  name the folder "
            "itself, or another one, with --out"
        )
    if not stat.S_ISDIR(kind):
        raise OutputExistsError(
            f"'{target}' is a file, and results go into a folder\n  name another folder with --out"
        )
    strangers = _strangers(target)
    if strangers:
        more = f" and {len(strangers) - 3} more" if len(strangers) > 3 else ""  # noqa: PLR2004 - enough to recognise the folder
        names = ", ".join(repr(name) for name in strangers[:3]) + more
        raise OutputExistsError(
            f"'{target}' exists and holds files that are not ours: {names}\n  it is left "
            "alone, even with --force; name another folder with --out"
        )
    if target.resolve() == Path.cwd():
        raise OutputExistsError(
            f"'{target}' is the folder you stand in, which is never replaced\n  name another "
            "folder with --out"
        )
    if not force:
        raise OutputExistsError(
            f"'{target}' exists\n  replace it with --force (force=True in Python), or name "
            "another folder with --out"
        )
    return target


def write_file(content: bytes, out: Path, *, force: bool) -> Path:
    """Write one file that is the whole result, with missing parents, and return its path.

    Raises OutputExistsError where it exists and `force` is not set, LostmotionError where it cannot
    be written.
    """
    if out.exists() and not force:
        raise OutputExistsError(
            f"'{out}' exists\n  replace it with --force (force=True in Python), or name "
            "another file with --out"
        )
    try:
        out.parent.mkdir(parents=True, exist_ok=True)
        out.write_bytes(content)
    except OSError as error:
        raise LostmotionError(
            f"'{out}' could not be written: {error.strerror or error}\n  name a place that can "
            "be written with --out"
        ) from error
    return out


def _try_beside(target: Path) -> None:
    """Make a folder where the results would go, and take it away: permissions alone do not show
    whether that works.
    """
    parent = next(parent for parent in target.parents if parent.exists())
    try:
        with tempfile.TemporaryDirectory(prefix=".lostmotion-", dir=parent):
            pass
    except OSError as error:
        raise LostmotionError(
            f"'{target}' could not be written: {error.strerror or error}\n  nothing was left "
            "behind; name a folder that can be written with --out"
        ) from error


def _strangers(folder: Path) -> list[str]:
    """Name the entries of a folder that we did not write."""
    with os.scandir(folder) as entries:
        found = {entry.name: _is_ours(entry) for entry in entries}
    reported = not found.keys().isdisjoint(_REPORT)
    return sorted(
        name for name, ours in found.items() if not ours or (name in _OF_ROBOT and not reported)
    )


def _is_ours(entry: os.DirEntry[str]) -> bool:
    """Return whether we write such an entry: a file of a known name, or a folder of figures or
    tables with nothing else in it.
    """
    if entry.name in FOLDERS and entry.is_dir(follow_symlinks=False):
        with os.scandir(entry) as within:
            return all(
                each.is_file(follow_symlinks=False) and each.name.endswith(FOLDERS[entry.name])
                for each in within
            )
    return entry.name in FILES and entry.is_file(follow_symlinks=False)


def _place(contents: Mapping[str, bytes], target: Path, *, force: bool) -> None:
    """Write a new folder beside the target and put it in its place; the old one goes last. Killed
    at any moment, the old or the new one stands.
    """
    new, old = (_beside(target, secrets.token_hex(4), state) for state in ("new", "old"))
    new.mkdir()
    try:
        for name, content in contents.items():
            (new / name).parent.mkdir(exist_ok=True)
            (new / name).write_bytes(content)
            to_disk(new / name)
        to_disk(new)  # or a renamed folder could be empty after the machine has lost its power
        refuse_existing(target, force=force)  # it may have come into being meanwhile
        if not target.exists():
            new.rename(target)
        elif exchange(new, target):
            new, old = old, new
        else:
            _swap(new, old, target)
    except BaseException:
        _remove(new)
        raise
    try:
        _remove(old)
    except (OSError, MemoryError) as error:
        raise LostmotionError(
            f"'{target}' is written, but the earlier folder could not be removed: '{old}' "
            f"({_reason(error)})"
        ) from error
    try:
        to_disk(target.parent)
    except (OSError, MemoryError) as error:
        raise LostmotionError(
            f"'{target}' is written, but the disk did not confirm it: {_reason(error)}"
        ) from error


def _reason(error: OSError | MemoryError) -> str:
    return "not enough memory" if isinstance(error, MemoryError) else str(error.strerror or error)


def _beside(target: Path, token: str, state: str) -> Path:
    return target.with_name(f".{target.name[:_LONGEST_BESIDE]}.{token}.{state}")


def exchange(one: Path, other: Path) -> bool:
    """Exchange two folders in one step, so that none is ever missing (renameat2 of Linux,
    renamex_np of macOS). False where the system cannot.
    """
    import ctypes

    try:
        system = ctypes.CDLL(None, use_errno=True)
        names = os.fsencode(one), os.fsencode(other)
        if hasattr(system, "renamex_np"):
            return bool(system.renamex_np(*names, ctypes.c_uint(_SWAP)) == 0)
        return bool(system.renameat2(_HERE, names[0], _HERE, names[1], ctypes.c_uint(_SWAP)) == 0)
    except (OSError, TypeError, AttributeError):
        # no such library or function: Windows, older systems
        return False


def _swap(new: Path, old: Path, target: Path) -> None:
    """Put the new folder in the old one's place by two renames; whoever looks next puts the old one
    back where this was killed in between.
    """
    target.rename(old)
    try:
        new.rename(target)
    except BaseException:
        old.rename(target)
        raise


def _put_back(target: Path) -> None:
    """Put an earlier folder of ours back in its place where a process was killed between its two
    renames.
    """
    pattern = (
        re.compile(re.escape(_beside(target, "TOKEN", "old").name).replace("TOKEN", "[0-9a-f]{8}"))
        if target.name
        else None
    )
    with suppress(OSError):
        if pattern is None or os.path.lexists(target):
            return
        for each in [each for each in target.parent.iterdir() if pattern.fullmatch(each.name)]:
            if each.is_dir() and not each.is_symlink() and not _strangers(each):
                each.rename(target)
                return


def to_disk(path: Path) -> None:
    """Wait until a file, or a folder's list of names, is on the disk; where a system cannot open
    folders, it keeps their names by itself.
    """
    try:
        handle = os.open(path, os.O_RDONLY)
    except PermissionError:
        return
    try:
        os.fsync(handle)
    except OSError as error:
        # disks that know no such thing
        if error.errno not in {errno.EINVAL, errno.ENOTSUP, errno.EBADF}:
            raise
    finally:
        os.close(handle)


def _remove(folder: Path) -> None:
    """Take away a folder of ours: our files by name and nothing else."""
    for name in FILES:
        (folder / name).unlink(missing_ok=True)
    for name, suffixes in FOLDERS.items():
        if (folder / name).is_dir() and not (folder / name).is_symlink():
            for each in [
                each for each in (folder / name).iterdir() if each.name.endswith(suffixes)
            ]:
                each.unlink()
            _remove_if_empty(folder / name)
    _remove_if_empty(folder)


def _remove_if_empty(folder: Path) -> None:
    try:
        folder.rmdir()
    except OSError as error:  # someone put something into it: theirs to keep
        if error.errno not in {errno.ENOTEMPTY, errno.EEXIST, errno.ENOENT, errno.ENOTDIR}:
            raise
