"""The variables of a model as an FMU, and the XML that describes them, for FMI 2.0 and 3.0.

Source: Modelica Association, FMI for Model Exchange and Co-Simulation 2.0.4, sections 2.2 and 4.3;
FMI 3.0.1, sections 2.4 and 2.5.
"""

from __future__ import annotations

import uuid
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, Literal
from xml.etree.ElementTree import Element, SubElement, indent, tostring

from lostmotion.controller_model.compensation import DAMPING, LARGEST_STEP
from lostmotion.version import __version__

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from lostmotion.controller_model.tables import Tables

Version = Literal["2.0", "3.0"]
Causality = Literal["independent", "input", "parameter", "output"]
_AXES: Final = "xyz"
# Units of FMI by name, as exponents of SI base units.
_UNITS: Final[dict[str, dict[str, int]]] = {
    "s": {"s": 1},
    "rad": {"rad": 1},
    "m": {"m": 1},
    "m2": {"m": 2},
    "kg": {"kg": 1},
    "m/s2": {"m": 1, "s": -2},
    "N": {"kg": 1, "m": 1, "s": -2},
    "N.m": {"kg": 1, "m": 2, "s": -2},
}
_GUID_NAMESPACE: Final = uuid.UUID("5b2f3a52-6e0b-5d6c-9d1f-7e3a5c1b9f40")


@dataclass(frozen=True, slots=True)
class Variable:
    """A variable of the FMU: its name, its member of the C instance, and what the XML says of it.

    start   initial value of an input or a parameter, as the C core's defaults have it
    limits  of an integer parameter
    """

    name: str
    member: str
    causality: Causality
    description: str
    unit: str = ""
    start: float | None = None
    integer: bool = False
    limits: tuple[int, int] = (0, 1)


def variables_of(tables: Tables) -> list[Variable]:
    """Return the variables in the order of their value references."""
    joints, slides = tables.joints, [False] * len(tables.joints)
    for record in tables.records:
        if record.joint >= 0:
            slides[record.joint] = record.slides
    of_joint, held = (
        ["m" if each else "rad" for each in slides],
        ["N" if each else "N.m" for each in slides],
    )
    out = [Variable("time", "time", "independent", "not used: the model has no state", "s")]
    out += [
        Variable(
            f"q.{joint}",
            f"input.q[{k}]",
            "input",
            "joint value",
            of_joint[k],
            float(tables.start[k]),
        )
        for k, joint in enumerate(joints)
    ]
    sides = "sign of the last motion, 0 where it is not known"
    out += [
        Variable(f"side.{joint}", f"input.side[{k}]", "input", sides, "", 0.0)
        for k, joint in enumerate(joints)
    ]
    payload = (("mass", "kg"), *((f"centre.{axis}", "m") for axis in _AXES))
    process = (
        *((f"force.{axis}", "N") for axis in _AXES),
        *((f"moment.{axis}", "N.m") for axis in _AXES),
    )
    for k, (name, unit) in enumerate((*payload, *process)):
        in_tool = "in the axes of the tool" if k else "mass of the payload"
        owner, causality = ("payload", "parameter") if k < len(payload) else ("process", "input")
        out.append(
            Variable(
                f"{owner}.{name}",
                f"input.load[{k}]",
                causality,  # type: ignore[arg-type]
                in_tool,
                unit,
                float(tables.load[k]),
            )
        )
    falls = "acceleration of free fall in the axes of the base"
    out += [
        Variable(
            f"gravity.{a}",
            f"input.gravity[{k}]",
            "parameter",
            falls,
            "m/s2",
            float(tables.gravity[k]),
        )
        for k, a in enumerate(_AXES)
    ]
    out.append(
        Variable(
            "passes",
            "options.passes",
            "parameter",
            "passes of the compensation, 1 or 2",
            "",
            1,
            integer=True,
            limits=(1, 2),
        )
    )
    out.append(
        Variable(
            "whole_pose",
            "options.whole_pose",
            "parameter",
            "1: the rotation is corrected as well as the position",
            "",
            0,
            integer=True,
        )
    )
    out.append(
        Variable(
            "damping",
            "options.damping",
            "parameter",
            "of the inverse of the Jacobian, 1e-8 to 1",
            "m2",
            DAMPING,
        )
    )
    out.append(
        Variable(
            "largest_step",
            "options.largest_step",
            "parameter",
            "of a joint near singular poses, for what links and bearings move, rad or m",
            "",
            LARGEST_STEP,
        )
    )
    return [*out, *_outputs(joints, of_joint, held)]


def _outputs(joints: Sequence[str], of_joint: Sequence[str], held: Sequence[str]) -> list[Variable]:
    """Return the variables that the model computes."""
    states = (
        "0 valid, 1 an input that is not finite, 2 a joint out of its range, 3 a load beyond the "
        "tables, 4 the correction was reduced"
    )
    out = [
        Variable("status", "command.status", "output", states, integer=True),
        Variable(
            "flags",
            "output.flags",
            "output",
            (
                "sum of 1: open play; 2: a drive above its rated torque; 4, 8, 16, ...: open play "
                "of each joint in order, of the first 29"
            ),
            integer=True,
        ),
    ]
    out += [
        Variable(f"point.{axis}", f"output.point[{k}]", "output", "tool point without errors", "m")
        for k, axis in enumerate(_AXES)
    ]
    out += [
        Variable(
            f"turn.{k // 3 + 1}{k % 3 + 1}",
            f"output.turn[{k}]",
            "output",
            "rotation of the tool without errors",
        )
        for k in range(9)
    ]
    out += [
        Variable(f"torque.{joint}", f"output.torques[{k}]", "output", "held by the drive", held[k])
        for k, joint in enumerate(joints)
    ]
    out += [
        Variable(
            f"deflection.{j}",
            f"output.joints[{k}]",
            "output",
            "expected along the joint",
            of_joint[k],
        )
        for k, j in enumerate(joints)
    ]
    for member, prefix, words in (
        (
            "output.elsewhere",
            "elsewhere",
            "expected motion of the tool by links, bearings and base",
        ),
        ("output.screw", "expected", "expected motion of the tool"),
        (
            "command.left",
            "left",
            (
                "expected motion of the tool that the corrected command leaves, without the "
                "change of the load"
            ),
        ),
    ):
        motions = [(f"{prefix}.rotation.{axis}", "rad") for axis in _AXES] + [
            (f"{prefix}.displacement.{axis}", "m") for axis in _AXES
        ]
        out += [
            Variable(name, f"{member}[{k}]", "output", words, unit)
            for k, (name, unit) in enumerate(motions)
        ]
    pairs = ("xx", "xy", "xz", "yy", "yz", "zz")
    out += [
        Variable(
            f"covariance.{each}", f"output.covariance[{k}]", "output", "of the displacement", "m2"
        )
        for k, each in enumerate(pairs)
    ]
    out.append(
        Variable(
            "mean_square", "output.mean_square", "output", "mean square of the position error", "m2"
        )
    )
    out.append(
        Variable(
            "length95", "output.length95", "output", "95th percentile of the position error", "m"
        )
    )
    out += [
        Variable(
            f"jacobian.{row + 1}.{joint}",
            f"output.jacobian[{row * len(joints) + k}]",
            "output",
            "motion of the tool per motion of the joint",
        )
        for row in range(6)
        for k, joint in enumerate(joints)
    ]
    return out + [
        Variable(
            f"command.{joint}", f"command.q[{k}]", "output", "joint value to send", of_joint[k]
        )
        for k, joint in enumerate(joints)
    ]


def token(content: str) -> str:
    """Return the GUID of a model with this content: the same content gives the same one."""
    return f"{{{uuid.uuid5(_GUID_NAMESPACE, content)}}}"


def variables_source(variables: Iterable[Variable], guid: str) -> str:
    """Return the C header that finds the variables in an instance."""
    rows = []
    for each in variables:
        kind, settable = (
            "LM_INTEGER" if each.integer else "LM_REAL",
            int(each.causality in {"input", "parameter"}),
        )
        rows.append(f"    {{offsetof(lm_instance, {each.member}), {kind}, {settable}}}")
    table = ",\n".join(rows)
    return (
        f'#define LM_TOKEN "{guid}"\n#define LM_VARIABLES {len(rows)}u\nstatic const lm_variable '
        f"lm_variables[LM_VARIABLES] = {{\n{table}}};\n"
    )


def description(
    name: str,
    identifier: str,
    variables: Sequence[Variable],
    guid: str,
    sources: Sequence[str],
    version: Version,
) -> bytes:
    """Return modelDescription.xml. `sources` are the C files of an FMU of version 2.0, which lists
    them here.
    """
    second = version == "2.0"
    root = Element(
        "fmiModelDescription",
        fmiVersion=version,
        modelName=name,
        generationTool=f"lostmotion {__version__}",
    )
    root.set("guid" if second else "instantiationToken", guid)
    root.set("variableNamingConvention", "flat")
    handles = "canHandleVariableCommunicationStepSize"
    simulation = SubElement(root, "CoSimulation", {"modelIdentifier": identifier, handles: "true"})
    if second:
        files = SubElement(simulation, "SourceFiles")
        for file in sources:
            SubElement(files, "File", name=file)
    units = SubElement(root, "UnitDefinitions")
    for unit, exponents in _UNITS.items():
        SubElement(
            SubElement(units, "Unit", name=unit),
            "BaseUnit",
            {base: str(power) for base, power in exponents.items()},
        )
    listed = SubElement(root, "ModelVariables")
    structure = SubElement(root, "ModelStructure")
    given = [
        (k, each)
        for k, each in enumerate(variables)
        if not (second and each.causality == "independent")
    ]
    for k, each in given:
        (_variable_2 if second else _variable_3)(listed, k, each)
    outputs = [
        (place, k) for place, (k, each) in enumerate(given, start=1) if each.causality == "output"
    ]
    if second:
        for group in ("Outputs", "InitialUnknowns"):
            unknowns = SubElement(structure, group)
            for place, _ in outputs:
                SubElement(unknowns, "Unknown", index=str(place))
    else:
        for group in ("Output", "InitialUnknown"):
            for _, k in outputs:
                SubElement(structure, group, valueReference=str(k))
    return _xml(root)


def _xml(root: Element) -> bytes:
    indent(root)
    return (
        f'<?xml version="1.0" encoding="UTF-8"?>\n{tostring(root, encoding="unicode")}\n'.encode()
    )


def _variability(each: Variable) -> str:
    if each.causality == "parameter":
        return "tunable"
    return "discrete" if each.integer else "continuous"


def _typed(each: Variable) -> dict[str, str]:
    """Return unit and start as attributes."""
    out = {"unit": each.unit} if each.unit else {}
    if each.integer and each.causality == "parameter":
        out |= {"min": str(int(each.limits[0])), "max": str(int(each.limits[1]))}
    if each.start is not None:
        out["start"] = str(int(each.start)) if each.integer else repr(float(each.start))
    return out


def _variable_2(listed: Element, reference: int, each: Variable) -> None:
    words = {"name": each.name, "valueReference": str(reference), "description": each.description}
    words |= {"causality": each.causality, "variability": _variability(each)}
    words |= (
        {"initial": "calculated"}
        if each.causality == "output"
        else {"initial": "exact"}
        if each.causality == "parameter"
        else {}
    )
    SubElement(
        SubElement(listed, "ScalarVariable", words),
        "Integer" if each.integer else "Real",
        _typed(each),
    )


def _variable_3(listed: Element, reference: int, each: Variable) -> None:
    words = {"name": each.name, "valueReference": str(reference), "description": each.description}
    words |= {"causality": each.causality, "variability": _variability(each)}
    SubElement(listed, "Int32" if each.integer else "Float64", words | _typed(each))


def build_description(identifier: str, sources: Sequence[str]) -> bytes:
    """Return sources/buildDescription.xml of an FMU of version 3.0."""
    root = Element("fmiBuildDescription", fmiVersion="3.0")
    configuration = SubElement(root, "BuildConfiguration", modelIdentifier=identifier)
    files = SubElement(configuration, "SourceFileSet", language="C99")
    for name in sources:
        SubElement(files, "SourceFile", name=name)
    SubElement(files, "PreprocessorDefinition", name="LM_DOUBLE")
    SubElement(configuration, "Library", name="m")
    return _xml(root)
