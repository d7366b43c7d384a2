"""The panel of the view: sliders, switches and lists that change the session, and the texts and
bars that show its figures.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final

from lostmotion.error_model.provenance import states
from lostmotion.live_view import panel
from lostmotion.live_view.choices import AS_IN_FILE, gearbox_names, section_names
from lostmotion.live_view.guard import is_number
from lostmotion.printed import round_number

if TYPE_CHECKING:
    from collections.abc import Callable

    from lostmotion.error_model.provenance import States
    from lostmotion.live_view.picture import Classes
    from lostmotion.live_view.session import ErrorOverWorkspace, Figures, Session
    from lostmotion.mechanism.arm import Arm
    from lostmotion.parts.joint import Joint, PrismaticJoint, RevoluteJoint
    from lostmotion.spatial import Floats

# Degrees or millimetres per step of a slider, unless its range is shorter than this many steps;
# then a round share of the range.
_STEP: Final = 1.0
_FEWEST_STEPS: Final = 50
# Largest payload of the slider: a multiple of the file's, at least a share of the arm's own mass,
# kg.
_PAYLOADS, _OF_ARM, _LEAST_PAYLOAD = 2.0, 0.25, 1.0


class Controls:
    """The panel of one view. `gui` is that of a viser server; `redraw` is called where the picture
    changes and no figure does.

    checks  whether a control can take a value, by the control's identifier: of what a browser sends
            nothing else is to reach viser
    """

    def __init__(
        self,
        gui: Any,  # noqa: ANN401
        session: Session,
        redraw: Callable[[], None],
        announce: Callable[[str], None],
    ) -> None:
        """Build the panel."""
        self._gui, self._session, self._redraw, self._announce = gui, session, redraw, announce
        self.checks: dict[str, Callable[[object], bool]] = {}
        self._refit = False
        self._stated: tuple[Arm, States] | None = None
        arm = session.arm
        self._headline, self._legend, self._warning = (
            gui.add_html(""),
            gui.add_html(""),
            gui.add_html(""),
        )
        with gui.add_folder("Pose"):
            self._sliders = [
                self._joint_slider(k, joint, value)
                for k, (joint, value) in enumerate(zip(arm.driven, session.q.tolist(), strict=True))
            ]
            # What each slider shows by itself: setting it calls its callback, which must not move
            # the arm again.
            self._shown = [slider.value for slider in self._sliders]
            self._add_payload(arm)
        with gui.add_folder("What if the arm is"):
            self._add_switch(
                "compensated",
                "compensated",
                "The controller corrects every deflection that load and pose determine.",
            )
            self._add_switch(
                "calibrated",
                "calibrated",
                "Lengths, axes and encoder zeros of each robot are identified.",
            )
        self._budget, self._torques = gui.add_html(""), gui.add_html("")
        offers = [
            (f"{joint.name} {part}", joint, words, choose)
            for joint in arm.joints
            for part, words, choose in (
                ("gearbox", gearbox_names(joint), session.choose_gearbox),
                ("link", section_names(arm, joint), session.choose_section),
            )
            if words
        ]
        if offers:
            with gui.add_folder("Other parts", expand_by_default=False):
                for offer in offers:
                    self._add_list(*offer)
        with gui.add_folder("Picture"):
            self.shown = gui.add_dropdown(
                "workspace", ("half", "all", "none"), hint="Click a point to go there."
            )
            self.shown.on_update(lambda _: redraw())
            self._allow_one_of(self.shown)
            for label, act in (
                ("Fit colours to these errors", self._ask_refit),
                ("Print this pose as --at", self._print_pose),
            ):
                self._add_button(label, act)
            self._pose_text = gui.add_html("")
        self._status = gui.add_html("")

    def show(
        self,
        figures: Figures,
        over_all: ErrorOverWorkspace | None,
        factor: float | None,
        count: int,
        milliseconds: float,
    ) -> None:
        """Show the figures at a pose."""
        self._headline.content = panel.headline(figures, over_all, factor, self._known())
        self._budget.content = panel.budget_bars(figures.costs)
        self._torques.content = panel.torque_bars(self._session.arm, figures)
        self._status.content = panel.status(count, milliseconds)

    def _known(self) -> States:
        """Return the states of the kinds of error of the arm as it is chosen, computed once per
        choice.
        """
        arm = self._session.arm
        if self._stated is None or self._stated[0] is not arm:
            self._stated = arm, states(arm)
        return self._stated[1]

    def show_legend(self, classes: Classes) -> None:
        """Show the colour classes."""
        self._legend.content = panel.legend(classes, lower_bound=self._known().lower_bound)

    def warn(self, text: str) -> None:
        """Show why something could not be computed."""
        self._warning.content = panel.warning(text)

    def take_refit(self) -> bool:
        """Return whether new colour classes were asked for since the last call."""
        asked, self._refit = self._refit, False
        return asked

    def go_to(self, q: Floats) -> None:
        """Go to a pose q (joint,), rad and m, and let the sliders show it."""
        self._session.move(q)
        self.show_pose(q)

    def show_pose(self, q: Floats) -> None:
        """Let the sliders show a pose q (joint,), rad and m, rounded to their steps."""
        for k, (slider, joint, value) in enumerate(
            zip(self._sliders, self._session.arm.driven, q.tolist(), strict=True)
        ):
            low = slider.min
            shown = min(
                max(low + slider.step * round((_displayed(joint, value) - low) / slider.step), low),
                slider.max,
            )
            self._shown[k] = slider.value = round(shown, 6)

    def _joint_slider(self, index: int, joint: RevoluteJoint | PrismaticJoint, value: float) -> Any:  # noqa: ANN401 - a handle of viser
        low, high = (round(_displayed(joint, limit), 6) for limit in joint.limits)
        step = min(_STEP, round_number((high - low) / _FEWEST_STEPS))
        start = min(
            max(round(low + step * round((_displayed(joint, value) - low) / step), 6), low), high
        )
        slider = self._gui.add_slider(
            f"{joint.name} [{'°' if joint.type == 'revolute' else 'mm'}]", low, high, step, start
        )
        slider.on_update(lambda _: self._on_slider(index, joint))
        self._allow_within(slider)
        return slider

    def _on_slider(self, index: int, joint: Joint) -> None:
        value = self._sliders[index].value
        if value != self._shown[index]:
            self._shown[index] = value
            self._session.move_joint(
                index, math.radians(value) if joint.type == "revolute" else value * 1e-3
            )

    def _add_payload(self, arm: Arm) -> None:
        most = round_number(max(_PAYLOADS * arm.payload.mass, _OF_ARM * arm.mass, _LEAST_PAYLOAD))
        most = max(most, arm.payload.mass)
        slider = self._gui.add_slider(
            "payload [kg]", 0.0, most, round_number(most / 100), arm.payload.mass
        )
        slider.on_update(lambda _: self._session.choose(payload=float(slider.value)))
        self._allow_within(slider)

    def _add_switch(self, label: str, name: str, hint: str) -> None:
        switch = self._gui.add_checkbox(label, initial_value=False, hint=hint)
        switch.on_update(lambda _: self._session.choose(**{name: bool(switch.value)}))
        self.checks[_identifier(switch)] = lambda value: isinstance(value, bool)

    def _add_list(
        self, label: str, joint: Joint, words: list[str], choose: Callable[[str, str], None]
    ) -> None:
        chooser = self._gui.add_dropdown(label, (AS_IN_FILE, *words))
        chooser.on_update(lambda _: choose(joint.name, str(chooser.value)))
        self._allow_one_of(chooser)

    def _add_button(self, label: str, act: Callable[[], None]) -> None:
        button = self._gui.add_button(label)
        button.on_click(lambda _: act())
        self.checks[_identifier(button)] = lambda value: value is True

    def _allow_within(self, slider: Any) -> None:  # noqa: ANN401 - a handle of viser
        low, high = slider.min, slider.max
        self.checks[_identifier(slider)] = lambda value: is_number(value) and low <= value <= high

    def _allow_one_of(self, chooser: Any) -> None:  # noqa: ANN401 - a handle of viser
        words = tuple(chooser.options)
        self.checks[_identifier(chooser)] = lambda value: isinstance(value, str) and value in words

    def _print_pose(self) -> None:
        text = panel.pose_option(self._session.arm, self._session.q)
        self._pose_text.content = panel.text_to_copy(text)
        self._announce(text)

    def _ask_refit(self) -> None:
        self._refit = True
        self._redraw()


def _identifier(control: Any) -> str:  # noqa: ANN401 - a handle of viser
    """Return the identifier of a control in messages; viser has no public name for it."""
    return str(control._impl.uuid)  # noqa: SLF001


def _displayed(joint: Joint, value: float) -> float:
    """Return a joint value in degrees or millimetres."""
    return math.degrees(value) if joint.type == "revolute" else value * 1e3
