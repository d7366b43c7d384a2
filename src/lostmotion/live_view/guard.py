"""What may reach the view from outside: requests that have its token and come from its own page,
and messages that this page can send.

viser has no setting for either, so the guard stands between its server and the websockets library:
it answers requests before viser does, and passes on only the messages on its list. Everything else,
such as a request for a public tunnel or for another attribute of a slider, ends here.
"""

from __future__ import annotations

import contextlib
import hmac
import logging
import math
import secrets
from typing import TYPE_CHECKING, Any, Final

from lostmotion.errors import LostmotionError

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

# Bytes of one message; a pose of the camera has some 500.
_LARGEST: Final = 100_000
# What a message about a handle may hold besides: all pages share the scene.
_OF_EVERYBODY: Final[tuple[dict[str, str], ...]] = ({}, {"owner": ""})
# The address contains the token, so no other page may learn it; no other page may show this one in
# a frame.
_HEADERS: Final = {
    "Referrer-Policy": "no-referrer",
    "Content-Security-Policy": "frame-ancestors 'none'",
    "Cache-Control": "no-store",
}


class Guard:
    """The guard of one view.

    token   part of the address; nothing is answered without it
    checks  whether a control can take a value, by the control's identifier in viser
    """

    def __init__(self) -> None:
        """Make a new token."""
        self.token: Final = secrets.token_urlsafe(18)
        self.checks: dict[str, Callable[[object], bool]] = {}
        self._stands = False

    @contextlib.contextmanager
    def in_front(self) -> Iterator[None]:
        """Stand in front of the server that is started within. Raises LostmotionError where viser
        starts it in an unknown way.
        """
        import websockets.asyncio.server as library

        serve: Any = library.serve
        setattr(  # noqa: B010
            library, "serve", lambda *given, **settings: serve(*given, **self._guarded(settings))
        )
        try:
            yield
        finally:
            setattr(library, "serve", serve)  # noqa: B010 - as above
        if not self._stands:
            raise LostmotionError(
                "the live view cannot protect the server of this version of viser: pip "
                "install 'viser==1.1.1'"
            )

    def _guarded(self, settings: dict[str, Any]) -> dict[str, Any]:
        """Return the settings of the server with this guard in them."""
        from websockets.asyncio.server import ServerConnection

        guard, answer = self, settings["process_request"]

        class Guarded(ServerConnection):
            async def recv(self, decode: bool | None = None) -> Any:  # noqa: ANN401, FBT001 - text or bytes, as in the library
                while not guard.accepts(message := await super().recv(decode)):
                    pass
                return message

        # broken requests of strangers are not for the terminal
        silent = logging.getLogger("lostmotion.view")
        silent.addHandler(logging.NullHandler())
        silent.propagate = False
        self._stands = True
        own = {
            "process_request": lambda *asked: self._respond(answer, *asked),
            "create_connection": Guarded,
            "max_size": _LARGEST,
            "logger": silent,
        }
        return settings | own

    def _respond(self, answer: Callable[[Any, Any], Any], connection: Any, request: Any) -> Any:  # noqa: ANN401 - types of websockets
        """Return a refusal or the response of viser; None where viser goes on with a websocket."""
        from websockets.http11 import Request

        _, token, rest = f"{request.path.partition('?')[0]}//".split("/", 2)
        if not _is_own(request.headers, connection.local_address[1]) or not hmac.compare_digest(
            token.encode(errors="replace"), self.token.encode()
        ):
            return connection.respond(403, "Open the address that lostmotion printed.\n")
        response = answer(connection, Request(f"/{rest}", request.headers))
        if response is not None:
            for name, value in _HEADERS.items():
                response.headers[name] = value
        return response

    def accepts(self, raw: str | bytes) -> bool:
        """Return whether a message is one that the page sends: the pose of its camera, a click, a
        value that a control can take, or a point to which a handle may be dragged.
        """
        import msgspec

        try:
            message = msgspec.msgpack.decode(raw) if isinstance(raw, bytes) else None
        except (msgspec.DecodeError, ValueError, TypeError, RecursionError):
            return False
        match message:
            case {"type": "ViewerCameraMessage", **fields}:
                fits = all(
                    is_number(value) or _is_vector(value, 3) or _is_vector(value, 4)
                    for value in fields.values()
                )
            case {
                "type": "ScenePointerMessage",
                "event_type": "click",
                "ray_origin": origin,
                "ray_direction": direction,
                "screen_pos": [place],
                **rest,
            }:
                fits = (
                    _is_vector(origin, 3)
                    and _is_vector(direction, 3)
                    and any(direction)
                    and _is_vector(place, 2)
                    and rest == {"modifier": None}
                )
            case {
                "type": "GuiUpdateMessage",
                "uuid": str(control),
                "updates": {"value": value, **others},
                **rest,
            }:
                check = self.checks.get(control)
                fits = check is not None and not others and not rest and check(value)
            case {
                "type": "TransformControlsUpdateMessage",
                "name": str(handle),
                "wxyz": turn,
                "position": point,
                **rest,
            }:
                check = self.checks.get(handle)
                fits = (
                    check is not None
                    and check(point)
                    and _is_vector(turn, 4)
                    and rest in _OF_EVERYBODY
                )
            case {
                "type": "TransformControlsDragStartMessage" | "TransformControlsDragEndMessage",
                "name": str(handle),
                **rest,
            }:
                fits = handle in self.checks and rest in _OF_EVERYBODY
            case _:
                fits = False
        return fits


def is_number(value: object) -> bool:
    """Return whether a value is a finite number."""
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)


def is_point(value: object) -> bool:
    """Return whether a value is a list of three finite numbers."""
    return _is_vector(value, 3)


def _is_vector(value: object, count: int) -> bool:
    return isinstance(value, list) and len(value) == count and all(map(is_number, value))


def _is_own(headers: Any, port: int) -> bool:  # noqa: ANN401 - headers of websockets
    """Return whether a request names this computer and port as its host, and comes from a page of
    this host or from no page.

    Names of others may lead to this computer too (DNS rebinding), and pages of other ports of this
    computer are pages of others.
    """
    hosts, origins = headers.get_all("Host"), headers.get_all("Origin")
    return (
        len(hosts) == 1
        and hosts[0] in {f"127.0.0.1:{port}", f"localhost:{port}"}
        and origins in ([], [f"http://{hosts[0]}"])
    )
