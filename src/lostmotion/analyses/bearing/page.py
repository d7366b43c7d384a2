"""The figures of a bearing: its clearance, the load of its elements, displacement and stiffness of
the shaft, its contribution to an arm's error.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from lostmotion.analyses.bearing.plots import bearing_plots
from lostmotion.error_model.share_intervals import share_interval
from lostmotion.parts.bearing.fits import STEPS
from lostmotion.parts.term import Condition, Motion
from lostmotion.printed import ARCMIN, stated_text
from lostmotion.reporting.provenance import with_inputs
from lostmotion.reporting.sheet import Card, Cell, Sheet, length, table

if TYPE_CHECKING:
    from lostmotion.analyses.bearing.command import BearingStudy
    from lostmotion.loads.bearing import BearingLoad, Examined
    from lostmotion.parts.moving_joint import Bearing
    from lostmotion.parts.term import Term
    from lostmotion.reporting.plot import Plot
    from lostmotion.reporting.sheet import Section

__all__ = ["plots", "sheet"]
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
_CASES: Final = ("lowest clearance", "mean", "highest")
_SOLVED: Final = "a solution in five freedoms"
# Units in which stated values are read.
_PRACTICAL: Final = {
    "m": "µm",
    "N/m": "N/µm",
    "N m/rad": "N m/arcmin",
    "rad": "arcmin",
}
# Tilts below this, in arcmin, are those of the discrete elements and of rounding.
_LEAST_TILT: Final = 0.001
_STEP_NOTES: Final = {
    "delivered": "",
    "mounted": "less the effect of the fits",
    "working": "less the effect of the temperature rise",
}


def sheet(result: BearingStudy) -> Sheet:
    """Return the sheet of a bearing under a load, in full where it is described by its drawing."""
    load, load_text, examined = result.load, described(result.load), result.examined
    if examined is None:
        verdict = (
            f"Described by its stated values, not by its drawing. Under {load_text} the table "
            "shows what it adds to an arm's error."
        )
        made = Sheet(
            name=result.name,
            subject="bearing",
            verdict=verdict,
            sections=(_stated(result.part), _terms(result.part, load)),
            notes=result.notes,
            words=_WORDS,
            source=f"load: {load_text}",
        )
        return with_inputs(made, result.part, "bearing")
    terms = () if examined.bearing.is_single else (_terms(result.part, load),)
    made = Sheet(
        name=result.name,
        subject="bearing",
        counts=f"{load_text}; {examined.count} simulated bearings, seed {examined.seed}",
        verdict=_verdict(examined),
        cards=tuple(_cards(examined)),
        sections=(
            _clearance(examined),
            _samples(examined),
            _play(examined),
            _shifts(examined),
            _elements(examined),
            _stiffness(examined),
            *terms,
        ),
        notes=(*result.notes, *_doubts(examined)),
        words=_WORDS,
        source=(
            f"seed {examined.seed}, {examined.count} simulated bearings; load: {load_text}. The "
            "same input and version give the same bytes."
        ),
        seed=examined.seed,
        facts={
            "bearing": result.name,
            "seed": examined.seed,
            "built": examined.count,
            "load": {"radial_N": load.radial, "axial_N": load.axial, "moment_Nm": load.moment},
        },
    )
    return with_inputs(made, result.part, "bearing")


def plots(result: BearingStudy) -> list[Plot]:
    """Return the plots of a bearing from its drawing."""
    return [] if result.examined is None else bearing_plots(result.examined)


def described(load: BearingLoad) -> str:
    """Describe a load."""
    parts = [(load.radial, "N across"), (load.axial, "N along the axis"), (load.moment, "N m")]
    return ", ".join(f"{stated_text(value)} {unit}" for value, unit in parts if value) or "no load"


def _verdict(examined: Examined) -> str:
    low, mean, high = (Cell(each, "µm").number for each in examined.clearances)
    shift, tilt = _across(examined)[1], _tilt(examined)[1]
    sentences = [f"Working clearance {mean} µm on average, between {low} and {high} µm."]
    preloaded = float((examined.samples["working"] < 0).mean())
    if 0 < preloaded < 1:
        sentences.append(f"{100 * preloaded:.0f} % of the bearings work under preload.")
    if examined.settled.converged[1]:
        sentences.append(
            f"Under {described(examined.load)} the shaft shifts by {length(shift)} and "
            f"{_tilts(tilt)} with the mean clearance."
        )
    else:
        sentences.append("The bearing cannot support this load: no equilibrium.")
    return " ".join(sentences)


def _tilts(tilt: float) -> str:
    """Return the words for a tilt; what is far below a second of arc is none."""
    return f"tilts by {Cell(tilt, 'arcmin')}" if tilt / ARCMIN >= _LEAST_TILT else "does not tilt"


def _cards(examined: Examined) -> list[Card]:
    working, stiffness = examined.bearing.spreads["working"], examined.stiffness
    mean, low, high = (Cell(each, "µm") for each in (working.mean, working.lowest, working.highest))
    hardest = float(np.max([each[1].max() for each in examined.settled.loads]))
    tilt = _tilt(examined)[1]
    tangent = "tangent, at this load"
    return [
        Card("working clearance", str(mean), f"mean; limits {low.number} … {high}"),
        Card(
            "shift across at this load", str(length(float(_across(examined)[1]))), "mean clearance"
        ),
        Card(
            "tilt at this load",
            str(Cell(tilt if tilt / ARCMIN >= _LEAST_TILT else 0.0, "arcmin")),
            "mean clearance",
        ),
        Card(
            "most heavily loaded element",
            str(Cell(hardest, "N")),
            f"{examined.pressure[1] / 1e9:.2f} GPa",
        ),
        Card("stiffness across", str(Cell(stiffness[0], "N/µm")), tangent),
        Card("stiffness against tilting", str(Cell(stiffness[4], "N m/arcmin")), tangent),
    ]


def _across(examined: Examined) -> np.ndarray:
    return np.asarray(
        np.hypot(examined.settled.displacement[:, 0], examined.settled.displacement[:, 1])
    )


def _tilt(examined: Examined) -> np.ndarray:
    return np.asarray(
        np.hypot(examined.settled.displacement[:, 3], examined.settled.displacement[:, 4])
    )


def _clearance(examined: Examined) -> Section:
    spreads = examined.bearing.spreads
    return table(
        "clearance",
        "From delivered to working clearance",
        ["mean", "lowest", "highest", "standard deviation"],
        (
            (step, each.mean, each.lowest, each.highest, each.deviation, _STEP_NOTES[step])
            for step, each in ((step, spreads[step]) for step in STEPS)
        ),
        unit="µm",
        samples="the limits of the dimensions",
    )


def _samples(examined: Examined) -> Section:
    working, count = examined.samples["working"], examined.count
    half = 1.96 * float(working.std(ddof=1)) / math.sqrt(count) if count > 1 else math.nan
    mean, preloaded = float(working.mean()), working < 0
    share = Cell(float(preloaded.mean()), "%", *share_interval(int(preloaded.sum()), count))
    rows = [
        ("mean working clearance", Cell(mean, "µm", mean - half, mean + half)),
        ("2.5th percentile", np.quantile(working, 0.025)),
        ("97.5th percentile", np.quantile(working, 0.975)),
        ("work under preload", share),
    ]
    return table(
        "built",
        "Simulated bearings",
        {"value": "µm"},
        rows,
        "each dimension drawn from its own distribution",
        samples=f"{count} simulated bearings",
    )


def _play(examined: Examined) -> Section:
    pair, values = examined.bearing.rows, np.maximum(examined.clearances, 0.0)
    rows: list[list[Any]] = [["across, either way", *values / 2]]
    if examined.axial is not None:
        along = np.where(examined.clearances > 0, examined.axial.shifts[:, 0], 0.0)
        rows.append(["along the axis, either way", *along])
    if not examined.bearing.is_single:
        rows.append(["tilt, either way", *(Cell(value / pair.span, "arcmin") for value in values)])
    return table(
        "play",
        "Play without load",
        _CASES,
        rows,
        "at the lowest, mean and highest working clearance",
        unit="µm",
        samples="the geometry of the play",
    )


def _shifts(examined: Examined) -> Section:
    rows = [["shift across", *_across(examined)]]
    if examined.bearing.rows.axial:
        rows.append(["shift along the axis", *examined.settled.displacement[:, 2]])
    rows.append(["tilt", *(Cell(float(value), "arcmin") for value in _tilt(examined))])
    return table(
        "shift",
        "Displacement of the shaft",
        _CASES,
        rows,
        f"under {described(examined.load)}, from the middle of the play",
        unit="µm",
        samples=_SOLVED,
    )


def _elements(examined: Examined) -> Section:
    rows: list[list[Any]] = []
    for name, loads in zip(examined.row_names, examined.settled.loads, strict=True):
        counts, whole = (loads > 0).sum(axis=1), loads.shape[1]
        rows += [
            [f"{name}: largest", *loads.max(axis=1)],
            [
                f"{name}: loaded elements",
                *(
                    Cell(int(each), "1", samples=_SOLVED, words=f"{each} of {whole}")
                    for each in counts
                ),
            ],
        ]
    pressures = (Cell(float(value), "GPa") for value in examined.pressure)
    return table(
        "elements",
        "Load of the elements",
        _CASES,
        [*rows, ["largest pressure", *pressures, "inner race"]],
        "pressure uniform along a roller: peaks at its ends under a tilt are neglected",
        unit="N",
        samples=_SOLVED,
    )


def _stiffness(examined: Examined) -> Section:
    names = {
        "across, along the load": "N/µm",
        "across, beside it": "N/µm",
        "along the axis": "N/µm",
        "tilt beside the load's plane": "N m/arcmin",
        "tilt in the load's plane": "N m/arcmin",
    }
    rows = (
        (
            name,
            Cell(float(value), unit),
            "" if value > 0 else "no stiffness in this direction",
        )
        for (name, unit), value in zip(names.items(), examined.stiffness, strict=True)
    )
    title = "Stiffness at this load"
    return table("stiffness", title, ["mean clearance"], rows, samples=_SOLVED)


def _doubts(examined: Examined) -> tuple[str, ...]:
    limit = 4.2e9 if examined.bearing.elements == "ball" else 4.0e9
    notes = []
    if np.nanmax(examined.pressure) > limit:
        notes.append(
            f"an element is pressed with {np.nanmax(examined.pressure) / 1e9:.2f} GPa, beyond the "
            f"{limit / 1e9:.1f} GPa of a static rating (ISO 76)"
        )
    if examined.bearing.is_single:
        notes.append(
            "a single bearing carries almost no moment: a joint needs two, or one of crossed "
            "rollers; no contribution to an arm's error"
        )
    if not examined.settled.converged.all():
        notes.append(
            "the bearing cannot support this load at some of the clearances: figures are "
            "missing there"
        )
    return tuple(notes)


def _stated(bearing: Bearing) -> Section:
    rows = (
        (
            each.label,
            Cell(each.value, _PRACTICAL[each.unit], stated=each.unit.startswith("N")),
            each.note,
        )
        for each in bearing.stated_figures
    )
    return table("stated", "What is stated", ["value"], rows, samples="the values stated")


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
        tilt, shift = np.linalg.norm(screw[:3]), np.linalg.norm(screw[3:])
        share = _share_of_robots(term, at)
        if share and (tilt or shift):
            some = f", in {100 * share:.2g} % of robots" if share < 1 else ""
            rows.append((term.name, shift, tilt, term.level + some))
    return table(
        "terms",
        "Contribution to an arm's error",
        {"shift": "µm", "tilt": "arcmin"},
        rows,
        "largest draw of each at this load, midway between the bearings; design, robot, visit: "
        "what it differs with",
        samples="the part's own law",
    )


def _share_of_robots(term: Term, at: Condition) -> float:
    """Return the share of robots in which a term is there under this load: friction decides whether
    it closes a play.
    """
    form = term.form
    if form.threshold is None:
        return 1.0
    closed = float(form.threshold.share(at)[0])
    return closed if form.above else 1 - closed
