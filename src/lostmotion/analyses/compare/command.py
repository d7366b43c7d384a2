"""Ask what the differences between arms do to their accuracy."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Final

from lostmotion.analyses.arguments import (
    DEFAULT_POSES,
    DEFAULT_ROBOTS,
    DEFAULT_VISITS,
    ApproachArgument,
    CalibrationArgument,
    PoseLawArgument,
    ProgressArgument,
    ReadyArgument,
    RobotsArgument,
    SeedArgument,
    ThreadsArgument,
    VisitsArgument,
    arm_of,
    chosen_poses,
    paths_of,
    poses_of,
)
from lostmotion.analyses.signature import Argument, question, read_arguments
from lostmotion.errors import InputError, Mistakes, Problem, refuse_argument

if TYPE_CHECKING:
    from lostmotion.analyses.compare.page import Compare
    from lostmotion.error_model.poses import Poses
    from lostmotion.mechanism.arm import Arm
    from lostmotion.spatial import Floats

_FEWEST: Final = 2
_MOST: Final = 6
_EXAMPLE: Final = "before.toml after.toml"


def _arms_of(name: str, value: Any, given: Mapping[str, Any]) -> list[tuple[str, Arm]]:  # noqa: ANN401 - whatever a user passes
    """Return the arms with their labels. Raises InputError with every mistake in all files."""
    if not _FEWEST <= len(value) <= _MOST:
        raise refuse_argument(
            name,
            "no arm" if not value else "one arm" if len(value) == 1 else f"{len(value)} arms",
            f"{_FEWEST} to {_MOST} arms",
            **{name: _EXAMPLE},
        )
    sidecars = _sidecars(value, given.get("sidecar"))
    with Mistakes() as mistakes:
        arms = [
            mistakes.of(arm_of, name, each, {**given, "sidecar": sidecar})
            for each, sidecar in zip(value, sidecars, strict=True)
        ]
    return list(zip(_labels(value, arms, sidecars), arms, strict=True))


def _sidecars(arms: Sequence[Any], stated: Any) -> list[Path | None]:  # noqa: ANN401 - whatever a user passes
    """Return the sidecar of each arm: one that is stated serves every URDF, several serve the URDFs
    in their order.
    """
    if stated is None:
        return [None] * len(arms)
    files = paths_of("sidecar", stated)
    takes = [
        isinstance(each, str | os.PathLike) and Path(each).suffix.lower() != ".toml"
        for each in arms
    ]
    if len(files) not in {1, sum(takes)}:
        found, expected = (
            f"{len(files)} sidecars for {sum(takes)} robot descriptions",
            "one for all of them, or one for each in their order",
        )
        raise refuse_argument("sidecar", found, expected, sidecar="arm.toml")
    if not any(takes):
        raise refuse_argument(
            "sidecar",
            str(files[0]),
            "a sidecar beside a URDF only; a TOML arm says everything itself",
            arms="arm.urdf other.urdf",
        )
    left = iter(files if len(files) > 1 else files * sum(takes))
    return [next(left) if taken else None for taken in takes]


def _labels(
    values: Sequence[Any], arms: Sequence[Arm], sidecars: Sequence[Path | None]
) -> list[str]:
    """Return a name for each arm: that of its file; where names are equal with its folder or its
    sidecar, or else a number.
    """
    named = [
        [arm.name] if not isinstance(each, str | os.PathLike) else _names(Path(each), sidecar)
        for each, arm, sidecar in zip(values, arms, sidecars, strict=True)
    ]
    first = [names[0] for names in named]
    out = []
    for k, names in enumerate(named):
        equal = [other for j, other in enumerate(named) if j != k and other[0] == names[0]]
        own = next((name for name in names if all(name not in other for other in equal)), "")
        out.append(own or f"{first[k]} ({1 + first[:k].count(first[k])})")
    return out


def _names(path: Path, sidecar: Path | None) -> list[str]:
    """Return the names of a file, the shortest first."""
    return [
        path.stem,
        *([sidecar.stem] if sidecar is not None else []),
        f"{path.absolute().parent.name}/{path.stem}",
    ]


def _poses_of(name: str, value: Any, given: Mapping[str, Any]) -> list[int | Poses]:  # noqa: ANN401 - whatever a user passes
    """Return how many poses are wanted of each arm, or those given. Raises InputError with every
    mistake in the file.
    """
    arms = [arm for _, arm in given["arms"]] if isinstance(given["arms"], list) else [None]
    with Mistakes() as mistakes:
        return [mistakes.of(poses_of, name, value, {"arm": arm}) for arm in arms]


@question(folder="compare")
def compare(
    *arms: Annotated[
        "Arm | str | Path | Mapping[str, Any]",
        Argument(
            (
                "Two arms or more, each native TOML or URDF with its sidecar TOML; all are "
                "compared with the first."
            ),
            _arms_of,
            metavar="FILE",
            repeats=True,
        ),
    ],
    poses: Annotated[
        "int | str | Path | Floats | Poses",
        Argument(
            "How many poses each arm visits, rounded up to 8 x a power of two for sobol, to a "
            "multiple of 8 for uniform and normal; or a CSV file of "
            "poses, one column per joint with a header like 'A [deg]'. In Python also joint "
            "values (pose, joint) in rad and m.",
            _poses_of,
            metavar="COUNT|CSV",
            aliases=("--poses-file",),
        ),
    ] = DEFAULT_POSES,
    robots: RobotsArgument = DEFAULT_ROBOTS,
    visits: VisitsArgument = DEFAULT_VISITS,
    seed: SeedArgument = 1,
    pose_law: PoseLawArgument = "sobol",
    approach: ApproachArgument = "random",
    sidecar: Annotated[
        "str | Path | Sequence[str | Path] | None",
        Argument(
            (
                "Sidecar TOML of the URDFs: one for all of them, or one for each in their order; "
                "in Python a list. Default: those beside them."
            ),
            metavar="SIDECAR",
            repeats=True,
        ),
    ] = None,
    calibration: CalibrationArgument = None,
    threads: ThreadsArgument = None,
    progress: ProgressArgument = None,
    ready: ReadyArgument = None,
) -> Compare:
    """Report what differs between arms, and what it does to accuracy, repeatability, sag, mass and
    loads of the drives, part by part.

    All arms have the same draws, so differences are more precise than the figures themselves; each
    has its own paired interval. A calibration is that of every arm: one robot before and after a
    change.

    Raises
    ------
    InputError
        With every mistake in the arguments and the files, and for arms without any error source.

    """
    asked = read_arguments(compare, locals())
    from lostmotion.analyses.compare.page import Compare
    from lostmotion.comparison.compared_arm import compared_arm
    from lostmotion.comparison.comparison import comparison
    from lostmotion.error_model.trust import with_figures

    asked.ready()
    _refuse_undescribed(asked.arms)
    poses_of_arms = [
        chosen_poses(arm, poses_of_arm, pose_law, asked.seed)
        for (_, arm), poses_of_arm in zip(asked.arms, asked.poses, strict=True)
    ]
    found = [
        compared_arm(
            label,
            arm,
            with_figures(arm, chosen, beside=_beside(asked.arms, poses_of_arms, chosen)),
            asked.robots,
            asked.visits,
            asked.seed,
            approach=asked.approach,
            threads=asked.threads or os.cpu_count() or 1,
            progress=progress,
        )
        for (label, arm), chosen in zip(asked.arms, poses_of_arms, strict=True)
    ]
    return Compare(**vars(comparison(found, asked.seed, asked.approach)))


def _beside(arms: Sequence[tuple[str, Arm]], poses: Sequence[Poses], chosen: Poses) -> list[Arm]:
    """Return the other arms that stand at the same poses: they are compared pose by pose."""
    import numpy as np

    return [
        arm
        for (_, arm), each in zip(arms, poses, strict=True)
        if each is not chosen and np.array_equal(each.q, chosen.q)
    ]


def _refuse_undescribed(arms: Sequence[tuple[str, Arm]]) -> None:
    """Raise InputError for arms without any error source, each under its label."""
    from lostmotion.error_model.provenance import refuse_undescribed

    problems: list[Problem] = []
    for label, arm in arms:
        try:
            refuse_undescribed(arm)
        except InputError as error:
            problems += [
                Problem(label, each.key, each.found, each.expected, each.example)
                for each in error.problems
            ]
    if problems:
        raise InputError(problems)
