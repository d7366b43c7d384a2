"""Meshes of a URDF, or of the one that a xacro file makes, from files within its own project."""

from __future__ import annotations

import io
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from lostmotion.io.urdf import urdf_text

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from lostmotion.mechanism.arm import Arm
    from lostmotion.spatial import Floats

# Of all mesh files of an arm together.
_MEGABYTES: Final = 100


def meshes_of(
    server: Any,  # noqa: ANN401
    file: Path,
    arm: Arm,
    sidecar: Path | None = None,
) -> tuple[Callable[[Floats], None] | None, str]:
    """Add the visual shapes of a URDF or xacro file to the scene. Return the function that moves
    them to joint values q (joint,), and a warning.

    None where the file has no shapes or is MJCF, or where a mesh file is missing, too large or
    cannot be read. Files are read within the project alone (`io.project_root`). `package://NAME/`
    is that folder, or a folder NAME in it.
    """
    text, project = urdf_text(file, sidecar)
    if text is None:
        return None, ""
    import yourdfpy
    from viser.extras import ViserUrdf
    from viser.transforms import SO3

    own = file.resolve().parent
    sizes: dict[Path, int] = {}
    missing: list[str] = []

    def inside(fname: str) -> str:
        scheme, _, path = fname.rpartition("://")
        for each in (project / path, project / path.partition("/")[2]) if scheme else (own / path,):
            found = each.resolve()
            if found.is_file() and found.is_relative_to(project):
                sizes[found] = found.stat().st_size
                if sum(sizes.values()) > _MEGABYTES * 1_000_000:
                    raise ValueError(f"more than {_MEGABYTES} MB of meshes")
                return str(found)
        missing.append(fname)
        return ""

    try:
        # Without its declaration, which may name the encoding that the file had.
        text = text.partition("?>")[2] if text.lstrip().startswith("<?xml") else text
        model = yourdfpy.URDF.load(
            io.BytesIO(text.encode()),
            filename_handler=inside,
            load_meshes=True,
            build_scene_graph=True,
        )
    except Exception as error:  # noqa: BLE001 - a broken file of a user; each format raises errors of its own
        return None, f"The meshes cannot be read ({error}); the arm is drawn by its sections."
    if missing:
        return (
            None,
            f"No file {missing[0]} in the folder {project.name}; the arm is drawn by its sections.",
        )
    if model.scene is None or not model.scene.geometry:
        return None, ""
    root = server.scene.add_frame("/urdf", show_axes=False)
    # The arm may begin at another link than the root of the URDF. Both have the first joint at the
    # same place.
    model.update_cfg(np.zeros(model.num_actuated_joints))
    first = model.get_transform(model.joint_map[arm.joints[0].name].child, model.base_link)
    pose = arm.tree.places[1].pose @ np.linalg.inv(first)
    root.position, root.wxyz = pose[:3, 3], SO3.from_matrix(pose[:3, :3]).wxyz
    shown = ViserUrdf(server, model, root_node_name="/urdf")
    column = {joint.name: k for k, joint in enumerate(arm.driven)}
    columns = [column.get(name) for name in shown.get_actuated_joint_names()]

    def move(q: Floats) -> None:
        shown.update_cfg(np.array([0.0 if column is None else q[column] for column in columns]))

    return move, ""
