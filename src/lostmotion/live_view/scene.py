"""The arm in the scene of the view: links, meshes of a URDF, errors and ellipsoids."""

from __future__ import annotations

import io
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from lostmotion.io.urdf import urdf_text
from lostmotion.printed import round_number

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from lostmotion.live_view.picture import Framing
    from lostmotion.live_view.session import Figures
    from lostmotion.mechanism.arm import Arm
    from lostmotion.mechanism.shape import Body
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


_COLOURS: Final = {
    "base": (98, 108, 118),
    "link": (188, 196, 204),
    "offset": (150, 158, 166),
    "joint": (84, 98, 114),
    "rail": (98, 108, 118),
    "tool": (150, 158, 166),
    "payload": (240, 169, 60),
}
_ERROR: Final = (255, 154, 107)
# Semi-axis over standard deviation of the ellipsoid that contains 95 % of a normal vector: root of
# the quantile of chi-square with three degrees.
_WITHIN_95: Final = 2.7955
# Sizes of marks over the size of the picture.
_TOOL, _SHAFT, _HEAD, _HEAD_LENGTH, _POINT, _THINNEST = 0.006, 0.004, 0.011, 0.025, 0.0095, 0.002
_SIDES: Final = 40
# Name of the handle by which the tool is dragged, and its size over that of the picture.
HANDLE: Final = "/handle"
_HANDLE: Final = 0.08


class Scene:
    """Everything that is seen; `server` is a viser server, `draw_meshes` moves the meshes of a URDF
    to joint values, None without meshes.
    """

    def __init__(
        self,
        server: Any,  # noqa: ANN401
        arm: Arm,
        framing: Framing,
        draw_meshes: Callable[[Floats], None] | None = None,
    ) -> None:
        """Set up camera, floor and marks."""
        self._scene, self._size, self._draw_meshes = server.scene, framing.size, draw_meshes
        self._nodes: list[tuple[Body, Any]] = []
        self._cloud: Any = None
        gravity = arm.gravity_in_base
        up = -gravity / arm.gravity if arm.gravity else np.array([0.0, 0.0, 1.0])
        self._scene.set_up_direction(tuple(up.tolist()))
        self._scene.configure_default_lights(enabled=True)
        server.initial_camera.position = tuple(framing.camera.tolist())
        server.initial_camera.look_at = tuple(framing.middle.tolist())
        wide, cell = round_number(1.5 * self._size), round_number(self._size / 12)
        self._scene.add_grid(
            "/floor",
            width=wide,
            height=wide,
            cell_size=cell,
            section_size=5 * cell,
            cell_color=(60, 70, 80),
            section_color=(80, 92, 104),
            position=(0.0, 0.0, framing.floor),
        )
        self._tool = self._scene.add_icosphere("/tool_point", _TOOL * self._size, _ERROR)
        self._ellipsoid = self._scene.add_icosphere(
            "/ellipsoid", 1.0, _ERROR, opacity=0.45, cast_shadow=False
        )
        self._handle = self._scene.add_transform_controls(
            HANDLE, _HANDLE * self._size, disable_rotations=True, depth_test=False
        )
        self._held = False
        sizes = {
            "shaft_radius": _SHAFT * self._size,
            "head_radius": _HEAD * self._size,
            "head_length": _HEAD_LENGTH * self._size,
        }
        self._arrow = self._scene.add_arrows(
            "/mean_error", np.zeros((1, 2, 3), dtype=np.float32), _ERROR, **sizes
        )

    def on_drag(self, act: Callable[[Floats | None], None]) -> None:
        """Call `act` with the point (3,), m, to which the handle at the tool is dragged, and with
        None when it is let go.
        """

        def take(event: Any) -> None:  # noqa: ANN401 - an event of viser
            self._held = event.phase != "end"
            act(np.array(event.target.position) if event.phase == "update" else None)

        self._handle.on_update(take)

    def show_shape(self, arm: Arm) -> None:
        """Show the bodies of an arm; none where the meshes of its URDF are shown."""
        wanted = (
            []
            if self._draw_meshes is not None
            else [body for body in arm.bodies if body.name != "tool point"]
        )
        if len(wanted) != len(self._nodes):
            for _, node in self._nodes:
                node.remove()
            self._nodes = [(body, self._body(number, body)) for number, body in enumerate(wanted)]
            return
        for number, (body, (before, node)) in enumerate(zip(wanted, self._nodes, strict=True)):
            if (body.form, body.near, body.far, body.length) == (
                before.form,
                before.near,
                before.far,
                before.length,
            ):
                self._nodes[number] = body, node
                continue
            node.remove()
            self._nodes[number] = body, self._body(number, body)

    def show_pose(self, figures: Figures, factor: float | None) -> None:
        """Move everything to a pose; its error is drawn larger by this factor, not at all without
        one.
        """
        from viser.transforms import SO3

        if self._draw_meshes is not None:
            self._draw_meshes(figures.q)
        for body, node in self._nodes:
            pose = figures.at[body.place] @ body.pose
            node.position, node.wxyz = pose[:3, 3], SO3.from_matrix(pose[:3, :3]).wxyz
        tool = figures.at[-1, :3, 3]
        self._tool.position = tool
        if not self._held:
            self._handle.position = tool
        self._ellipsoid.visible = self._arrow.visible = factor is not None
        if factor is None:
            return
        end = tool + factor * figures.error.bias[0]
        squares, axes = np.linalg.eigh(figures.error.covariance[0])
        axes[:, 0] *= np.linalg.det(axes)  # a rotation, not a reflection
        self._ellipsoid.position, self._ellipsoid.wxyz = end, SO3.from_matrix(axes).wxyz
        self._ellipsoid.scale = tuple(
            np.maximum(
                _WITHIN_95 * factor * np.sqrt(np.maximum(squares, 0.0)), _THINNEST * self._size
            ).tolist()
        )
        self._arrow.points = np.array([[tool, end]], dtype=np.float32)

    def show_workspace(self, points: Floats, colours: np.ndarray) -> None:
        """Show tool points (point, 3), m, in their colours (point, 3)."""
        if self._cloud is None:
            self._cloud = self._scene.add_point_cloud(
                "/workspace",
                np.zeros((1, 3)),
                (0, 0, 0),
                point_size=_POINT * self._size,
                point_shape="square",
                point_shading="flat",
                visible=False,
            )
        self._cloud.visible = bool(len(points))
        if len(points):
            self._cloud.points, self._cloud.colors = points.astype(np.float16), colours

    def _body(self, number: int, body: Body) -> Any:  # noqa: ANN401 - a handle of viser
        name, colour = f"/arm/{number}", _COLOURS[body.kind]
        if body.form == "sphere":
            return self._scene.add_icosphere(name, body.length / 2, colour)
        if body.near != body.far:
            from scipy.spatial import ConvexHull

            own = np.linalg.inv(body.pose)
            corners = body.corners(_SIDES) @ own[:3, :3].T + own[:3, 3]
            hull = ConvexHull(corners)
            faces = hull.simplices.copy()
            inward = (
                np.cross(
                    corners[faces[:, 1]] - corners[faces[:, 0]],
                    corners[faces[:, 2]] - corners[faces[:, 0]],
                )
                * hull.equations[:, :3]
            ).sum(1) < 0
            faces[inward] = faces[inward][:, ::-1]
            return self._scene.add_mesh_simple(
                name, corners, faces, color=colour, flat_shading=True
            )
        if body.form == "box":
            return self._scene.add_box(name, colour, (*body.near, body.length))
        return self._scene.add_cylinder(
            name, body.near[0] / 2, body.length, colour, radial_segments=_SIDES
        )
