"""What a big run consists of, to the last bit: files, values, counts, seed, versions. Two runs of
one order make the same bytes.
"""

from __future__ import annotations

import functools
import json
import math
import tempfile
from contextlib import contextmanager
from importlib.metadata import version
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING, Annotated, Any, Final, Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationError, field_validator, model_validator

from lostmotion.error_model.opened_constraints import with_larger_error
from lostmotion.error_model.poses import REPLICATES
from lostmotion.errors import LostmotionError, refuse_argument, shown
from lostmotion.extensions import extensions
from lostmotion.io.calibration_file import read_calibration
from lostmotion.io.poses import read_poses
from lostmotion.io.sweep import MOST_DESIGNS, MOST_KEYS, Axis, changes, designs
from lostmotion.io.sweep_designs import read_design
from lostmotion.propagation.montecarlo.blocks import MOST_ROBOTS, MOST_VISITS
from lostmotion.version import __version__

if TYPE_CHECKING:
    from collections.abc import Iterator
    from typing import Self

    from lostmotion.mechanism.arm import Arm
    from lostmotion.spatial import Floats

# Eight Sobol sequences of 30 bits.
MOST_POSES: Final = REPLICATES * 2**30
LARGEST_BLOCK: Final = 1 << 14
# Each has five small files.
MOST_BLOCKS: Final = 20_000_000
# A block holds AP and RP of every robot at every pose of it.
_MOST_PAIRS: Final = 2_000_000
_USUAL_BLOCK: Final = 1024
# A worker holds the size of every robot's error at every visit to one pose, 6 bytes each.
MOST_RETURNS: Final = 300_000_000
_MOST_FILES: Final = 50
_LONGEST_NAME: Final = 200
_ENDINGS: Final = (".toml", ".urdf", ".xml", ".csv")
# What decides the bytes: the same order made with others might differ in the last bits.
_MADE_WITH: Final = ("numpy", "scipy", "numba", "zarr", "numcodecs")

Law = Literal["sobol", "uniform", "normal", "grid", "given"]


class Order(BaseModel):
    """One run. `files` hold the texts of the arm, its sidecar and whatever they name, by their
    place in the arm's folder; `arm` is the arm's.

    given  which of the files lists the poses, where their law is "given"
    poses  in all, in `sets` independent sets of equal size, each cut into blocks of `block` poses
           (the last of a set may be shorter)
    """

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True)

    made_with: dict[str, str]
    arm: str
    files: dict[str, str]
    axes: Annotated[tuple[Axis, ...], Field(max_length=MOST_KEYS, strict=False)]
    poses: Annotated[int, Field(ge=1, le=MOST_POSES)]
    sets: Literal[1, 8]
    law: Law
    given: str | None
    calibration: str | None = None
    robots: Annotated[int, Field(ge=1, le=MOST_ROBOTS)]
    visits: Annotated[int, Field(ge=1, le=MOST_VISITS)]
    seed: Annotated[int, Field(ge=0, lt=2**63)]
    approach: Literal[-1, 0, 1]
    block: Annotated[int, Field(ge=1, le=LARGEST_BLOCK)]
    parts: Annotated[
        tuple[Annotated[str, Field(max_length=_LONGEST_NAME)], ...],
        Field(max_length=10_000, strict=False),
    ]

    @field_validator("files")
    @classmethod
    def _stay_in_the_folder(cls, files: dict[str, str]) -> dict[str, str]:
        """Refuse names that lead elsewhere: an order may come from a stranger's store."""
        for name in files:
            path = PurePosixPath(name)
            plain = (
                name.isprintable()
                and "\\" not in name
                and ":" not in name
                and len(name.encode(errors="replace")) <= _LONGEST_NAME
            )
            if (
                not plain
                or path.is_absolute()
                or ".." in path.parts
                or path.as_posix() != name
                or path.suffix.lower() not in _ENDINGS
            ):
                raise ValueError("a file of another folder")
        if len(files) > _MOST_FILES:
            raise ValueError("too many files")
        return files

    @field_validator("made_with")
    @classmethod
    def _names_its_versions(cls, made: dict[str, str]) -> dict[str, str]:
        if not {"lostmotion", *_MADE_WITH} <= made.keys():
            raise ValueError("versions that are not stated")
        return made

    @model_validator(mode="after")
    def _fits_together(self) -> Self:
        if (
            self.arm not in self.files
            or self.calibration not in {None, *self.files}
            or self.poses % self.sets
            or self.designs > MOST_DESIGNS
            or self.designs * self.blocks > MOST_BLOCKS
        ):
            raise ValueError(
                "an arm without its file, a number of poses that is not a multiple of the sets, "
                "or too many designs or blocks"
            )
        return self

    @model_validator(mode="after")
    def _shares_into_sets(self) -> Self:
        """Poses by chance come in independent sets; those of a grid or a list are one set."""
        if (self.sets == 1) != (self.law in {"grid", "given"}):
            raise ValueError("a number of sets that this law of poses does not have")
        return self

    @model_validator(mode="after")
    def _lists_its_poses(self) -> Self:
        if (
            (self.law == "given") != (self.given is not None)
            or self.given not in {None, *self.files}
            or (self.given and self.sets > 1)
        ):
            raise ValueError("listed poses without their file, or a file that is not needed")
        return self

    @model_validator(mode="after")
    def _fits_into_memory(self) -> Self:
        if self.block > largest_block(self.robots) or self.robots * self.visits > MOST_RETURNS:
            raise ValueError("blocks larger than the memory of a worker")
        return self

    @property
    def designs(self) -> int:
        """Count the designs: all combinations of the values swept."""
        return designs(self.axes)

    @property
    def blocks(self) -> int:
        """Count the blocks of poses of one design."""
        return self.sets * self._blocks_of_set

    @property
    def _blocks_of_set(self) -> int:
        return math.ceil(self.poses // self.sets / self.block)

    def span(self, block: int) -> tuple[int, int]:
        """Return the first pose of a block, and the one after its last."""
        each = self.poses // self.sets
        of_set, within = divmod(block, self._blocks_of_set)
        return of_set * each + within * self.block, of_set * each + min(
            (within + 1) * self.block, each
        )

    def set_of(self, block: int) -> int:
        """Return the independent set of poses of a block."""
        return block // self._blocks_of_set

    def stated(self, design: int) -> dict[str, Any]:
        """Return the value of every key swept in this design."""
        return changes(self.axes, design)

    def read(self, design: int) -> Arm:
        """Return the arm of this design. Read from the texts of the order alone; raises InputError
        as the reader.
        """
        with _laid_out(self.files) as folder:
            arm = read_design(folder / self.arm, None, self.stated(design))
            if self.calibration is not None:
                arm = arm.calibrated(read_calibration(folder / self.calibration, arm))
        return with_larger_error(arm)

    def listed(self, arm: Arm) -> Floats | None:
        """Return the poses that the job lists for this arm. None where they follow from a law."""
        if self.given is None:
            return None
        with _laid_out({self.given: self.files[self.given]}) as folder:
            return read_poses(folder / self.given, arm)

    def text(self) -> bytes:
        """Write the order down; the same order gives the same bytes."""
        return (
            json.dumps(
                self.model_dump(), indent=1, sort_keys=True, ensure_ascii=False, allow_nan=False
            )
            + "\n"
        ).encode()

    def differences(self, other: Order) -> list[str]:
        """Return the points in which another job differs, a line each."""
        mine, theirs = self.model_dump(), other.model_dump()
        out = []
        for name, value in mine.items():
            if value == theirs[name]:
                continue
            if isinstance(value, dict):
                keys = sorted(
                    key
                    for key in {*value, *theirs[name]}
                    if value.get(key) != theirs[name].get(key)
                )
                out += [
                    f"{key}: another text"
                    if name == "files"
                    else f"{key}: {theirs[name].get(key)} there, {value.get(key)} here"
                    for key in keys
                ]
            elif isinstance(value, list | tuple):
                out.append(f"{name}: others")
            else:
                out.append(f"{name}: {theirs[name]} there, {value} here")
        return out


@functools.lru_cache(maxsize=4)
def order_of(text: bytes) -> Order:
    """Return the job that this text encodes. Raises LostmotionError for one that no run of this
    package wrote.
    """
    try:
        order = Order.model_validate(json.loads(text))
        # refuses numbers that are not finite and half characters, which no file of ours holds
        order.text()
        return order  # noqa: TRY300 - both lines may refuse
    except (ValidationError, ValueError, RecursionError) as error:
        what = (
            error.errors()[0]["loc"][:1]
            if isinstance(error, ValidationError)
            else ("no JSON in UTF-8 with finite numbers",)
        )
        raise LostmotionError(
            "not a readable run.json: "
            f"{', '.join(map(str, what)) or 'its values do not fit together'}"
        ) from None


@functools.cache
def made_with() -> dict[str, str]:
    """Return the versions that compute here. Those that decide the bytes."""
    others = (each.package for each in extensions("parts").values())
    return {
        "lostmotion": __version__,
        **{name: version(name) for name in _MADE_WITH},
        **dict(sorted(others)),
    }


def usual_block(robots: int) -> int:
    """Return the default number of poses in a block. A power of two, fewer where there are many
    robots, so that memory stays bounded.
    """
    return min(_USUAL_BLOCK, 1 << max(int(_MOST_PAIRS / robots).bit_length() - 1, 0))


def largest_block(robots: int) -> int:
    """Return the largest number of poses in a block, with so many robots."""
    return min(LARGEST_BLOCK, max(4 * _MOST_PAIRS // robots, 1))


def check_block(block: int, robots: int) -> int:
    """Refuse blocks that are too large to be held by every worker."""
    most = largest_block(robots)
    if not 1 <= block <= most:
        raise refuse_argument(
            "block",
            block,
            f"from 1 to {most} poses with {robots} robots",
            block=usual_block(robots),
        )
    return block


@contextmanager
def _laid_out(files: dict[str, str]) -> Iterator[Path]:
    """Put the texts where the readers look for them, for a moment."""
    with tempfile.TemporaryDirectory(prefix="lostmotion-") as name:
        folder = Path(name)
        try:
            for file, text in files.items():
                place = folder / file
                place.parent.mkdir(parents=True, exist_ok=True)
                place.write_text(text, encoding="utf-8", newline="")
        except OSError as error:
            # one file named as the folder of another, names too long, a full disk
            raise LostmotionError(
                "the files of the run cannot be written to a temporary folder: "
                f"{error.strerror or error} ({shown(file)})"
            ) from None
        yield folder
