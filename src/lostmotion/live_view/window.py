"""The view in the browser: scene and panel on a viser server of this computer, and the thread that
computes.
"""

from __future__ import annotations

import contextlib
import io
import signal
import threading
import time
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from lostmotion.live_view.controls import Controls
from lostmotion.live_view.guard import Guard, is_point
from lostmotion.live_view.picture import Framing, classes_of, enlargement, picked, visible
from lostmotion.live_view.scene import HANDLE, Scene
from lostmotion.live_view.session import ErrorOverWorkspace, Figures, Refused
from lostmotion.mechanism.state import tool_points

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from lostmotion.error_model.poses import Poses
    from lostmotion.live_view.picture import Classes
    from lostmotion.live_view.session import Session
    from lostmotion.spatial import Floats

# No other computer may reach the view: what it sends is not encrypted.
_HOST: Final = "127.0.0.1"
_BRAND: Final = (64, 140, 210)
_IDLE: Final = 0.25
# Seconds between the texts and the picture of one pose, in which the server's own thread sends the
# texts.
_APART: Final = 0.003
# How far from the base's origin the tool may be dragged, over the size of the picture.
_REACH: Final = 10.0


class Window:
    """One arm in the browser, until it is stopped."""

    def __init__(
        self,
        session: Session,
        poses: Poses,
        port: int,
        drawn: tuple[Path, Path | None] | None,
        announce: Callable[[str], None],
    ) -> None:
        """Start the server and build scene and panel.

        poses     of the workspace
        port      the next free one is taken where it is in use
        drawn     the file whose meshes are shown, with its sidecar; None for the bodies of the arm
        announce  called with each line of text that the user asks for
        """
        import viser

        from lostmotion.live_view.scene import meshes_of

        self._session, self._arm = session, session.arm
        self._guard = Guard()
        # viser prints a banner
        with self._guard.in_front(), contextlib.redirect_stdout(io.StringIO()):
            self._server: Any = viser.ViserServer(
                host=_HOST, port=port, label=f"lostmotion: {self._arm.name}", verbose=False
            )
        gui = self._server.gui
        gui.configure_theme(
            dark_mode=True,
            control_width="large",
            show_logo=False,
            show_share_button=False,
            brand_color=_BRAND,
        )
        gui.main_panel.dock_right()
        self._framing = Framing.of(self._arm, tool_points(self._arm, poses.q), session.q)
        draw_meshes, self._note = (
            (None, "") if drawn is None else meshes_of(self._server, drawn[0], self._arm, drawn[1])
        )
        self._warning = self._note
        self._scene = Scene(self._server, self._arm, self._framing, draw_meshes)
        self._scene.show_shape(self._arm)
        self._figures: Figures | None = None
        self._workspace: ErrorOverWorkspace | None = None
        self._points = np.empty(0, dtype=int)
        self._classes: Classes | None = None
        self._factor: float | None = None
        self._count, self._milliseconds = 0, 0.0
        self._stop, self._redraw = threading.Event(), threading.Event()
        self._failure: Exception | None = None
        self._controls = Controls(gui, session, self._redraw.set, announce)
        reach = _REACH * self._framing.size
        self._guard.checks = self._controls.checks | {
            HANDLE: lambda point: is_point(point) and bool(np.linalg.norm(point) <= reach)
        }
        self._controls.warn(self._warning)
        self._server.scene.on_click()(self._on_click)
        self._scene.on_drag(self._on_drag)
        self._worker = threading.Thread(target=self._work, daemon=True, name="lostmotion view")
        self._worker.start()

    @property
    def url(self) -> str:
        """Return the address for a browser on this computer, with the token."""
        return f"http://{_HOST}:{self._server.get_port()}/{self._guard.token}/"

    def wait(self) -> None:
        """Serve until ctrl-C or SIGTERM, then stop the thread and the server. Raises what stopped
        the thread that computes.
        """
        in_main = threading.current_thread() is threading.main_thread()
        before = signal.signal(signal.SIGTERM, lambda *_: self._stop.set()) if in_main else None
        try:
            while not self._stop.wait(_IDLE):
                pass
        except KeyboardInterrupt:
            pass
        finally:
            self.stop()
            if in_main:
                signal.signal(signal.SIGTERM, before)
        if self._failure is not None:
            raise self._failure

    def stop(self) -> None:
        """Stop the thread that computes, then the server."""
        self._stop.set()
        self._worker.join()
        with contextlib.redirect_stdout(io.StringIO()):  # viser says that it has stopped
            self._server.stop()

    def _work(self) -> None:
        """Compute what is asked for, one thing after the other, and show it."""
        try:
            while not self._stop.is_set():
                self._session.wait(_IDLE)
                self._step()
        except Exception as error:  # noqa: BLE001 - raised again by the thread that waits
            self._failure = error
            self._stop.set()

    def _step(self) -> None:
        """Compute what is asked for next, and show it."""
        began = time.perf_counter()
        found = self._session.step()
        self._milliseconds = (
            1e3 * (time.perf_counter() - began)
            if isinstance(found, Figures)
            else self._milliseconds
        )
        redraw = self._redraw.is_set()
        if redraw:
            self._redraw.clear()
        if found is not None or redraw:
            self._take(found, redraw=redraw)
            # A page shows texts at once if they are sent alone; together with the picture they
            # would wait until it is drawn.
            with self._server.atomic():
                self._show_texts()
            self._server.flush()
            time.sleep(_APART)
            with self._server.atomic():
                self._show_picture(workspace=redraw or isinstance(found, ErrorOverWorkspace))
            self._server.flush()

    def _take(
        self, computed: Figures | ErrorOverWorkspace | Refused | None, *, redraw: bool
    ) -> None:
        """Take what was computed.

        Classes and enlargement stay as they are at first, so that changes can be compared, until
        new ones are asked for.
        """
        if isinstance(computed, Refused):
            self._warning = computed.reason
        elif isinstance(computed, Figures):
            self._figures, self._warning = computed, self._note
        elif computed is not None:
            self._workspace = computed
        if self._workspace is None or not (redraw or isinstance(computed, ErrorOverWorkspace)):
            return
        if self._classes is None or self._controls.take_refit():
            self._classes = classes_of(self._workspace.q95)
            self._factor = enlargement(self._workspace.q95, self._framing.size)

    def _show_texts(self) -> None:
        self._controls.warn(self._warning)
        if self._figures is not None:
            if self._session.led:
                self._controls.show_pose(self._figures.q)
            self._count += 1
            self._controls.show(
                self._figures, self._workspace, self._factor, self._count, self._milliseconds
            )
        if self._classes is not None:
            self._controls.show_legend(self._classes)

    def _show_picture(self, *, workspace: bool) -> None:
        if self._session.arm is not self._arm:
            self._arm = self._session.arm
            self._scene.show_shape(self._arm)
        if workspace and self._workspace is not None and self._classes is not None:
            self._points = visible(
                self._workspace.points, self._controls.shown.value, self._framing.size
            )
            self._scene.show_workspace(
                self._workspace.points[self._points],
                self._classes.colours(self._workspace.q95[self._points]),
            )
        if self._figures is not None:
            self._scene.show_pose(self._figures, self._factor)

    def _on_drag(self, point: Floats | None) -> None:
        if point is None:  # the handle returns to the tool
            self._session.move(self._session.q)
        else:
            self._session.lead(point)

    def _on_click(self, event: Any) -> None:  # noqa: ANN401 - an event of viser
        workspace, points = self._workspace, self._points
        if workspace is None or not len(points):
            return
        ray = np.array(event.ray_origin), np.array(event.ray_direction)
        index = picked(*ray, workspace.points[points], self._framing.size)
        if index is not None:
            self._controls.go_to(workspace.poses.q[points[index]])
