"""Meshes of a URDF, from files within its own folder."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from lostmotion.mechanism.arm import Arm
    from lostmotion.spatial import Floats


def meshes_of(server: Any, urdf: Path, arm: Arm) -> tuple[Callable[[Floats], None] | None, str]:  # noqa: ANN401 - a viser server
    """Add the visual shapes of a URDF to the scene. Return the function that moves them to joint values q (joint,), and a warning.

    None where the URDF has no shapes, or a mesh file is missing or cannot be read. Files are read within the folder of the URDF alone:
    `package://NAME/` is that folder, or a folder NAME in it.
    """
    import yourdfpy
    from viser.extras import ViserUrdf
    from viser.transforms import SO3

    folder, missing = urdf.resolve().parent, []

    def inside(fname: str) -> str:
        scheme, _, path = fname.rpartition("://")
        for each in (path, path.partition("/")[2]) if scheme else (path,):
            file = (folder / each).resolve()
            if file.is_file() and file.is_relative_to(folder):
                return str(file)
        missing.append(fname)
        return ""

    try:
        model = yourdfpy.URDF.load(str(urdf), filename_handler=inside, load_meshes=True, build_scene_graph=True)
    except Exception as error:  # noqa: BLE001 - a broken file of a user; each format raises errors of its own
        return None, f"The meshes cannot be read ({error}); the arm is drawn by its sections."
    if missing:
        return None, f"No file {missing[0]} in the folder of the URDF; the arm is drawn by its sections."
    if model.scene is None or not model.scene.geometry:
        return None, ""
    root = server.scene.add_frame("/urdf", show_axes=False)
    # The arm may begin at another link than the root of the URDF. Both have the first joint at the same place.
    model.update_cfg(np.zeros(model.num_actuated_joints))
    first = model.get_transform(model.joint_map[arm.joints[0].name].child, model.base_link)
    pose = arm.tree.places[1].pose @ np.linalg.inv(first)
    root.position, root.wxyz = pose[:3, 3], SO3.from_matrix(pose[:3, :3]).wxyz
    shown = ViserUrdf(server, model, root_node_name="/urdf")
    column = {joint.name: k for k, joint in enumerate(arm.moving)}
    columns = [column.get(name) for name in shown.get_actuated_joint_names()]

    def move(q: Floats) -> None:
        shown.update_cfg(np.array([0.0 if column is None else q[column] for column in columns]))

    return move, ""
