"""The view against strangers: other hosts, origins and tokens are refused, and of messages only
values that a control can take have an effect.
"""

from __future__ import annotations

import http.client
import http.server
import importlib.util
import math
import socket
import threading
import time
from contextlib import contextmanager
from pathlib import Path
from urllib.parse import urlsplit

import numpy as np
import pytest

import lostmotion
from lostmotion.live_view.choices import Choices
from lostmotion.live_view.session import Session
from lostmotion.mechanism.state import tool_points
from tests.browser.chromium import CHROMIUM, Browser

EXAMPLES = Path(__file__).parents[2] / "examples"
pytestmark = pytest.mark.skipif(
    importlib.util.find_spec("viser") is None,
    reason="viser is not installed: pip install 'lostmotion[view]'",
)
CAMERA = {
    "type": "ViewerCameraMessage",
    "wxyz": [1.0, 0.0, 0.0, 0.0],
    "position": [1.0, 0.0, 0.0],
    "fov": 1.0,
    "near": 0.1,
    "far": 10.0,
    "image_height": 600,
    "image_width": 800,
    "look_at": [0.0, 0.0, 0.0],
    "up_direction": [0.0, 0.0, 1.0],
}
SIGN_UP = {
    "Upgrade": "websocket",
    "Connection": "Upgrade",
    "Sec-WebSocket-Key": "dGhlIHNhbXBsZSBub25jZQ==",
    "Sec-WebSocket-Version": "13",
    "Sec-WebSocket-Protocol": "viser-v0",
}


@pytest.fixture(scope="module")
def window():
    """Serve one arm."""
    from lostmotion.live_view.window import Window

    arm = lostmotion.read(EXAMPLES / "scara.toml")
    poses = lostmotion.sample_poses(arm, 64)
    started = Window(Session(arm, poses, poses.q[0]), poses, 8492, None, lambda _: None)
    yield started
    started.stop()


def status(window, *, websocket=False, **changes):
    """Return the status of a request for the page or for a websocket; `changes` of path, Host and
    Origin (None: without).
    """
    address = urlsplit(window.url)
    connection = http.client.HTTPConnection("127.0.0.1", address.port, timeout=10)
    connection.putrequest("GET", changes.pop("path", address.path), skip_host=True)
    headers = {"Host": address.netloc, **(SIGN_UP if websocket else {}), **changes}
    for name, value in headers.items():
        if value is not None:
            connection.putheader(name, value)
    connection.endheaders()
    try:
        return connection.getresponse().status
    finally:
        connection.close()


WRONG = {
    "no token": {"path": "/"},
    "no token, a file": {"path": "/index.html"},
    "wrong token": {"path": "/AAAAAAAAAAAAAAAAAAAAAAAA/"},
    "token in the query": {"path": "/?token={token}"},
    "longer token": {"path": "/{token}A/"},
    "shorter token": {"path": "/{half}/"},
    "token of other letters": {"path": "/%C3%A4/"},
    "folder above": {"path": "/x/../{token}/"},
    "origin of a stranger": {"Origin": "https://example.org"},
    "origin of another port": {"Origin": "http://127.0.0.1:9"},
    "origin by another name": {"Origin": "http://localhost:{port}"},
    "origin of another scheme": {"Origin": "https://127.0.0.1:{port}"},
    "origin of a file": {"Origin": "null"},
    "host of a stranger": {"Host": "example.org:{port}"},
    "host and origin of a stranger": {
        "Host": "example.org:{port}",
        "Origin": "http://example.org:{port}",
    },
    "host of another port": {"Host": "127.0.0.1:9"},
    "host that begins alike": {"Host": "127.0.0.1:{port}.example.org"},
    "no host": {"Host": None},
}


@pytest.mark.parametrize("websocket", [False, True], ids=["page", "websocket"])
@pytest.mark.parametrize("wrong", WRONG.values(), ids=WRONG)
def test_requests_of_strangers_are_refused(window, wrong, websocket):
    """Host, origin and token must all be right, for the page and for its websocket."""
    address = urlsplit(window.url)
    token = address.path.strip("/")
    names = {"token": token, "half": token[:12], "port": address.port}
    changes = {key: value and value.format(**names) for key, value in wrong.items()}
    assert status(window, websocket=websocket, **changes) == 403


@pytest.mark.parametrize(
    "own",
    [
        {},
        {"Origin": "http://127.0.0.1:{port}"},
        {"Host": "localhost:{port}", "Origin": "http://localhost:{port}"},
    ],
)
def test_requests_of_its_own_page_are_answered(window, own):
    """By both names of this computer."""
    changes = {key: value.format(port=urlsplit(window.url).port) for key, value in own.items()}
    assert status(window, **changes) == 200
    assert status(window, websocket=True, **changes) == 101


def test_the_view_listens_on_this_computer_alone(window):
    """Under no other address of it; every view has another token, of more than a hundred bits."""
    port = urlsplit(window.url).port
    with pytest.raises(OSError), socket.create_connection(("127.0.0.2", port), timeout=2):  # noqa: PT011 - refused or unreachable
        pass
    assert len(urlsplit(window.url).path.strip("/")) >= 22


@contextmanager
def connected(window):
    """Connect as the page does, with its token and origin, and yield the function that sends a
    message.
    """
    import msgspec
    import viser
    from websockets.sync.client import connect

    address = urlsplit(window.url)
    protocol = f"viser-v{viser.__version__}"
    with connect(
        window.url.replace("http", "ws", 1),
        origin=f"http://{address.netloc}",
        subprotocols=[protocol],
        max_size=None,
    ) as socket_:
        threading.Thread(target=lambda: list(socket_), daemon=True).start()
        yield lambda message: socket_.send(
            message if isinstance(message, bytes | str) else msgspec.msgpack.encode(message)
        )


def update(control, **values):
    """Return the message of a page whose control has new values."""
    return {"type": "GuiUpdateMessage", "uuid": control._impl.uuid, "updates": values}


def wait(condition):
    """Wait until something is so."""
    end = time.monotonic() + 20
    while not condition():
        assert time.monotonic() < end, "it did not happen"
        time.sleep(0.01)


def controls(window):
    """Return the joint sliders and the payload's, the first switch, the first list, and a
    button.
    """
    handles = [
        window._server.gui._gui_input_handle_from_uuid[each] for each in window._controls.checks
    ]
    kinds = {
        kind: [each for each in handles if type(each).__name__ == kind]
        for kind in {type(each).__name__ for each in handles}
    }
    sliders = kinds["GuiSliderHandle"]
    return (
        sliders[:-1],
        sliders[-1],
        kinds["GuiCheckboxHandle"][0],
        kinds["GuiDropdownHandle"][0],
        kinds["GuiButtonHandle"][0],
    )


def attributes(window):
    """Return everything that a message could overwrite."""
    handles = (
        window._server.gui._gui_input_handle_from_uuid[each] for each in window._controls.checks
    )
    return [
        {key: repr(value) for key, value in vars(each._impl).items() if key != "update_timestamp"}
        for each in handles
    ]


def test_values_of_the_page_have_an_effect(window):
    """A slider, a switch and a list change the session."""
    joints, payload, switch, _, _ = controls(window)
    with connected(window) as send:
        send(CAMERA)
        send(update(joints[0], value=10))
        wait(lambda: math.isclose(window._session.q[0], math.radians(10)))
        send(update(payload, value=payload.min + 0.5))
        wait(lambda: window._session.choices.payload == payload.min + 0.5)
        send(update(switch, value=True))
        wait(lambda: window._session.choices.compensated)
        send(update(switch, value=False))
        wait(lambda: not window._session.choices.compensated)


def drag(position, wxyz=(1.0, 0.0, 0.0, 0.0), **others):
    """Return the message of a page whose handle at the tool is dragged."""
    return {
        "type": "TransformControlsUpdateMessage",
        "name": "/handle",
        "wxyz": wxyz if isinstance(wxyz, str) else list(wxyz),
        "position": position,
        "owner": "",
        **others,
    }


def test_the_tool_follows_its_handle(window):
    """The tool is where the handle was dragged, the sliders show the pose, and the handle is at the
    tool once it is let go.
    """
    joints, *_ = controls(window)
    steps = [
        {"type": f"TransformControlsDrag{end}Message", "name": "/handle", "owner": ""}
        for end in ("Start", "End")
    ]
    with connected(window) as send:
        send(CAMERA)
        send(update(joints[0], value=20))
        wait(lambda: math.isclose(window._session.q[0], math.radians(20)))
        point = tool_points(window._session.arm, window._session.q)[0] + [-0.02, 0.03, 0.0]

        def there():
            return np.allclose(tool_points(window._session.arm, window._session.q), point)

        send(steps[0])
        send(drag(point.tolist()))
        wait(there)
        wait(lambda: abs(joints[0].value - math.degrees(window._session.q[0])) <= 0.5)
        send(drag([9.0, 0.0, 0.0]))
        wait(lambda: not there())
        send(steps[1])
        wait(lambda: np.linalg.norm(window._scene._handle.position) < 1.0)


NUMBERS = [
    math.nan,
    math.inf,
    -math.inf,
    1e9,
    -1e9,
    -1,
    2**63,
    "1",
    "nan",
    b"1",
    True,
    None,
    [],
    [1.0],
    {},
    {"value": 1.0},
]


def hostile(window):
    """Yield messages that must have no effect."""
    joints, payload, switch, chooser, button = controls(window)
    yield from (update(payload, value=value) for value in NUMBERS)
    yield from (update(joints[0], value=value) for value in NUMBERS if value != -1)
    yield from (update(switch, value=value) for value in (1, "true", None, [], math.nan))
    yield from (
        update(chooser, value=value) for value in ("no such part", "", 1, None, ["half"], {"a": 1})
    )
    yield from (update(button, value=value) for value in (False, 1, "x", None))
    for control in (payload, switch, chooser, button):
        names = [
            "min",
            "max",
            "step",
            "update_cb",
            "sync_cb",
            "gui_api",
            "removed",
            "is_button",
            "props",
            "visible",
            "disabled",
            "label",
            "__class__",
        ]
        yield from (
            update(control, **{name: value}) for name in names for value in (1e12, None, "x")
        )
        yield update(control, value=control.value if control is not button else True, visible=False)
        yield {**update(control, value=1.0), "owner": "x"}
    yield {"type": "GuiUpdateMessage", "uuid": "unknown", "updates": {"value": 1.0}}
    yield {"type": "GuiUpdateMessage", "uuid": payload._impl.uuid, "updates": [1]}
    yield {"type": "GuiUpdateMessage", "uuid": [], "updates": {"value": 1.0}}
    for kind in (
        "ShareUrlRequest",
        "ShareUrlDisconnect",
        "GuiFormSubmitMessage",
        "CommandTriggerMessage",
        "RunJavascriptMessage",
        "Message",
        "",
        1,
    ):
        yield {"type": kind}
    yield {
        "type": "FileTransferStartUpload",
        "source_component_uuid": "x",
        "transfer_uuid": "x",
        "filename": "x",
        "mime_type": "x",
        "part_count": 1,
    }
    yield {**CAMERA, "position": [math.nan, 0.0, 0.0]}
    yield {**CAMERA, "position": "x" * 1000}
    click = {
        "type": "ScenePointerMessage",
        "event_type": "click",
        "screen_pos": [[0.5, 0.5]],
        "modifier": None,
    }
    for origin, direction in (
        ([0.0] * 3, [0.0] * 3),
        ([math.nan] * 3, [1.0] * 3),
        ([0.0] * 2, [1.0] * 3),
        (None, None),
        ("abc", "abc"),
    ):
        yield {**click, "ray_origin": origin, "ray_direction": direction}
    far = [1e9, 0.0, 0.0]
    yield from map(drag, (far, [math.nan, 0.0, 0.0], [0.1, 0.2], "abc", None, [[0.1] * 3] * 3))
    yield from (drag([0.1, 0.2, 0.3], wxyz) for wxyz in ([1.0] * 3, [math.inf] * 4, "abcd"))
    yield from (drag([0.1] * 3, **more) for more in ({"owner": "x"}, {"name": "x"}, {"a": 1}))
    yield {"type": "TransformControlsDragStartMessage", "name": "/base", "owner": ""}
    yield {"type": "TransformControlsDragEndMessage", "name": "/handle", "owner": "", "x": 1}
    yield from (
        b"",
        b"\xc1",
        b"\x81" * 5000,
        b"\x91" * 50_000,
        b"{}",
        "text",
        b"\xdf\xff\xff\xff\xff",
        b"\xc7\x01\x05x",
    )


def test_no_other_message_has_an_effect(window, monkeypatch, capfd):
    """Values beyond their range or of another type, other attributes, unknown messages, and viser's
    request to open a public tunnel.
    """
    import viser

    asked = []
    monkeypatch.setattr(
        viser.ViserServer, "request_share_url", lambda *_, **__: asked.append("tunnel")
    )
    joints, *_ = controls(window)
    with connected(window) as send:
        send(CAMERA)
        send(update(joints[0], value=5))
        wait(lambda: math.isclose(window._session.q[0], math.radians(5)))
        before, choices, q = attributes(window), window._session.choices, window._session.q
        for message in hostile(window):
            send(message)
        send(update(joints[1], value=-7))  # messages are handled in their order
        wait(lambda: math.isclose(window._session.q[1], math.radians(-7)))
        send(update(joints[1], value=float(before[1]["value"])))
        wait(
            lambda: (
                window._session.q[1] == q[1]
                or math.isclose(window._session.q[1], math.radians(float(before[1]["value"])))
            )
        )
    assert attributes(window) == before
    assert window._session.choices == choices
    np.testing.assert_array_equal(window._session.q[[0, 2, 3]], q[[0, 2, 3]])
    assert asked == []
    assert window._failure is None
    assert "Traceback" not in "".join(capfd.readouterr())


def test_a_session_takes_no_value_that_a_file_could_not_state(window):
    """Whoever calls it: the state before stays."""
    session = window._session
    before, q = session.choices, session.q
    for payload in (math.nan, math.inf, -1.0, 1e300):
        with pytest.raises(ValueError, match="mass"):
            session.choose(payload=payload)
        with pytest.raises(ValueError, match="mass"):
            Choices(payload)
    for values in (np.full(4, np.nan), np.array([np.inf, 0, 0, 0])):
        with pytest.raises(ValueError, match="finite"):
            session.move(values)
    with pytest.raises(ValueError, match="finite"):
        session.move_joint(0, math.nan)
    assert session.choices == before
    np.testing.assert_array_equal(session.q, q)


def test_a_server_that_cannot_be_guarded_is_not_used():
    """Where viser would start it in another way, the view ends with a message."""
    from lostmotion.live_view.guard import Guard

    with pytest.raises(lostmotion.LostmotionError, match="protect"), Guard().in_front():
        pass


PAGE = b"<!doctype html><link rel='icon' href='data:,'><body></body>"
OPEN = """(address => new Promise(done => {
    const socket = new WebSocket(address);
    socket.onopen = () => done('open');
    socket.onclose = () => done('refused');
}))"""


class Stranger(http.server.BaseHTTPRequestHandler):
    """A page of somebody else."""

    def do_GET(self) -> None:
        """Return the page."""
        self.send_response(200)
        self.send_header("Content-Type", "text/html")
        self.end_headers()
        self.wfile.write(PAGE)

    def log_message(self, *_: object) -> None:
        """Print nothing."""


@pytest.mark.slow
@pytest.mark.skipif(CHROMIUM is None, reason="no Chromium on this machine")
def test_the_page_of_a_stranger_in_a_real_browser_reaches_nothing(window):
    """Not even one that has learned the token: neither by websocket, nor by reading the page, nor
    by showing it in a frame.
    """
    address = urlsplit(window.url)
    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Stranger)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    try:
        with Browser(f"http://127.0.0.1:{server.server_port}/") as page:
            websocket = f"ws://{address.netloc}{address.path}"
            for there in (
                websocket,
                f"ws://{address.netloc}/",
                f"ws://localhost:{address.port}{address.path}",
            ):
                assert page.value(f"{OPEN}('{there}')") == "refused"
            assert (
                page.value(f"fetch('{window.url}').then(() => 'read', () => 'refused')")
                == "refused"
            )
            frame = f"""new Promise(done => {{ const frame = document.createElement('iframe'); frame.src = '{window.url}';
                frame.onload = () => done('loaded'); document.body.append(frame); }})"""
            page.value(frame)
            assert any("frame-ancestors" in error for error in page.errors)
            page.open(window.url)
            page.wait("document.querySelector('#lm-all') !== null")
            assert page.value(f"{OPEN}('{websocket}')") == "open"
    finally:
        server.shutdown()
        server.server_close()
