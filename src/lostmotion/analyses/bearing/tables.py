"""The figures of a bearing: its clearance, the load of its elements, displacement and stiffness of
the shaft, its contribution to an arm's error.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.error_model.share_intervals import share_interval
from lostmotion.parts.bearing.fits import STEPS
from lostmotion.parts.term import Condition, Motion
from lostmotion.printed import ARCMIN, stated_text
from lostmotion.reporting.provenance import with_inputs
from lostmotion.reporting.sheet import Card, Cell, Row, Section, Sheet, length

if TYPE_CHECKING:
    from lostmotion.analyses.bearing.bearing import BearingLoad, Examined
    from lostmotion.parts.moving_joint import Bearing
    from lostmotion.parts.term import Term

_WORDS: Final = (
    (
        "clearance",
        (
            "diametral clearance: how far one ring moves across the other without load, from end "
            "to end. Below zero the bearing is preloaded."
        ),
    ),
    (
        "delivered, mounted, working",
        (
            "as bought; on its shaft and in its housing, whose fits reduce it; and at working "
            "temperature."
        ),
    ),
    (
        "mean",
        (
            "over manufactured bearings. Figures under load are those of the mean bearing; a "
            "loose fit changes no clearance, however loose."
        ),
    ),
    ("lowest, highest", "limits of the clearance while every dimension is within its own."),
    ("shift, tilt", "of the shaft against the housing, midway between the bearings."),
    (
        "stiffness",
        (
            "against one more newton or newton metre in a direction at this load, all other "
            "directions free."
        ),
    ),
    (
        "design, robot, visit",
        "the same in every arm; different for each bearing; different at each visit to a pose.",
    ),
)
# Tilts below this, in arcmin, are those of the discrete elements and of rounding.
_LEAST_TILT: Final = 0.001
_STEP_NOTES: Final = {
    "delivered": "",
    "mounted": "less the effect of the fits",
    "working": "less the effect of the temperature rise",
}


def bearing_sheet(
    name: str,
    bearing: Bearing,
    load: BearingLoad,
    examined: Examined | None,
    notes: tuple[str, ...] = (),
) -> Sheet:
    """Return the sheet of a bearing under a load. `examined` where it is described by its
    drawing.
    """
    load_text = described(load)
    if examined is None:
        verdict = (
            f"Described by its stated values, not by its drawing. Under {load_text} the table "
            "shows what it adds to an arm's error."
        )
        sheet = Sheet(
            name=name,
            subject="bearing",
            verdict=verdict,
            cards=(),
            sections=(_stated(bearing), _terms(bearing, load)),
            notes=notes,
            words=_WORDS,
            source=f"load: {load_text}",
        )
        return with_inputs(sheet, bearing, "bearing")
    sections = (
        _clearance(examined),
        _samples(examined),
        _play(examined),
        _shifts(examined),
        _elements(examined),
        _stiffness(examined),
    )
    sheet = Sheet(
        name=name,
        subject="bearing",
        counts=f"{load_text}; {examined.count} simulated bearings, seed {examined.seed}",
        verdict=_verdict(examined),
        cards=tuple(_cards(examined)),
        sections=sections if examined.bearing.is_single else (*sections, _terms(bearing, load)),
        notes=(*notes, *_doubts(examined)),
        words=_WORDS,
        source=(
            f"seed {examined.seed}, {examined.count} simulated bearings; load: {load_text}. The "
            "same input and version give the same bytes."
        ),
        seed=examined.seed,
        facts={
            "bearing": name,
            "seed": examined.seed,
            "built": examined.count,
            "load": _plain_load(load),
        },
    )
    return with_inputs(sheet, bearing, "bearing")


def described(load: BearingLoad) -> str:
    """Describe a load."""
    parts = [(load.radial, "N across"), (load.axial, "N along the axis"), (load.moment, "N m")]
    return ", ".join(f"{stated_text(value)} {unit}" for value, unit in parts if value) or "no load"


def _plain_load(load: BearingLoad) -> dict[str, float]:
    return {"radial_N": load.radial, "axial_N": load.axial, "moment_Nm": load.moment}


def _micro(value: float, samples: str = "") -> Cell:
    return Cell(value, "µm", samples=samples)


def _angle(value: float, samples: str = "") -> Cell:
    return Cell(float(value), "arcmin", samples=samples)


def _verdict(found: Examined) -> str:
    low, mean, high = (str(_micro(each)).removesuffix(" µm") for each in found.clearances)
    shift, tilt = _across(found)[1], _tilt(found)[1]
    sentences = [f"Working clearance {mean} µm on average, between {low} and {high} µm."]
    preloaded = float((found.samples["working"] < 0).mean())
    if 0 < preloaded < 1:
        sentences.append(f"{100 * preloaded:.0f} % of the bearings work under preload.")
    if found.settled.converged[1]:
        sentences.append(
            f"Under {described(found.load)} the shaft shifts by {length(shift)} and "
            f"{_tilts(tilt)} with the mean clearance."
        )
    else:
        sentences.append("The bearing cannot support this load: no equilibrium.")
    return " ".join(sentences)


def _tilts(tilt: float) -> str:
    """Return the words for a tilt; what is far below a second of arc is none."""
    return f"tilts by {_angle(tilt)}" if tilt / ARCMIN >= _LEAST_TILT else "does not tilt"


def _cards(found: Examined) -> list[Card]:
    working = found.bearing.spreads["working"]
    span = f"{str(_micro(working.lowest)).removesuffix(' µm')} … {_micro(working.highest)}"
    hardest = float(np.max([each[1].max() for each in found.settled.loads]))
    tilt = _tilt(found)[1]
    return [
        Card("working clearance", str(_micro(working.mean)), f"mean; limits {span}"),
        Card("shift across at this load", str(length(float(_across(found)[1]))), "mean clearance"),
        Card(
            "tilt at this load",
            str(_angle(tilt if tilt / ARCMIN >= _LEAST_TILT else 0.0)),
            "mean clearance",
        ),
        Card(
            "most heavily loaded element",
            str(Cell(hardest, "N")),
            f"{found.pressure[1] / 1e9:.2f} GPa",
        ),
        Card(
            "stiffness across",
            str(Cell(found.stiffness[0], "N/µm")),
            "tangent, at this load",
        ),
        Card(
            "stiffness against tilting",
            str(Cell(found.stiffness[4], "N m/arcmin")),
            "tangent, at this load",
        ),
    ]


def _across(found: Examined) -> np.ndarray:
    return np.asarray(np.hypot(found.settled.displacement[:, 0], found.settled.displacement[:, 1]))


def _tilt(found: Examined) -> np.ndarray:
    return np.asarray(np.hypot(found.settled.displacement[:, 3], found.settled.displacement[:, 4]))


def _clearance(found: Examined) -> Section:
    exact = "the limits of the dimensions"
    rows = []
    for step in STEPS:
        spread = found.bearing.spreads[step]
        figures = (spread.mean, spread.lowest, spread.highest, spread.deviation)
        rows.append(Row(step, tuple(_micro(value, exact) for value in figures), _STEP_NOTES[step]))
    return Section(
        "clearance",
        "From delivered to working clearance",
        ("mean", "lowest", "highest", "standard deviation"),
        tuple(rows),
    )


def _samples(found: Examined) -> Section:
    working = found.samples["working"]
    counted = f"{found.count} simulated bearings"
    low, high = share_interval(int((working < 0).sum()), found.count)
    half = (
        1.96 * float(working.std(ddof=1)) / math.sqrt(found.count) if found.count > 1 else math.nan
    )
    mean = float(working.mean())
    rows = (
        Row(
            "mean working clearance",
            (Cell(mean, "µm", mean - half, mean + half, counted),),
        ),
        Row("2.5th percentile", (_micro(float(np.quantile(working, 0.025)), counted),)),
        Row("97.5th percentile", (_micro(float(np.quantile(working, 0.975)), counted),)),
        Row(
            "work under preload",
            (Cell(float((working < 0).mean()), "%", low, high, counted),),
        ),
    )
    return Section(
        "built",
        "Simulated bearings",
        ("value",),
        rows,
        "each dimension drawn from its own distribution",
    )


def _play(found: Examined) -> Section:
    pair = found.bearing.rows
    exact = "the geometry of the play"
    values = np.maximum(found.clearances, 0.0)
    rows = [Row("across, either way", tuple(_micro(value / 2, exact) for value in values))]
    if found.axial is not None:
        along = np.where(found.clearances > 0, found.axial.shifts[:, 0], 0.0)
        rows.append(
            Row("along the axis, either way", tuple(_micro(value, exact) for value in along))
        )
    if not found.bearing.is_single:
        rows.append(
            Row(
                "tilt, either way",
                tuple(Cell(value / pair.span, "arcmin", samples=exact) for value in values),
            )
        )
    return Section(
        "play",
        "Play without load",
        _CASES,
        tuple(rows),
        "at the lowest, mean and highest working clearance",
    )


_CASES: Final = ("lowest clearance", "mean", "highest")


def _shifts(found: Examined) -> Section:
    solved = "a solution in five freedoms"
    displacement = found.settled.displacement
    rows = [Row("shift across", tuple(_micro(float(value), solved) for value in _across(found)))]
    if found.bearing.rows.axial:
        rows.append(
            Row(
                "shift along the axis",
                tuple(_micro(float(value), solved) for value in displacement[:, 2]),
            )
        )
    rows.append(Row("tilt", tuple(_angle(value, solved) for value in _tilt(found))))
    return Section(
        "shift",
        "Displacement of the shaft",
        _CASES,
        tuple(rows),
        f"under {described(found.load)}, from the middle of the play",
    )


def _elements(found: Examined) -> Section:
    solved = "a solution in five freedoms"
    rows = []
    for name, loads in zip(row_names(found), found.settled.loads, strict=True):
        rows.append(
            Row(
                f"{name}: largest",
                tuple(Cell(float(value), "N", samples=solved) for value in loads.max(axis=1)),
            )
        )
        rows.append(
            Row(
                f"{name}: loaded elements",
                tuple(_of(int((case > 0).sum()), loads.shape[1], solved) for case in loads),
            )
        )
    rows.append(
        Row(
            "largest pressure",
            tuple(Cell(float(value), "GPa", samples=solved) for value in found.pressure),
            "inner race",
        )
    )
    return Section(
        "elements",
        "Load of the elements",
        _CASES,
        tuple(rows),
        "pressure uniform along a roller: peaks at its ends under a tilt are neglected",
    )


def row_names(found: Examined) -> tuple[str, ...]:
    """Name the rows in the order of their loads, by where they stand along the axis."""
    seats = found.bearing.rows.seats
    if len(seats) == 1:
        return (f"{found.bearing.elements}s",)
    return tuple("outboard" if seat.at > 0 else "inboard" for seat in seats)


def _stiffness(found: Examined) -> Section:
    solved = "a solution in five freedoms"
    units = ("N/µm",) * 3 + ("N m/arcmin",) * 2
    names = (
        "across, along the load",
        "across, beside it",
        "along the axis",
        "tilt beside the load's plane",
        "tilt in the load's plane",
    )
    rows = tuple(
        Row(
            name,
            (Cell(float(value), unit, samples=solved),),
            "" if value > 0 else "no stiffness in this direction",
        )
        for name, value, unit in zip(names, found.stiffness, units, strict=True)
    )
    return Section("stiffness", "Stiffness at this load", ("mean clearance",), rows)


def _doubts(found: Examined) -> tuple[str, ...]:
    limit = 4.2e9 if found.bearing.elements == "ball" else 4.0e9
    notes = []
    if np.nanmax(found.pressure) > limit:
        notes.append(
            f"an element is pressed with {np.nanmax(found.pressure) / 1e9:.2f} GPa, beyond the "
            f"{limit / 1e9:.1f} GPa of a static rating (ISO 76)"
        )
    if found.bearing.is_single:
        notes.append(
            "a single bearing carries almost no moment: a joint needs two, or one of crossed "
            "rollers; no contribution to an arm's error"
        )
    if not found.settled.converged.all():
        notes.append(
            "the bearing cannot support this load at some of the clearances: figures are "
            "missing there"
        )
    return tuple(notes)


# By what a figure in SI is multiplied, and the unit that it then has.
_PRACTICAL: Final = {
    "m": "µm",
    "N/m": "N/µm",
    "N m/rad": "N m/arcmin",
    "rad": "arcmin",
}


def _of(count: int, whole: int, samples: str) -> Cell:
    """Return how many of a whole, as text beside the number."""
    return Cell(count, "1", samples=samples, words=f"{count} of {whole}")


def _stated(bearing: Bearing) -> Section:
    rows = [
        Row(
            each.label,
            (
                Cell(
                    each.value,
                    _PRACTICAL[each.unit],
                    samples="the values stated",
                    stated=each.unit.startswith("N"),
                ),
            ),
            each.note,
        )
        for each in bearing.stated_figures
    ]
    return Section("stated", "What is stated", ("value",), tuple(rows))


def _terms(bearing: Bearing, load: BearingLoad) -> Section:
    """List the elementary errors of the bearing at this load, largest draw of each."""
    at = Condition(
        np.zeros(1),
        np.array([[0.0], [load.moment], [0.0], [load.radial], [0.0], [load.axial]]),
        np.zeros((3, 1)),
    )
    rows = []
    for term in bearing.terms(Motion(np.array([0, 0, 1.0, 0, 0, 0]))):
        screw = term.form.screw(at)[:, 0] * (term.scale * term.bound)
        tilt, shift = float(np.linalg.norm(screw[:3])), float(np.linalg.norm(screw[3:]))
        share = _share_of_robots(term, at)
        if share and (tilt or shift):
            exact, some = (
                "the part's own law",
                f", in {100 * share:.2g} % of robots" if share < 1 else "",
            )
            rows.append(
                Row(
                    term.name,
                    (_micro(shift, exact), Cell(tilt, "arcmin", samples=exact)),
                    term.level + some,
                )
            )
    note = (
        "largest draw of each at this load, midway between the bearings; design, robot, visit: "
        "what it differs with"
    )
    return Section("terms", "Contribution to an arm's error", ("shift", "tilt"), tuple(rows), note)


def _share_of_robots(term: Term, at: Condition) -> float:
    """Return the share of robots in which a term is there under this load: friction decides whether
    it closes a play.
    """
    form = term.form
    if form.threshold is None:
        return 1.0
    closed = float(form.threshold.share(at)[0])
    return closed if form.above else 1 - closed
