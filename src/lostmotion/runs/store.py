"""The folder of a big run: its order, a Zarr group of blocks, and the ledger of those that are
done. An interrupted run resumes from it.

    run.json          the order: arm file, values swept, counts, seed, versions (`runs.order`)
    blocks.zarr/      arrays (design, block, ...), one chunk per block, to be opened with Zarr or
                      xarray
    ledger/           a file for each block that is done, with the SHA-256 of its chunks and of the
                      order they belong to
    run.lock          empty; locked by the process that writes, and released when that ends in
                      any way
    report.html, result.json    once all blocks are done

It contains no time and no random numbers, so that two runs of one order can be compared byte by
byte. A file is put in place
whole or not at all; a block counts as done once its chunks are what its ledger says, and is
computed again where they are not.
"""

from __future__ import annotations

import os
import re
import shutil
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Final, Self

import numpy as np

from lostmotion.errors import InputError, LostmotionError, OutputExistsError, Problem
from lostmotion.runs.blocks import BlockRecord, check_record, pieces, unpack
from lostmotion.runs.checkpoint import PARTIAL, digest, entry, place, read_entry, read_regular
from lostmotion.runs.job import Order, order_of
from lostmotion.runs.lock import LOCK, lock
from lostmotion.runs.zarr_metadata import BLOCKS, zarr_metadata

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping

ORDER: Final = "run.json"
LEDGER: Final = "ledger"
SUMMED_UP: Final = ("report.html", "result.json")
# Folders of its figures and tables as files.
_COPIES: Final = ("figures", "tables")
_LARGEST_ORDER: Final = 20_000_000
# The line of the ledger that binds a block to its order.
_OF_ORDER: Final = "run.json"
# A run that begins holds the lock while it writes a few small files.
_SECONDS_TO_BEGIN: Final = 60.0
# One that finds another order there holds it for less.
_SECONDS_TO_LOOK: Final = 2.0
_PARTIAL: Final = re.compile(rf"\.[0-9a-f]{{8}}{re.escape(PARTIAL)}$")


class Store:
    """Folder of a run: `begin` starts or resumes one, `open` reads it."""

    def __init__(self, folder: Path, order: Order) -> None:
        """Take a folder that was checked already."""
        self.folder = folder
        self.order = order
        self._pieces = pieces(order)
        self._order = digest(order.text())

    @classmethod
    def begin(cls, folder: Path, order: Order, *, force: bool = False) -> Self:
        """Return the store of this order in this folder, new or as an earlier run left it; with
        `force` a run of another order is removed first.

        Raises OutputExistsError for a folder that holds anything else, or a run of another order;
        then nothing in it is touched.
        """
        folder = folder.absolute()
        text = order.text()
        if len(text) > _LARGEST_ORDER:
            raise LostmotionError(
                f"the files of this arm take {len(text)} bytes; at most {_LARGEST_ORDER} go "
                "into a run's store"
            )
        if folder.is_symlink() or (folder.exists() and not folder.is_dir()):
            raise OutputExistsError(f"'{folder}' is not a folder\n  name another one with --out")
        store = cls(folder, order)
        there = read_regular(folder / ORDER, _LARGEST_ORDER)
        if force and there is not None and there != text:
            store._remove_run(there)
            there = None
        if there is not None:
            store._refuse_other_order(there)
        elif _strangers(folder):
            raise OutputExistsError(
                f"'{folder}' exists and holds no run\n  nothing was changed; name another folder "
                "with --out"
            )
        # Read again under the lock: of two runs that begin in a new folder at the same time, the
        # second finds the order of the first.
        with lock(folder, wait=_SECONDS_TO_BEGIN if there is None else 0.0):
            there = read_regular(folder / ORDER, _LARGEST_ORDER)
            if there is None:
                _put(folder / ORDER, text)
            store._refuse_other_order(text if there is None else there)
            store._refuse_links()
            for name, content in zarr_metadata(order).items():
                if read_regular(folder / name, _LARGEST_ORDER) != content:
                    _put(folder / name, content)
        return store

    def _remove_run(self, there: bytes) -> None:
        """Remove the run of another order, its order last: killed in between, it is that run with
        blocks missing.

        Raises OutputExistsError where the folder holds other files too, or an order that this
        package did not write; LostmotionError where a process is at work in it.
        """
        try:
            order_of(there)
        except LostmotionError:
            self._refuse_other_order(there)
        with lock(self.folder, wait=_SECONDS_TO_LOOK):
            self._refuse_links()
            ours = {ORDER, LOCK, BLOCKS, LEDGER, *SUMMED_UP, *_COPIES}
            others = sorted(
                each.name
                for each in self.folder.iterdir()
                if each.name not in ours and not _PARTIAL.search(each.name)
            )
            if others:
                raise OutputExistsError(
                    f"'{self.folder}' holds files that no run wrote: "
                    f"{', '.join(map(repr, others[:3]))}\n"
                    "  nothing was changed, even with --force; name another folder with --out"
                )
            for name in (*_COPIES, LEDGER, BLOCKS):
                if (self.folder / name).is_dir() and not (self.folder / name).is_symlink():
                    shutil.rmtree(self.folder / name)
            for name in (*SUMMED_UP, ORDER):
                (self.folder / name).unlink(missing_ok=True)

    def _refuse_other_order(self, there: bytes | None) -> None:
        """Refuse to go on where another order stands. Raises OutputExistsError, which names what
        differs.
        """
        if there == self.order.text():
            return
        try:
            lines = (
                ["run.json is missing"]
                if there is None
                else self.order.differences(order_of(there))
            )
        except LostmotionError:
            lines = ["its order cannot be read"]
        differences = "\n".join(f"  {line}" for line in lines or ["written differently"])
        raise OutputExistsError(
            f"'{self.folder}' holds another run, which this one cannot continue:\n{differences}\n"
            "  replace it with --force, or name another folder with --out"
        )

    @classmethod
    def open(cls, folder: Path) -> Self:
        """Return the store in this folder, to be read. Raises InputError for a folder that no run
        of this package made.
        """
        folder = folder.absolute()
        text = read_regular(folder / ORDER, _LARGEST_ORDER)
        if text is None:
            found = (
                f"no run: no {ORDER} in it"
                if folder.is_dir()
                else "no such folder"
                if not folder.exists()
                else "no folder"
            )
            raise InputError(
                [
                    Problem(
                        str(folder),
                        "",
                        found,
                        "a folder that `lostmotion sweep` wrote",
                        "lostmotion replay z-arm-sweep",
                    )
                ]
            )
        order = order_of(text)
        store = cls(folder, order)
        store._refuse_links()
        for name, content in zarr_metadata(order).items():
            if read_regular(folder / name, _LARGEST_ORDER) != content:
                raise LostmotionError(
                    f"'{folder / name}' is not what the run's order says\n  run the same "
                    "`lostmotion sweep` again to mend it"
                )
        return store

    def _refuse_links(self) -> None:
        for name in (BLOCKS, LEDGER, *(f"{BLOCKS}/{name}" for name in self._pieces)):
            if (self.folder / name).is_symlink():
                raise LostmotionError(
                    f"'{self.folder / name}' is a link that leads elsewhere; such a store is "
                    "not touched"
                )

    @contextmanager
    def locked(self) -> Iterator[None]:
        """Keep a second run from writing here at the same time.

        Raises LostmotionError where one is at work, OutputExistsError where run.json states another
        order by now.
        """
        # Waits for a run of another order that has come to the same folder, and only reads that it
        # must go.
        with lock(self.folder, wait=_SECONDS_TO_LOOK):
            self._refuse_other_order(read_regular(self.folder / ORDER, _LARGEST_ORDER))
            yield

    def done(self, progress: Callable[[str, int, int], None] | None = None) -> np.ndarray:
        """Return the finished blocks (design, block), as `read` returns them, and remove what a
        killed run left unfinished.

        Sweeps out what a killed run left half written.
        """
        self._sweep_out()
        out = np.zeros((self.order.designs, self.order.blocks), bool)
        for k, (design, block) in enumerate(self._listed()):
            out[design, block] = self._record(design, block) is not None
            if progress is not None:
                progress("checking what is done", k + 1, out.size)
        return out

    def _listed(self) -> Iterator[tuple[int, int]]:
        """Name the blocks that the ledger has a line for, in no order."""
        with (
            suppress(FileNotFoundError),
            self._inside(LEDGER),
            os.scandir(self.folder / LEDGER) as entries,
        ):
            for each in entries:
                match = re.fullmatch(r"(\d{1,9})\.(\d{1,12})\.json", each.name)
                if (
                    match
                    and int(match[1]) < self.order.designs
                    and int(match[2]) < self.order.blocks
                ):
                    yield int(match[1]), int(match[2])

    def _sweep_out(self) -> None:
        for name in ("", LEDGER, BLOCKS, *(f"{BLOCKS}/{name}" for name in self._pieces)):
            with (
                suppress(FileNotFoundError),
                self._inside(name),
                os.scandir(self.folder / name) as entries,
            ):
                for each in entries:
                    if _PARTIAL.search(each.name) and not each.is_dir(follow_symlinks=False):
                        Path(each.path).unlink(missing_ok=True)

    @contextmanager
    def _inside(self, name: str) -> Iterator[None]:
        """Report in one message where a folder of the store cannot be looked into: a file in its
        place, or no permission.
        """
        try:
            yield
        except FileNotFoundError:
            raise
        except OSError as error:
            path = self.folder / name
            raise LostmotionError(
                f"'{path}' cannot be used: {error.strerror or error}\n  remove it and run the "
                "same `lostmotion sweep` again"
            ) from error

    def write(self, design: int, block: int, packed: Mapping[str, bytes]) -> None:
        """Keep a block: its chunks first, then its line in the ledger, each whole or not at all."""
        for name in self._pieces:
            place(self._chunk(name, design, block), packed[name])
        place(
            self._entry(design, block),
            entry(
                {_OF_ORDER: self._order, **{name: digest(packed[name]) for name in self._pieces}}
            ),
        )

    def keep(self, name: str, content: bytes) -> None:
        """Keep a file that sums the run up, in place of an earlier one."""
        if name not in SUMMED_UP and name.partition("/")[0] not in _COPIES:
            raise ValueError(f"'{name}' is no file of a run")
        self._refuse_other_order(read_regular(self.folder / ORDER, _LARGEST_ORDER))
        _put(self.folder / name, content)

    def read(self, design: int, block: int) -> BlockRecord:
        """Return a block. Raises LostmotionError where it is not there as the ledger says."""
        record = self._record(design, block)
        if record is None:
            message = (
                f"block {block} of design {design} in '{self.folder}' is not done, damaged, or of "
                f"another job than its {ORDER}"
            )
            raise LostmotionError(f"{message}\n  run the same `lostmotion sweep` again")
        return record

    def _record(self, design: int, block: int) -> BlockRecord | None:
        """Return a block where it is there as the ledger says, and is one that a study can make."""
        packed = self._packed(design, block)
        try:
            return (
                None
                if packed is None
                else check_record(self.order, block, unpack(self.order, packed))
            )
        except (ValueError, RuntimeError):
            return None

    def _packed(self, design: int, block: int) -> dict[str, bytes] | None:
        """Return a block's chunks where all of them are as the ledger says."""
        sums = read_entry(self._entry(design, block))
        # figures of another order, or of this one before somebody edited it
        if sums.get(_OF_ORDER) != self._order:
            return None
        out = {}
        for name, piece in self._pieces.items():
            # What cannot be packed is stored as it is, with a few bytes around it.
            raw = read_regular(
                self._chunk(name, design, block), piece.size + piece.size // 100 + 1000
            )
            if raw is None or sums.get(name) != digest(raw):
                return None
            out[name] = raw
        return out

    def _chunk(self, name: str, design: int, block: int) -> Path:
        return self.folder / BLOCKS / name / f"c.{design}.{block}.0.0"

    def _entry(self, design: int, block: int) -> Path:
        return self.folder / LEDGER / f"{design}.{block}.json"


def _strangers(folder: Path) -> bool:
    """Return whether the folder contains anything that a run which has just started does not
    leave.
    """
    try:
        return any(
            name != LOCK and not _PARTIAL.search(name)
            for name in [each.name for each in folder.iterdir()]
        )
    except FileNotFoundError:
        return False
    except OSError as error:
        raise LostmotionError(
            f"'{folder}' cannot be read: {error.strerror or error}\n  name another folder with "
            "--out"
        ) from error


def _put(path: Path, content: bytes) -> None:
    try:
        place(path, content, to_disk=True)
    except OSError as error:
        raise LostmotionError(
            f"'{path}' cannot be written: {error.strerror or error}\n  name a folder that can "
            "be written with --out"
        ) from error
