"""How long after a slider has changed does the live view show the changed number, and which share
of that is transport, computation and page?

    python benchmarks/live_view.py [--presses 40] [--size 1440x900] [ARM ...]

Needs Chromium and the extra `view`. View and browser run on this machine. Keys are pressed and
sliders are dragged in the page; events and changes of the page are timed in the page, by the clock
that the server reads too. Chromium draws by software here, which takes far longer than on a
graphics card. So each arm is measured once with its picture, and once with a page whose drawing
commands do nothing.
"""

from __future__ import annotations

import argparse
import sys
import time
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

import lostmotion
from lostmotion.live_view.picture import first_pose
from lostmotion.live_view.session import Figures, Session
from lostmotion.live_view.window import Window

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT))  # for the browser of the tests

from tests.browser.chromium import Browser  # noqa: E402 - as above

FILES = ("z-arm.toml", "ur5e.urdf", "arm-from-drawings.toml")
COLUMNS = ("to server", "computing", "processor", "to page", "key", "95 %", "drag", "95 %", "frame")
WITHOUT_DRAWING = """
for (const kind of [WebGLRenderingContext, WebGL2RenderingContext])
  for (const name of ['drawElements', 'drawArrays', 'drawElementsInstanced', 'drawArraysInstanced', 'clear'])
    if (name in kind.prototype) kind.prototype[name] = () => {};
"""  # noqa: E501
# Times in the page are in ms since 1970, of the event itself where it is one, so that waiting for
# the page counts.
WATCH = """
window.lm = {pressed: [], shown: [], frames: [], text: null};
for (const kind of ['keydown', 'pointermove'])
  window.addEventListener(kind, event => lm.pressed.push(performance.timeOrigin + event.timeStamp), true);
new MutationObserver(() => {
  const text = document.querySelector('#lm-q95')?.textContent;
  if (text !== lm.text) { lm.text = text; lm.shown.push([performance.timeOrigin + performance.now(), text]); }
}).observe(document.body, {subtree: true, childList: true, characterData: true});
const frame = now => { lm.frames.push(now); requestAnimationFrame(frame); };
requestAnimationFrame(frame);
"""  # noqa: E501


@dataclass
class Times:
    """Times of each change in ms: from the page to the server, computing there, of that the
    processor's time, back to the page, and in all.
    """

    there: list[float] = field(default_factory=list)
    computing: list[float] = field(default_factory=list)
    processor: list[float] = field(default_factory=list)
    back: list[float] = field(default_factory=list)
    all: list[float] = field(default_factory=list)
    dragged: list[float] = field(default_factory=list)


class Timed(Session):
    """A session that notes when it is asked for a pose, and when the figures are computed, in ms
    since 1970.
    """

    asked: float = 0.0
    computed: float = 0.0
    processor: float = 0.0

    def move_joint(self, index: int, value: float) -> None:
        self.asked = 1e3 * time.time()
        super().move_joint(index, value)

    def step(self):
        begun = time.thread_time()
        found = super().step()
        if isinstance(found, Figures):
            self.computed, self.processor = 1e3 * time.time(), 1e3 * (time.thread_time() - begun)
        return found


def press(page: Browser, session: Timed, times: Times, key: tuple[str, int]) -> None:
    """Press a key on the slider that has the focus; nothing is noted where the number stays the
    same to its digits.
    """
    page.value("lm.pressed.length = lm.shown.length = 0")
    page.key(*key)
    end = time.monotonic() + 3
    while not (shown := page.value("lm.shown")) and time.monotonic() < end:
        time.sleep(0.02)
    time.sleep(0.3)  # the next change is not to find the page still at work on this one
    if shown and len(shown) == 1:
        pressed = page.value("lm.pressed[0]")
        times.there.append(session.asked - pressed)
        times.computing.append(session.computed - session.asked)
        times.processor.append(session.processor)
        times.back.append(shown[0][0] - session.computed)
        times.all.append(shown[0][0] - pressed)


def drag(page: Browser, times: Times, joint: int, *, back: bool) -> None:
    """Drag a slider for half a second, and note the time from its last move to the number that
    stays.
    """
    box = page.value(
        "(box => [box.x + box.width / 2, box.y + box.height / "
        f"2])(document.querySelectorAll('[role=slider]')[{joint}].getBoundingClientRect())"
    )
    x, y = box
    page.value("lm.pressed.length = lm.shown.length = 0")
    page.ask("Input.dispatchMouseEvent", type="mouseMoved", x=x, y=y)
    page.ask("Input.dispatchMouseEvent", type="mousePressed", x=x, y=y, button="left", clickCount=1)
    for k in range(1, 31):
        page.ask(
            "Input.dispatchMouseEvent",
            type="mouseMoved",
            x=x + (-k if back else k),
            y=y,
            button="left",
            buttons=1,
        )
        time.sleep(0.016)
    time.sleep(1.5)
    pressed, shown = page.value("[lm.pressed, lm.shown]")
    page.ask(
        "Input.dispatchMouseEvent",
        type="mouseReleased",
        x=x + (-30 if back else 30),
        y=y,
        button="left",
        clickCount=1,
    )
    time.sleep(0.3)
    if shown and shown[-1][0] > pressed[-1]:
        times.dragged.append(shown[-1][0] - pressed[-1])


def measure(path: Path, presses: int, size: tuple[int, int], *, draws: bool) -> list[float]:
    arm = lostmotion.read(path)
    poses = lostmotion.sample_poses(arm, 2048)
    session = Timed(arm, poses, first_pose(arm, poses))
    window = Window(
        session, poses, 8700, (path, None) if path.suffix == ".urdf" else None, lambda _: None
    )
    times = Times()
    try:
        with Browser(window.url, size) as page:
            page.wait(
                (
                    "document.querySelector('#lm-all') && "
                    "document.querySelector('#lm-all').textContent.endsWith('m')"
                ),
                120,
            )
            page.value(
                f"document.querySelectorAll('[role=slider]')[1].focus(); {WATCH}; "
                f"{'' if draws else WITHOUT_DRAWING}"
            )
            page.wait("lm.frames.length > 20", 300)  # events wait for the first pictures
            for k in range(presses):
                press(page, session, times, ("ArrowRight", 39) if k % 8 < 4 else ("ArrowLeft", 37))
            page.value("lm.frames.length = 0")
            for k in range(max(presses // 5, 2)):
                drag(page, times, 1, back=k % 2 == 1)
            frames = np.diff(page.value("lm.frames"))
    finally:
        window.stop()
    medians = [
        float(np.median(each))
        for each in (times.there, times.computing, times.processor, times.back)
    ]
    spread = [
        float(value)
        for each in (times.all, times.dragged)
        for value in (np.median(each), np.quantile(each, 0.95))
    ]
    return [*medians, *spread, float(np.median(frames))]


def main() -> None:
    words = argparse.ArgumentParser(description=__doc__)
    words.add_argument("arms", nargs="*", type=Path)
    words.add_argument("--presses", type=int, default=40)
    words.add_argument(
        "--size", action="append", help="of the window, in pixels; several times for several sizes"
    )
    asked = words.parse_args()
    print(
        "milliseconds: medians, and 95th percentiles from a key press, and from the end of a "
        "drag, to the number; frame: between two pictures\n"
    )
    print(f"{'arm':24}{'window':>10}{'picture':>9}" + "".join(f"{name:>11}" for name in COLUMNS))
    for path in asked.arms or [ROOT / "examples" / name for name in FILES]:
        for text, draws in [
            (size, draws)
            for size in asked.size or ("1440x900", "500x300")
            for draws in (True, False)
        ]:
            found = measure(path, asked.presses, tuple(map(int, text.split("x"))), draws=draws)
            print(
                f"{path.name:24}{text:>10}{'drawn' if draws else 'none':>9}"
                + "".join(f"{value:11.1f}" for value in found),
                flush=True,
            )


if __name__ == "__main__":
    main()
