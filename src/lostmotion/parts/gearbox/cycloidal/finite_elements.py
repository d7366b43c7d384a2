"""One disc of each stage of a cycloidal gearbox by finite elements: rotation, loads and stresses
over the torque.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from lostmotion.errors import refuse_argument
from lostmotion.laws.cycloid.drive import LEAST_ARM
from lostmotion.laws.cycloid.envelope import second_contacts
from lostmotion.laws.cycloid.finite_elements.mesh import Meshes, check_installed
from lostmotion.laws.cycloid.finite_elements.stage import loaded_stage
from lostmotion.laws.cycloid.geometry import first_contact_angle, gaps, pin_angles
from lostmotion.parts.gearbox.cycloidal.samples import disc_share
from lostmotion.parts.gearbox.kinds import is_drawn

if TYPE_CHECKING:
    from collections.abc import Callable

    from lostmotion.laws.annulus import Plane
    from lostmotion.laws.cycloid.finite_elements.stage import Loaded
    from lostmotion.laws.cycloid.finite_elements.wheel import Field
    from lostmotion.laws.cycloid.stage import Modification, Stage
    from lostmotion.parts.gearbox.cycloidal import CycloidalGearbox
    from lostmotion.parts.gearbox.cycloidal.stage import CycloidalStage
    from lostmotion.spatial import Floats

# The meshed wheels of a stage, in order.
BODIES: Final = ("disc", "ring")
# Torques, as shares of the largest.
_LEVELS: Final = (0.1, 0.25, 0.5, 1.0)
# Intervals of a contact on the coarser mesh without refinement.
_INTERVALS: Final = 5
# Terms of the displacements over the width in three dimensions: a second one changes the rotation
# by 0.4 % and takes four times as long.
_TERMS: Final = 1


@dataclass(frozen=True, slots=True)
class Largest:
    """Where a field is largest: the value, the place (complex, m, in the plane of the stage), and
    the body, "disc" or "ring".
    """

    value: float
    place: complex
    body: str


@dataclass(frozen=True)
class FiniteElements:
    """A stage by finite elements, its crank at zero, each disc with the same share of the torque;
    torques and angles at the output of the gearbox.

    name      "output stage" or "first stage"
    torque    (torque,) N m at the output
    rotation  (2, torque) rad, beyond the play: in plane strain and in plane stress
    rotation_3d  (torque,) rad, the same in three dimensions; None unless asked for. error_3d:
                 (torque,) rad, difference between two meshes unknowns  of both wheels, in three
                 dimensions if asked for
    error     (torque,) rad, difference between two meshes
    stiffness (torque,) N m/rad, derivative of the torque by the rotation, plane strain
    stress    (torque,) largest von Mises stress, Pa; strain (torque,) largest equivalent strain:
              von Mises stress over 3 G. Plane strain
    loaded    the disc under its share of the torque, plane strain; stage as meshed
    fields    displacement and stress of the wheels under the largest torque; turn: rotation of the
              disc there, rad
    not_meshed  another stage of the gearbox that is not meshed, and why; empty without such a stage
    most_stressed, most_strained  the largest von Mises stress (Pa) and equivalent strain under the
                                  largest torque, at the integration points
    """

    name: str
    torque: Floats
    rotation: Floats
    rotation_3d: Floats | None
    error_3d: Floats | None
    unknowns: int
    error: Floats
    stiffness: Floats
    stress: Floats
    strain: Floats
    loaded: Loaded
    stage: Stage
    fields: list[Field]
    turn: float
    not_meshed: str
    most_stressed: Largest
    most_strained: Largest


def check_fem(gearbox: object) -> CycloidalGearbox:
    """Return a gearbox whose drawing can be meshed. Raises InputError for another, LostmotionError
    without NGSolve.
    """
    if not is_drawn(gearbox):
        found = f"a gearbox of kind '{getattr(gearbox, 'kind', type(gearbox).__name__)}'"
        raise refuse_argument("fem", found, "a gearbox with a drawing, of kind 'cycloidal'")
    drawn: Any = gearbox
    if drawn.disc_bore_radius is None:
        raise refuse_argument(
            "fem",
            "a drawing without disc_bore_radius",
            'the inner radius of the disc, such as disc_bore_radius = "20 mm"',
        )
    if drawn.eccentric.cranks > 1:
        raise refuse_argument(
            "fem",
            "discs on several cranks",
            "discs on one central eccentric; others are not meshed",
        )
    check_installed()
    return drawn  # type: ignore[no-any-return]


def _unmeshed_stage(gearbox: CycloidalGearbox) -> str:
    """Return which stage of a gearbox is not meshed, and why; empty without such a stage."""
    first = gearbox.first_stage
    if first is None or _meshed_first_stage(gearbox) is not None:
        return ""
    return (
        "planetary first stage"
        if first.kind == "planetary"
        else "first stage, because its drawing has no disc_bore_radius"
    )


def _meshed_first_stage(gearbox: CycloidalGearbox) -> CycloidalStage | None:
    """Return the first stage of a gearbox if it is cycloidal and states the inner radius of its
    disc.
    """
    first = gearbox.cycloidal_first_stage
    return None if first is None or first.disc_bore_radius is None else first


@dataclass(frozen=True, slots=True)
class Mesh:
    """Finite elements: their order, how many times smaller than usual they are, and whether to
    solve disc and ring over their width as well.
    """

    order: int = 2
    refinement: int = 1
    three_dimensions: bool = False

    @property
    def solves(self) -> int:
        """Return the number of solves of each stage."""
        return 2 + self.three_dimensions


def finite_elements(
    gearbox: CycloidalGearbox,
    torque: float,
    mesh: Mesh | None = None,
    progress: Callable[[str, int, int], None] | None = None,
) -> tuple[FiniteElements, ...]:
    """Return the stage at the output, and a cycloidal first stage, under torques up to `torque` (N
    m at the output) by finite elements.

    Raises InputError for a drawing that cannot be meshed, DidNotConvergeError where the contacts
    outgrow their lobes.
    """
    mesh = mesh or Mesh()
    stages: list[tuple[str, CycloidalStage, float]] = [
        ("output stage", check_fem(gearbox), disc_share(gearbox))
    ]
    first = _meshed_first_stage(gearbox)
    if first is not None:
        stages.append(("first stage", first, 1 / abs(gearbox.steps)))

    def shown(what: str, number: int, done: int, of: int) -> None:
        if progress is not None:
            progress(what, number * of + done, len(stages) * mesh.solves * of)

    out: list[FiniteElements] = []
    for name, part, per_output in stages:
        found = _by_elements((name, part, per_output), torque, shown, len(out) * mesh.solves, mesh)
        out.append(replace(found, not_meshed=_unmeshed_stage(gearbox)))
    return tuple(out)


def _by_elements(
    named: tuple[str, CycloidalStage, float],
    torque: float,
    progress: Callable[[str, int, int, int], None],
    before: int,
    mesh: Mesh,
) -> FiniteElements:
    """Return one stage; with its name and the torque on all its discs per torque at the output.
    `before` counts the solves before it.
    """
    name, part, per_output = named
    drive = part.drive
    stage, body = drive.stage, drive.disc_body
    if body is None:
        # a stage without the inner radius of its disc, which is not meshed
        raise ValueError("a rigid disc")
    torques = torque * np.array(_LEVELS)
    play = _first_contact(stage, drive.relief)
    found: list[Loaded] = []
    meshes = Meshes()
    solved: list[tuple[Plane, int]] = [("strain", 0), ("stress", 0), ("strain", _TERMS)]
    for number, (plane, terms) in enumerate(solved[: mesh.solves]):
        disc = replace(body, plane=plane)
        ring = drive.ring_body and replace(drive.ring_body, plane=plane)

        def shown(what: str, done: int, of: int, number: int = before + number) -> None:
            progress(f"{what} ({name})", number, done, of)

        try:
            loads = per_output / drive.discs * torques
            found.append(
                loaded_stage(
                    stage,
                    disc,
                    ring,
                    part.width,
                    loads,
                    relief=drive.relief,
                    order=mesh.order,
                    intervals=_INTERVALS * mesh.refinement,
                    terms=terms,
                    meshes=meshes,
                    progress=shown,
                )
            )
        except ValueError as error:
            raise refuse_argument(
                "fem", f"a drawing whose {name} cannot be meshed", f"another drawing: {error}"
            ) from error
    loaded = found[0]
    largest = np.array([loaded.largest(k) for k in range(len(torques))])
    most_stressed, most_strained = _largest(loaded)
    rotations = np.array([per_output * (each.rotation - play) for each in found])
    return FiniteElements(
        name=name,
        torque=torques,
        rotation=rotations[:2],
        rotation_3d=rotations[2] if mesh.three_dimensions else None,
        error_3d=per_output * found[2].error if mesh.three_dimensions else None,
        unknowns=sum(wheel.unknowns for wheel in found[-1].wheels),
        error=per_output * loaded.error,
        stiffness=loaded.stiffness * drive.discs / per_output**2,
        stress=largest[:, 0],
        strain=largest[:, 1],
        loaded=loaded,
        stage=stage,
        fields=loaded.fields(len(torques) - 1),
        turn=float(loaded.rotation[-1]),
        not_meshed="",
        most_stressed=most_stressed,
        most_strained=most_strained,
    )


def _largest(loaded: Loaded) -> list[Largest]:
    """Return where the von Mises stress and the equivalent strain of both wheels are largest under
    the largest torque.
    """
    pressure = loaded.pressures[-1]
    of_wheels = np.array([wheel.largest(pressure) for wheel in loaded.wheels])
    bodies = of_wheels.argmax(axis=0).tolist()
    # in one wheel both are at one place, for there they are proportional
    places = {k: loaded.wheels[k].place_of_largest(pressure) for k in set(bodies)}
    return [
        Largest(float(of_wheels[k, field]), places[k], BODIES[k]) for field, k in enumerate(bodies)
    ]


def _first_contact(stage: Stage, relief: Modification) -> float:
    """Return the free rotation (rad) of a disc from its position without gaps to its first contact,
    of either branch of an envelope ring.
    """
    theta = pin_angles(stage, np.zeros(1))[0]
    if stage.kind == "lobe envelope":
        second = second_contacts(stage, [0.0])[0]
        theta = np.append(theta, -stage.lobes * second[np.isfinite(second)])
    return float(first_contact_angle(stage, theta, gaps(stage, theta, relief), LEAST_ARM))
