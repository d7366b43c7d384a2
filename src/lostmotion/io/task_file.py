"""A task in TOML: what the tool does, and the tolerances that it must meet.

name = "drill six holes"
required = "95 %"              # share of robots and runs in which all tolerances must hold
tool_rpy = ["180 deg", "0 deg", "0 deg"]    # orientation of the tool in the axes of the task

[placement]                    # the frame of the task in the base's
xyz = ["600 mm", "0 mm", "400 mm"]

[[features]]                   # or poses = "path.csv", or program = "part.gcode"
name = "flange"
kind = "holes"
centre = ["0 mm", "0 mm", "0 mm"]
diameter = "120 mm"
count = 6
retract = "20 mm"              # the tool arrives along its axis from there

[[tolerances]]                 # one of cylinder, sphere, box, orientation, distance, ...
of = "flange"
cylinder = "0.4 mm"            # diameter, as on a drawing
relative_to = "fitted"         # the base, a fitted frame, or features: a datum
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from pydantic import ValidationError

from lostmotion.error_model.drawing_tolerances import KINDS, DrawingTolerance, Feature
from lostmotion.error_model.task import ForceAlong, Task
from lostmotion.errors import InputError, Problem, shown
from lostmotion.io.draft import Draft
from lostmotion.io.gcode import read_gcode
from lostmotion.io.limits import listed, nearest, refuse_all
from lostmotion.io.task_tables import FEATURE, JOINT, TaskFile
from lostmotion.io.text import beside
from lostmotion.io.toml import quoted, read_toml
from lostmotion.io.toml_lines import names_lines
from lostmotion.io.tool_path import read_tool_path
from lostmotion.io.validation_errors import problems
from lostmotion.mechanism.warm_up import OwnHeat
from lostmotion.spatial import pose_of

if TYPE_CHECKING:
    from lostmotion.io.task_tables import ForceTable, ToleranceTable, WarmUpTable
    from lostmotion.io.tool_path import PathRows
    from lostmotion.mechanism.arm import Arm
    from lostmotion.spatial import Floats

MOST_PLACES: Final = 2000
_STEP: Final = 0.005
# Places of a feature that is wrong, whose name tolerances may still use.
_NOWHERE: Final = np.zeros((0, 3))
_DOWN: Final = (math.pi, 0.0, 0.0)
# Keys that belong to some kinds of tolerances alone.
_BELONG: Final = {"length": ("cylinder",), "axis": ("cylinder", "orientation")}
_EXAMPLE: Final = '{ cylinder = "0.4 mm" }'
_SIGNS: Final = {"up": 1.0, "down": -1.0, "random": 0.0}


@names_lines
def read_task(by: Path | Mapping[str, Any], arm: Arm) -> Task:
    """Return the task of a file, or of the keys of such a file, for this arm. Raises InputError
    with every mistake in it and in the file of poses that it names.
    """
    file = "by" if isinstance(by, Mapping) else str(by)
    tree = dict(by) if isinstance(by, Mapping) else read_toml(by)
    try:
        stated = TaskFile.model_validate(tree, context={"text": not isinstance(by, Mapping)})
    except ValidationError as error:
        mistakes = problems(error, TaskFile, file, Draft(file, {}, {}).key)
        refuse_all([_named(each, tree, arm) for each in mistakes])
    sources = {"poses": stated.poses, "program": stated.program, "features": stated.features}
    given = [name for name, value in sources.items() if value]
    if len(given) != 1:
        found, expected = " and ".join(given) or "none of them", "one of " + ", ".join(sources)
        raise InputError([Problem(file, ", ".join(sources), found, expected, 'poses = "path.csv"')])
    if stated.features:
        return _of_features(stated, arm, file)
    key, named = given[0], stated.poses or stated.program
    folder = Path.cwd() / "task.toml" if isinstance(by, Mapping) else by
    path = beside(str(folder), named)
    if path is None:
        expected = "the name of a file in the folder of this one, or below"
        raise InputError([Problem(file, key, shown(named), expected, f'{key} = "path.csv"')])
    if stated.program is not None:
        return _of_program(stated, path, arm, file)
    return _of_rows(stated, read_tool_path(path, arm), arm, file)


def _named(mistake: Problem, tree: Mapping[str, Any], arm: Arm) -> Problem:
    """Return a mistake with a feature of this task and a joint of this arm in its example."""
    features = tree.get("features")
    features = features if isinstance(features, list) else []
    names = [each.get("name") for each in features if isinstance(each, dict)]
    feature = next((name for name in names if isinstance(name, str) and name), "path")
    joint = next((each.name for each in arm.joints if each.link.expands), "J1")
    example = mistake.example
    for place, name in ((FEATURE, feature), (JOINT, joint)):
        example = example.replace(place, quoted(name))
    return replace(mistake, example=example)


def _of_program(stated: TaskFile, path: Path, arm: Arm, file: str) -> Task:
    """Return the task of a program in G-code: cutting moves between rapid ones are its features."""
    moves = read_gcode(path, stated.step or _STEP, MOST_PLACES)
    pose = pose_of(rpy=stated.tool_rpy or _DOWN)
    poses = np.tile(pose, (len(moves.points), 1, 1))
    poses[:, :3, 3] = moves.points
    numbers = np.array(moves.path)[moves.visited]
    features = [
        Feature(f"path {k}", "path", np.flatnonzero(numbers == k), None)
        for k in range(1, max(moves.path) + 1)
    ]
    return _task(
        stated,
        file,
        arm,
        [],
        features,
        poses=poses,
        q=None,
        turned=True,
        visited=moves.visited,
        where=tuple((str(path), f"line {line}") for line in moves.lines),
        approach=np.full((len(poses), len(arm.driven)), math.nan),
        force=_force(stated.force, int(moves.visited.sum())),
    )


def _of_features(stated: TaskFile, arm: Arm, file: str) -> Task:
    """Return the task that visits these features in their order."""
    poses: list[Floats] = []
    visited: list[bool] = []
    where: list[tuple[str, str]] = []
    approach: list[float] = []
    features: list[Feature] = []
    mistakes: list[Problem] = []
    for number, each in enumerate(stated.features):
        key = f"features[{number}]"
        try:
            points, axis = each.layout(stated.step)
        except ValueError as error:
            found, _, expected = str(error).partition("; ")
            mistakes.append(Problem(file, key, found, expected))
            points, axis = _NOWHERE, None
        if len(points) > MOST_PLACES:
            mistakes.append(
                Problem(
                    file, key, f"{len(points)} places", f"at most {MOST_PLACES}", 'step = "5 mm"'
                )
            )
            points = _NOWHERE
        pose = pose_of(rpy=each.tool_rpy or stated.tool_rpy or _DOWN)
        first = sum(visited)
        for k, point in enumerate(points):
            here = pose.copy()
            here[:3, 3] = point
            if each.retract and (k == 0 or each.kind in {"holes", "point"}):
                before = here.copy()
                before[:3, 3] -= each.retract * here[:3, 2]
                poses.append(before)
                visited.append(False)
                where.append((file, f"{key}, approach of place {k + 1}"))
                approach.append(math.nan)
            poses.append(here)
            visited.append(True)
            where.append((file, f"{key}, place {k + 1}"))
            approach.append(
                _SIGNS[each.approach] if each.approach is not None and k == 0 else math.nan
            )
        features.append(Feature(each.name, each.kind, np.arange(first, first + len(points)), axis))
        if each.kind == "holes":
            features += [
                Feature(f"{each.name} {k + 1}", "point", np.array([first + k]), axis)
                for k in range(len(points))
            ]
    names = [each.name for each in features]
    mistakes += [
        Problem(file, "features", f"'{name}' twice", "a name of its own for each feature")
        for name in sorted({name for name in names if names.count(name) > 1})
    ]
    if sum(visited) > MOST_PLACES:
        found, expected = f"{sum(visited)} places", f"at most {MOST_PLACES} in all"
        mistakes.append(Problem(file, "features", found, expected, 'step = "5 mm"'))
    count = len(arm.driven)
    signs = np.repeat(np.array(approach).reshape(-1, 1), count, axis=1)
    return _task(
        stated,
        file,
        arm,
        mistakes,
        features,
        poses=np.array(poses).reshape(-1, 4, 4),
        q=None,
        turned=True,
        visited=np.array(visited, bool),
        where=tuple(where),
        approach=signs,
        force=_force(stated.force, sum(visited)),
    )


def _of_rows(stated: TaskFile, rows: PathRows, arm: Arm, file: str) -> Task:
    """Return the task that visits the rows of a CSV in their order."""
    count = len(rows.where)
    mistakes: list[Problem] = []
    if count > MOST_PLACES:
        mistakes.append(Problem(rows.where[0][0], "", f"{count} rows", f"at most {MOST_PLACES}"))
    if rows.q is not None and (stated.placement is not None or stated.search is not None):
        mistakes.append(
            Problem(
                file,
                "placement",
                "a placement beside joint values",
                "none: joint values fix where the tool is; or poses of the tool",
                "x [mm],y [mm],z [mm]",
            )
        )
    poses = None
    if rows.xyz is not None:
        default = stated.tool_rpy or _DOWN
        angles = np.tile(default, (count, 1)) if rows.rpy is None else rows.rpy
        poses = np.array([pose_of(*each) for each in zip(rows.xyz, angles, strict=True)])
    names = list(dict.fromkeys(rows.feature))
    features = [
        Feature(
            name or "path",
            "point" if rows.feature.count(name) == 1 else "path",
            np.flatnonzero([each == name for each in rows.feature]),
            None,
        )
        for name in names
    ]
    force = _force(stated.force, count)
    if rows.force is not None:
        scatter = 0.0 if force is None else force.scatter
        force = ForceAlong(rows.force[:, :3], rows.force[:, 3], scatter)
    return _task(
        stated,
        file,
        arm,
        mistakes,
        features,
        poses=poses,
        q=rows.q,
        turned=rows.q is None,
        visited=np.ones(count, bool),
        where=rows.where,
        approach=rows.approach,
        force=force,
    )


def _task(
    stated: TaskFile,
    file: str,
    arm: Arm,
    mistakes: list[Problem],
    features: list[Feature],
    **rows: Any,  # noqa: ANN401 - fields of Task
) -> Task:
    """Return the task with its tolerances. Raises InputError with these mistakes, and those in the
    tolerances and in the warm-up.
    """
    known = [each.name for each in features]
    tolerances = [
        _tolerance(each, f"tolerances[{k}]", file, known, features, mistakes)
        for k, each in enumerate(stated.tolerances)
    ]
    heat = None if stated.warm_up is None else _heat(stated.warm_up, arm, file, mistakes)
    if mistakes:
        refuse_all(mistakes)
    search = stated.search
    limits = None
    if search is not None:
        reach = np.array([search.x, search.y, search.z, search.yaw])
        limits = np.column_stack([-reach, reach])
    return Task(
        name=stated.name or Path(file).stem,
        features=tuple(features),
        tolerances=tuple(each for each in tolerances if each is not None),
        placement=np.eye(4) if stated.placement is None else np.array(stated.placement.pose),
        search=limits,
        repeated=stated.repeated,
        heat=heat,
        required=round(stated.required, 12),
        **rows,
    )


def _tolerance(
    stated: ToleranceTable,
    key: str,
    file: str,
    known: list[str],
    features: list[Feature],
    mistakes: list[Problem],
) -> DrawingTolerance | None:
    """Return a tolerance; None where it is wrong, which is noted."""
    kinds = [kind for kind in KINDS if getattr(stated, kind) is not None]
    if len(kinds) != 1:
        found = "none of the kinds" if not kinds else " and ".join(kinds)
        expected = "exactly one of " + ", ".join(KINDS)
        mistakes.append(Problem(file, key, found, expected, _EXAMPLE))
        return None
    kind, size = kinds[0], getattr(stated, kinds[0])
    for name, of in _BELONG.items():
        if getattr(stated, name) and kind not in of:
            found = f"{name} of a tolerance of {kind}"
            expected = f"{name} with {' or '.join(of)} alone"
            mistakes.append(Problem(file, f"{key}.{name}", found, expected))

    def numbers(names: str | list[str] | None, at: str) -> tuple[int, ...]:
        wanted = [] if names is None else [names] if isinstance(names, str) else names
        if names is not None and not wanted:
            expected = f"at least one feature of the task, of {listed(known)}"
            mistakes.append(Problem(file, f"{key}.{at}", "an empty list", expected))
        for name in wanted:
            if name not in known:
                expected = f"a feature of the task, one of {listed(known)}"
                near = nearest(name, known)
                mistakes.append(Problem(file, f"{key}.{at}", shown(name), expected, nearest=near))
        return tuple(known.index(name) for name in wanted if name in known)

    datum: Any = stated.relative_to
    if datum not in {"base", "fitted"} if isinstance(datum, str) else True:
        datum = numbers(datum, "relative_to")
    whole = tuple(
        k
        for k, each in enumerate(features)
        if each.kind != "point" or not _in_pattern(each, features)
    )
    chosen = whole if stated.of is None else numbers(stated.of, "of")
    named = ", ".join(known[k] for k in chosen) if stated.of is not None else "all"
    return DrawingTolerance(
        stated.name or f"{named}: {kind}",
        kind,  # type: ignore[arg-type]
        size if isinstance(size, tuple) else (size,),
        chosen,
        datum,
        stated.axis or "",
        stated.length,
        (file, key),
    )


def _in_pattern(point: Feature, features: list[Feature]) -> bool:
    """Return whether a point is one hole of a pattern, which is a feature itself."""
    return any(each.kind == "holes" and point.places[0] in each.places for each in features)


def _force(stated: ForceTable | None, count: int) -> ForceAlong | None:
    """Return a constant force at all places; None without one."""
    if stated is None:
        return None
    return ForceAlong(
        np.tile(np.array(stated.vector), (count, 1)), np.full(count, stated.along), stated.scatter
    )


def _heat(stated: WarmUpTable, arm: Arm, file: str, mistakes: list[Problem]) -> OwnHeat:
    """Return the own heat of joints over the task; what is wrong with it is noted."""
    expands = {joint.name: joint.link.expands for joint in arm.joints}
    by_name = {each.joint: each for each in stated.joints}
    for k, each in enumerate(stated.joints):
        name, key = each.joint, f"warm_up.joints[{k}].joint"
        if name not in expands:
            expected, near = f"a joint, one of {listed(expands)}", nearest(name, expands)
            mistakes.append(Problem(file, key, shown(name), expected, nearest=near))
        elif not expands[name]:
            found = f"'{name}', whose link has no length or no known expansion"
            expected = "a link with a length and a material, or an expansion, in the arm's file"
            mistakes.append(Problem(file, key, found, expected, "expansion = 23e-6"))
        elif by_name[name] is not each:
            mistakes.append(Problem(file, key, f"'{name}' twice", "every joint once"))
    over = stated.duration if stated.over is None else stated.over
    if over < stated.duration:
        found = f"{over:g} s, shorter than the duration of a run, {stated.duration:g} s"
        mistakes.append(Problem(file, "warm_up.over", found, "at least one run", 'over = "8 h"'))
    warmed = [by_name[name] for name in expands if name in by_name]
    rise, constant = np.array([(each.rise, each.time_constant) for each in warmed]).reshape(-1, 2).T
    names = tuple(each.joint for each in warmed)
    return OwnHeat(names, rise, constant, stated.duration, over, stated.start == "warm")
