"""Every number that the paper prints: as printed, corrected, and as lostmotion finds it for the
same arm.

    python examples/paper/run.py            print the comparison (about ten seconds)
    python examples/paper/run.py --readme   write it into README.md as well

"as printed" and "corrected" come from paper_method.py, which knows nothing of lostmotion; the last
column comes from lostmotion's engine on z-arm-lumped.toml.
"""

from __future__ import annotations

import importlib.util
import math
import sys
import tomllib
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE))

import paper_method as paper  # noqa: E402 - stands beside this script

import lostmotion  # noqa: E402
from lostmotion.error_model.error_bins import bin_edges  # noqa: E402
from lostmotion.io.part_file import read_gearbox  # noqa: E402
from lostmotion.parts.gearbox.cycloidal.finite_elements import finite_elements  # noqa: E402

ARM_FILE = HERE / "z-arm-lumped.toml"
ARCMIN = paper.ARCMIN
SEED = 1
CORRECTED_SAMPLES = 10_000_000
PRINTED_SAMPLES = 1_000_000
# Poses and robots of each study: 1e3 to 1e7 samples at one visit each.
STUDIES = ((125, 8), (1250, 8), (6250, 16), (15_625, 64), (20_000, 500))
BEGIN, END = "<!-- what run.py prints -->", "<!-- end of what run.py prints -->"

NOTES = (
    (
        "[1] Eqs. (2), (3), assumed weights. The total is no moment on a level chassis but the "
        "largest over its tilts: `worst_torques_over_tilts`."
    ),
    (
        "[2] 0.00066 rad = 2.2689′, printed as 2.26′. What turns the disc is the displacement "
        "field, or in a catalogue the stiffness: "
        "the one given winds up by 2.2689′ under Ma, links in line."
    ),
    (
        "[3] At 3 % of the rated torque. Lost motion = play + twice the wind-up there; lostmotion "
        "for 412 N m and 113 N m/arcmin, assumed."
    ),
    (
        "[4] Assumed weights, BC and CD level and in line, tube with a wall of a twentieth of "
        "its diameter, 70 GPa. Eq. (6) as printed gives "
        "another number in other units. lostmotion's link is a Timoshenko beam: shear adds to "
        "the deflection but not to the slope."
    ),
    "[5] The paper allows 0.5′ and adds up 0.00177′ without saying for which section and load.",
    (
        "[6] The rounded parts add to 3.26177′; with the unrounded 2.2689′ the sum is "
        "3.2707′, which is the paper's 3.27′. "
        "lostmotion: mean ± half-range of the law, for the stated 3.27′."
    ),
    "Offsets along the chassis in the first two columns, across the joints' axes in lostmotion's.",
    "[8] The extremes of a sample mean nothing without its size; see below.",
    (
        "[9] Output stage of examples/gearbox/two-stage-lobes.toml, all dimensions assumed, "
        "under Ma, links in line: its largest equivalent strain "
        "read as an angle, and its own rotation, plane strain. Both branches of the envelope; "
        "needs the extra `fem`."
    ),
)
PROPERTIES = (
    "Properties of the assumed geometry and weights, not of the paper: the moments, the tube, "
    "all deviations and their quantiles. Properties of the "
    "method alone: 2.2689′, 3.26177′, 3.2707′, ±30 µm, the tilt of 4.13′, and what is wrong "
    "with each formula."
)

# Poses of the drawing: all links in line with OA, and Fig. 5 (CD pointing down).
STRAIGHT = np.radians([[0.0, 180.0, 180.0, 180.0]])
DRAWN = np.radians([[0.0, 150.0, 135.0, 120.0]])
# BC and CD level and in line: the largest load across BC.
LEVEL = np.radians([[0.0, 180.0, 135.0, 180.0]])


def arm_with(joint: str | None = None, **parts: Any) -> lostmotion.Arm:  # noqa: ANN401 - parts as a file states them
    """Read the arm; where `joint` is named, that joint gets `parts` and no joint its lumped
    error.
    """
    if joint is None:
        return lostmotion.read(ARM_FILE)
    described = tomllib.loads(ARM_FILE.read_text("utf-8"))
    for each in described["joints"]:
        del each["lumped"]
        if each["name"] == joint:
            link = parts.pop("link", {})
            if "section" in link:
                del each["link"]["rigid"]
            each["link"].update(link)
            each.update(parts)
    return lostmotion.Arm.model_validate(described)


@cache
def printed_deviations() -> paper.Floats:
    """Run the paper's Monte Carlo by the formulas as printed."""
    return paper.deviations(paper.ZArm(), PRINTED_SAMPLES, SEED, "printed")


@cache
def corrected_deviations() -> paper.Floats:
    """Run the paper's Monte Carlo by the corrected formulas."""
    return paper.deviations(paper.ZArm(), CORRECTED_SAMPLES, SEED)


@cache
def studied(poses: int, robots: int) -> lostmotion.Study:
    """Run lostmotion on the same arm: the paper's law of poses, one visit each, so that every
    sample is a fresh draw.
    """
    return lostmotion.study(
        arm_with(), poses=poses, robots=robots, visits=1, seed=SEED, pose_law="normal"
    )


def error_figures(study: lostmotion.Study) -> dict[str, dict[str, Any]]:
    """Return the study's printed figures of the position error, by label."""
    section = next(s for s in study.result()["sections"] if s["key"] == "error")
    return {row["label"]: row["figures"][0] for row in section["rows"]}


def smallest_and_largest(study: lostmotion.Study) -> tuple[float, float]:
    """Return the ends of a study's histogram, m; the smallest to the 0.3 % width of its bin."""
    counts = study.sampled.group_hist.sum(axis=0)
    return float(bin_edges()[np.flatnonzero(counts)[0]]), float(study.sampled.per_pose[:, 3].max())


def part_screws(
    arm: lostmotion.Arm, q: paper.Floats, owner: str
) -> dict[str, tuple[paper.Floats, float]]:
    """Return a part's terms at one pose in its own frame: name -> screw (6,) per unit draw, and the
    largest draw.
    """
    matrix = lostmotion.screws(lostmotion.state_of(arm, q))
    # Without what friction changes from robot to robot: no load is near it here.
    mine = [
        (k, info)
        for k, info in enumerate(matrix.infos)
        if info.owner == owner and info.closing is None
    ]
    return {
        info.name.removeprefix(owner + "."): (matrix.local[0, :, k], info.bound) for k, info in mine
    }


def arcmin(value: float, digits: int = 4) -> str:
    """Write an angle given in arcmin."""
    return f"{value:.{digits}g}′"


def mm(value: float) -> str:
    """Write a length given in m."""
    return f"{value * 1e3:.4f} mm" if value < 1e-4 else f"{value * 1e3:.3f} mm"


def count(samples: int) -> str:
    """Write a power of ten."""
    return f"1e{round(math.log10(samples))}"


Rows = list[tuple[str, str, str, str, str]]


def moment_rows() -> Rows:
    """Compare the static moment at A, eqs. (2) and (3)."""
    arm, z_arm, weights = arm_with(), paper.ZArm(), paper.Weights()
    rows: Rows = []
    for name, q in (("links in line", STRAIGHT), ("pose as in Fig. 5", DRAWN)):
        printed, corrected = (
            float(paper.static_moment(z_arm, weights, q, reading)[2][0])
            for reading in ("printed", "corrected")
        )
        ours = float(lostmotion.worst_torques_over_tilts(lostmotion.state_of(arm, q))[0, 1])
        rows.append(
            (
                f"moment Ma at A, {name} [1]",
                "no value",
                f"{printed:.2f} N m",
                f"{corrected:.2f} N m",
                f"{ours:.2f} N m",
            )
        )
    return rows


def transmission_rows(*, elements: bool) -> Rows:
    """Compare the strain that is read as an angle, with the row by finite elements or without, the
    backlash and the manufacture.
    """
    read = paper.strain_read_as_angle()
    torque = float(
        lostmotion.worst_torques_over_tilts(lostmotion.state_of(arm_with(), STRAIGHT))[0, 1]
    )
    boxed = arm_with("A", gearbox={"backlash": "0.5 arcmin", "transmission_error": "0.5 arcmin"})
    terms = part_screws(boxed, STRAIGHT, "joints.A.gearbox")
    play = sum(
        abs(float(screw[1])) * bound
        for name, (screw, bound) in terms.items()
        if "transmission" not in name
    )
    amplitude = math.hypot(
        *(
            float(screw[1]) * math.sqrt(2)
            for name, (screw, _) in terms.items()
            if "transmission" in name
        )
    )
    reducer = {"lost_motion": "1 arcmin", "rated_torque": "412 N m", "stiffness": "113 N m/arcmin"}
    terms = part_screws(arm_with("A", gearbox=reducer), STRAIGHT, "joints.A.gearbox")
    dead = sum(
        abs(float(screw[1])) * bound
        for name, (screw, bound) in terms.items()
        if name.startswith("backlash")
    )
    return [
        (
            "transmission, from a strain of 0.00066 [2]",
            "2.26′",
            f"{read:.4f}′",
            "a strain is no rotation",
            f"Ma on {torque / read:.1f} N m/arcmin",
        ),
        *(element_rows(torque) if elements else []),
        (
            "backlash",
            "0.3 to 0.5′",
            "0 to 0.5′",
            "±0.25′ about its middle",
            f"±{arcmin(play / ARCMIN)}",
        ),
        (
            "lost motion, catalogue [3]",
            "1′ at most",
            "not used",
            "play and wind-up",
            f"±{arcmin(dead / ARCMIN, 3)} of it play",
        ),
        (
            "manufacture",
            "0.5′",
            "0 to 0.5′",
            "±0.25′ if peak to peak",
            f"±{arcmin(amplitude / ARCMIN)}",
        ),
    ]


def element_rows(torque: float) -> Rows:
    """Compare strain read as an angle with the rotation of the same stage, by finite elements of a
    drive of assumed dimensions.
    """
    name = "transmission, finite elements [9]"
    if importlib.util.find_spec("ngsolve") is None:
        return [(name, "2.26′", "pip install 'lostmotion[fem]'", "", "")]
    gearbox = read_gearbox(HERE.parent / "gearbox" / "two-stage-lobes.toml", None).part
    (found,) = finite_elements(gearbox.model_copy(update={"first_stage": None}), torque)
    rotation = f"{found.rotation[0, -1] / ARCMIN:.2f}′ of rotation"
    return [
        (name, "2.26′", f"{found.strain[-1] / ARCMIN:.1f}′", "a strain is no rotation", rotation)
    ]


def link_rows() -> Rows:
    """Compare the limits of condition (4) with eqs. (6) and (7): link BC, sized so that the limits
    just hold.
    """
    z_arm, w = paper.ZArm(), paper.Weights()
    length, next_length = z_arm.lengths[2:]
    force = w.node_c + w.link4 + w.node_d + w.payload
    moment = (w.node_d + w.payload) * next_length + w.link4 * next_length / 2
    stiffness = max(paper.stiffness_for_limits(length, force, moment, w.link3))
    slope = paper.cantilever_slope(length, stiffness, force, moment, w.link3)
    deflection = paper.cantilever_deflection(length, stiffness, force, moment, w.link3)
    by_unit = [
        paper.slope_as_printed(
            length=length * unit,
            stiffness=stiffness * unit**2,
            reaction=force + w.link3,
            node_weight=w.node_c,
            own_weight=w.link3,
            moment=moment * unit,
            next_length=next_length * unit,
        )
        / ARCMIN
        for unit in (1, 1000)
    ]
    young, hollow = 70e9, 0.9
    outer = (64 * stiffness / young / (math.pi * (1 - hollow**4))) ** 0.25
    wall = outer * (1 - hollow) / 2
    sized = arm_with(
        "B",
        link={
            "section": {"kind": "tube", "outer": outer, "wall": wall},
            "material": {"young": young, "poisson": 0.33, "density": 2700.0},
        },
    )
    bent = np.sum(
        [screw for screw, _ in part_screws(sized, LEVEL, "joints.B.link").values()], axis=0
    )
    slopes = slope / ARCMIN, abs(float(bent[1])) / ARCMIN
    deflections = deflection, float(np.hypot(bent[4], bent[5]))
    return [
        (
            "link BC at its limit [θ], slope [4]",
            "0.5′",
            f"{by_unit[0]:.3f}′ in m, {by_unit[1]:.1f}′ in mm",
            *(f"{x:.4f}′" for x in slopes),
        ),
        (
            "link BC, deflection, limit l/2500",
            mm(length * paper.DEFLECTION_LIMIT),
            "no length",
            *(mm(x) for x in deflections),
        ),
        (
            "link BC, tube that just holds it",
            "no value",
            "",
            f"E I = {stiffness / 1e3:.1f} kN m²",
            f"Ø {outer * 1e3:.1f} x {wall * 1e3:.1f} mm",
        ),
        (
            "link, slope in the sum [5]",
            "0.00177′",
            "0.00177′",
            f"E I would be {slope / ARCMIN / paper.LINK_ARCMIN:.0f} times that",
            "",
        ),
    ]


def input_rows() -> Rows:
    """Compare what enters the Monte Carlo."""
    lumped = part_screws(arm_with(), STRAIGHT, "joints.A.lumped")
    mean, (spread, bound) = float(lumped["mean angle"][0][1]), lumped["angle"]
    half = float(spread[1]) * bound
    shift = max(
        float(np.abs(screw[3:]).max()) * limit
        for name, (screw, limit) in lumped.items()
        if name.startswith("offset")
    )
    mean, half, um = mean / ARCMIN, half / ARCMIN, paper.CLEARANCE / 2 * 1e6
    rounded, unrounded = (
        paper.sum_of_maxima(paper.TRANSMISSION_ARCMIN),
        paper.sum_of_maxima(paper.strain_read_as_angle()),
    )
    return [
        (
            "largest angle per joint, the sum [6]",
            "3.27′",
            f"{rounded:.5f}′",
            f"{unrounded:.4f}′",
            f"{mean:.3f}′ ± {half:.3f}′, to {mean + half:.2f}′",
        ),
        (
            "bearing offset, half of 60 µm",
            "±30 µm",
            f"±{um:.0f} µm",
            f"±{um:.0f} µm",
            f"±{shift * 1e6:.0f} µm",
        ),
    ]


def deviation_rows() -> Rows:
    """Compare the deviations over the workspace, eqs. (8) and (9)."""
    printed, corrected, ours = printed_deviations(), corrected_deviations(), studied(*STUDIES[-1])
    figures = error_figures(ours)

    def bracket(value: float, low: float, high: float) -> str:
        return f"{value * 1e3:.4f} ({low * 1e3:.4f} … {high * 1e3:.4f}) mm"

    def mean_of(values: paper.Floats) -> str:
        half = 1.96 * float(values.std()) / math.sqrt(len(values))
        return bracket(
            float(values.mean()), float(values.mean()) - half, float(values.mean()) + half
        )

    def figure(label: str) -> str:
        f = figures[label]
        return bracket(f["value"], *f["interval"])

    rows: Rows = [
        ("deviation, mean [7]", "no value", mean_of(printed), mean_of(corrected), figure("mean"))
    ]
    ordered = np.sort(printed), np.sort(corrected)
    for level in (0.5, 0.95, 0.99):
        both = (bracket(*paper.quantile_with_interval(values, level)) for values in ordered)
        label = f"{100 * level:.0f}th percentile"
        rows.append((f"deviation, {label}", "no value", *both, figure(label)))
    least, most = smallest_and_largest(ours)
    at = [
        f" of {count(n)}" for n in (len(printed), len(corrected), STUDIES[-1][0] * STUDIES[-1][1])
    ]
    rows.append(
        (
            "largest deviation [8]",
            "0.91 mm",
            mm(float(printed.max())) + at[0],
            mm(float(corrected.max())) + at[1],
            mm(most) + at[2],
        )
    )
    rows.append(
        (
            "smallest deviation [8]",
            "0.03625 mm",
            mm(float(printed.min())) + at[0],
            mm(float(corrected.min())) + at[1],
            mm(least) + at[2],
        )
    )
    rows.append(
        (
            "everything at its limit at once, worst pose",
            "no value",
            "",
            "",
            mm(float(ours.sampled.worst.max())),
        )
    )
    return rows


def extremes_rows() -> Rows:
    """Show how the smallest and the largest deviation move with the number of samples."""
    rows: Rows = []
    for poses, robots in STUDIES:
        n = poses * robots
        cells = [
            f"{v[:n].min() * 1e3:.5f} / {v[:n].max() * 1e3:.3f}" if n <= len(v) else ""
            for v in (printed_deviations(), corrected_deviations())
        ]
        least, most = smallest_and_largest(studied(poses, robots))
        rows.append((count(n), "", *cells, f"{least * 1e3:.5f} / {most * 1e3:.3f}"))
    return [("not printed", "0.03625 / 0.91", "", "", ""), *rows]


def tilt_note() -> str:
    """Return a note on the effect of the same 60 µm when they tilt an axis."""
    tilting = arm_with("O", bearing={"kind": "rolling", "clearance": "60 µm", "span": "50 mm"})
    matrix = lostmotion.screws(lostmotion.state_of(tilting, LEVEL))
    tilt, moved = (
        float(np.linalg.norm(matrix.bias[0, :3])) / ARCMIN,
        float(np.linalg.norm(matrix.bias[0, 3:])),
    )
    return (
        "And the offset is the small part of it: the same 60 µm in two bearings 50 mm apart "
        f"let the axis tilt by {tilt:.2f}′, more than the whole "
        f"{paper.JOINT_ARCMIN}′. lostmotion's bearing at O, tilted by the arm's weight at BC "
        f"and CD level, moves the tool by {mm(moved)}."
    )


def extremes_note() -> str:
    """Return a note on the sample counts that the paper's two extremes would need."""
    values = corrected_deviations()
    above, below = float((values > paper.LARGEST).mean()), float((values < paper.SMALLEST).mean())
    return (
        f"By the corrected formulas {above * 1e6:.0f} samples in a million lie above 0.91 mm "
        f"and {below * 1e6:.0f} below 0.03625 mm: "
        f"an even chance to see a largest of 0.91 mm takes about {math.log(2) / above:.0f} "
        "samples, a smallest of 0.03625 mm about "
        f"{math.log(2) / below:.0f}. "
        "Under a law that reaches down to zero the smallest tends to zero as samples are "
        "added, whatever the arm: it reflects the "
        "number of samples, not the accuracy of the arm."
    )


def markdown(header: tuple[str, ...], rows: Rows) -> str:
    """Lay rows out as a Markdown table that reads well as plain text too."""
    widths = [max(len(row[k]) for row in (header, *rows)) for k in range(len(header))]
    lines = [
        "| " + " | ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)) + " |"
        for row in (header, *rows)
    ]
    return "\n".join(
        [lines[0], "|" + "|".join("-" * (width + 2) for width in widths) + "|", *lines[1:]]
    )


def report(*, elements: bool = True) -> str:
    """Work everything out and write it down, with the row by finite elements or without."""
    columns = ("paper", "as printed", "corrected", "lostmotion")
    table = [
        *moment_rows(),
        *transmission_rows(elements=elements),
        *link_rows(),
        *input_rows(),
        *deviation_rows(),
    ]
    big = STUDIES[-1]
    sizes = (
        f"As printed: {count(PRINTED_SAMPLES)} samples, corrected: {count(CORRECTED_SAMPLES)}, "
        "a fresh pose each; "
        f"lostmotion: {big[0]} poses x {big[1]} robots, its interval counts robots and sets of "
        "poses."
    )
    notes = [*NOTES[:6], f"[7] 95 % intervals. {sizes} {NOTES[6]}", *NOTES[7:]]
    return "\n".join(
        [
            markdown(("quantity", *columns), table),
            "",
            *(f"{note}  " for note in notes),
            "",
            "Smallest / largest deviation, mm, as the number of samples grows:",
            "",
            markdown(("samples", *columns), extremes_rows()),
            "",
            extremes_note(),
            "",
            tilt_note(),
            "",
            PROPERTIES,
        ],
    )


def main() -> None:
    """Print the comparison; with --readme put it between the marks in README.md too, else with
    --quick omit the row by finite elements, which takes longer than all others.
    """
    written = "--readme" in sys.argv[1:]
    text = report(elements=written or "--quick" not in sys.argv[1:])
    print(text)
    if written:
        readme = HERE / "README.md"
        before, _, rest = readme.read_text("utf-8").partition(BEGIN)
        readme.write_text(f"{before}{BEGIN}\n\n{text}\n\n{END}{rest.partition(END)[2]}", "utf-8")


if __name__ == "__main__":
    main()
