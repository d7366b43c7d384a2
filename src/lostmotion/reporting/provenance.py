"""Provenance of the values of an arm: the table of states by joint, the assumed values, and their
sentences in the headline.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final

from lostmotion.error_model.given_values import (
    assumed_count,
    assumed_in_part,
    bounded_members,
    given_in_part,
)
from lostmotion.error_model.provenance import KINDS
from lostmotion.error_model.upper_limits import in_error, in_repeats
from lostmotion.reporting.inputs import inputs_section
from lostmotion.reporting.laws_used import laws_section
from lostmotion.reporting.sheet import Cell, Row, Section, in_words, several

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lostmotion.error_model.given_values import AssumedValue
    from lostmotion.error_model.provenance import JointStates, States
    from lostmotion.reporting.sheet import Sheet

# Columns in a word or two, so that the table fits on a screen.
_HEADS: Final = {
    "hysteresis": "hyster.",
    "transmission error": "transm. error",
    "axis mounting": "axis",
}
_MEANING: Final = (
    "ideal: nothing is described, taken as perfect; assumed: some value behind it is, see below; "
    "-: the joint has none"
)
# Kinds of error that a real arm may be without, so that an arm that does not describe them is no
# lower bound.
OPTIONAL: Final = ("transmission error", "axis mounting")
BASE_TILT: Final = "base tilt"
# Joints, and kinds of error, that a headline names; of more it says how many.
_NAMED_JOINTS: Final = 2
_NAMED_KINDS: Final = 3


def provenance_sections(known: States) -> tuple[Section, ...]:
    """Return the table of states, one line per joint, every value that went in, and the laws that
    its parts use.
    """
    return (_states_section(known), *inputs_section(known.given, known), *laws_section(known.given))


def provenance_facts(known: States) -> dict[str, Any]:
    """Return what result.json holds of the states: of every joint by kind, of the base, and every
    assumed value.
    """
    return {
        "states": {
            "described": known.described,
            "bound": bound(known),
            "missing": {joint: list(kinds) for joint, kinds in known.missing.items()},
            "ideal_joints": list(known.ideal_joints),
            "joints": [{"joint": each.joint, "states": dict(each.states)} for each in known.joints],
            "fixed_joints": [
                {"joint": each.joint, "states": dict(each.states)} for each in known.fixed
            ],
            "base": dict(known.base),
            "upper_limits": [
                {
                    "joint": each.joint,
                    "model": each.model,
                    "key": each.key,
                    "share": each.of_error,
                    "share_between_visits": each.of_repeat,
                }
                for each in known.limits
            ],
            "assumed_count": known.assumed_count,
            "assumed": _assumed_facts(known.assumed),
        }
    }


def with_inputs(sheet: Sheet, part: object, owner: str) -> Sheet:
    """Return the sheet of one part with what went in: as a table, what is assumed counted in the
    headline, and listed in what result.json holds.
    """
    given, assumed = given_in_part(part, owner), assumed_in_part(part, owner)
    count = assumed_count(assumed, bounded_members(part))
    facts = {**sheet.facts, "states": {"assumed_count": count, "assumed": _assumed_facts(assumed)}}
    verdict = " ".join([sheet.verdict, *_rests_on(count)])
    return replace(
        sheet,
        verdict=verdict,
        sections=(*sheet.sections, *inputs_section(given), *laws_section(given)),
        facts=facts,
    )


def bound(known: States) -> str:
    """Return what the figures of an arm bound: "lower", "upper", "neither" where both would, "none"
    where every required kind has a value.
    """
    if known.lower_bound:
        return "neither" if known.limits else "lower"
    return "upper" if known.limits and not known.ideal_kinds else "none"


def as_known(figure: Cell, known: States) -> Cell:
    """Return a length or an angle with one digit where every drive of the arm is assumed, another
    figure as it is.
    """
    return size_as_known(figure, known) if figure.unit in {"m", "rad"} else figure


def size_as_known(figure: Cell, known: States) -> Cell:
    """Return a computed figure, but no share, with one digit where every drive is assumed."""
    computed = not (figure.words or figure.stated or figure.shown == "%")
    return replace(figure, assumed=True) if known.presets and computed else figure


def at_least(text: object, known: States) -> str:
    """Return an error as a lower bound where kinds of error are missing, or an upper one where
    makers' limits count in it; neither with both.
    """
    return _with_bound(text, known, limited=in_error(known))


def error_sentence(within: str, known: States) -> str:
    """Return the first sentence of a headline: the error that 95 % of positions stay within, as a
    bound where its values are such.
    """
    missing = missing_clause(known)
    if missing and not in_error(known):
        return f"At least {within} for 95 % of positions: {missing}."
    return (
        "Expect 95 % of positions within "
        f"{at_least(within, known)}{f', though {missing}' if missing else ''}."
    )


def repeatability_sentence(name: str, repeats: str, known: States) -> str:
    """Return the sentence about repeatability ("RP, ISO cycle"), as a lower or an upper bound where
    its values are such.
    """
    if known.lower_bound and not in_repeats(known):
        return f"{name}, is at least {repeats} for 95 % of the robots."
    return f"{name}: 95 % of the robots repeat within {repeats_bounded(repeats, known)}."


def repeats_bounded(repeats: object, known: States) -> str:
    """Return a repeatability as a lower bound where kinds of error are missing, or an upper one
    where makers' limits count; neither with both.
    """
    return _with_bound(repeats, known, limited=in_repeats(known))


def share_within_bounded(share: object, known: States) -> str:
    """Return the share of robots or positions within a target as an upper bound where kinds of
    error are missing, since they would reduce it.
    """
    return f"at most {share}" if known.lower_bound and not in_error(known) else str(share)


def by_what_is_described(known: States, *, met: bool = True) -> str:
    """Return what follows "the target is met" where kinds of error are missing: it is met by what
    is described alone.
    """
    return " by what is described" if known.lower_bound and met else ""


def _with_bound(text: object, known: States, *, limited: bool) -> str:
    if isinstance(text, Cell):
        text = as_known(text, known)
    if known.lower_bound:
        return str(text) if limited else f"at least {text}"
    return _at_most(text, known) if limited else str(text)


def _at_most(text: object, known: States) -> str:
    """Return a figure as an upper bound, unless kinds of error are not described for some joint:
    then it bounds nothing.
    """
    return str(text) if known.ideal_kinds else f"at most {text}"


def upper_limit_sentences(known: States) -> list[str]:
    """Return the sentence that names the makers' upper limits that count, and the largest
    contributor of them; none where none counts.
    """
    if not known.limits:
        return []
    keys: dict[str, dict[str, None]] = {}
    for each in known.limits:
        keys.setdefault(each.model or f"the gearbox of {each.joint}", {})[
            each.key.replace("_", " ")
        ] = None
    named = "; ".join(f"{', '.join(of)} of {model}" for model, of in keys.items())
    first = known.limits[0]
    repeat = max(known.limits, key=lambda each: each.of_repeat)
    sizes = f"{Cell(first.of_error, '%')} of the mean-square error"
    if first is repeat and repeat.of_repeat:
        sizes += f" and {Cell(repeat.of_repeat, '%')} of its part between visits"
    elif repeat.of_repeat:
        sizes += (
            f"; between visits {repeat.key.replace('_', ' ')} at {repeat.joint}, "
            f"{Cell(repeat.of_repeat, '%')}"
        )
    ends = ": errors that rest on them are at most these"
    if known.lower_bound:
        ends = "; parts of these figures rest on them, so the true error may also be less"
    return [
        (
            f"Makers' upper limits stand for {named}{ends}. The largest of them is "
            f"{first.key.replace('_', ' ')} at {first.joint}: {sizes}."
        )
    ]


def missing_clause(known: States) -> str:
    """Return the clause that names what is missing of what a real arm must have: joints without any
    error source, then kinds; empty if nothing is.
    """
    lines = (*known.joints, *known.fixed)
    bare = [each.joint for each in lines if each.ideal and each.missing]
    kinds = _not_described(
        [(each.joint, each.required, each.missing) for each in lines if not each.ideal]
    )
    clauses = [f"nothing is described for {', '.join(bare)} (taken as perfect)"] if bare else []
    named = (
        _listed(kinds[:-1]) + f" and {kinds[-1]}"
        if len(kinds) > 1 and headline_names(kinds)
        else _listed(kinds)
    )
    clauses += [f"{named} {'is' if len(kinds) == 1 else 'are'} not described"] if kinds else []
    return "; ".join(clauses)


def zero_error_sentence(known: States) -> str:
    """Return the headline of an arm of which every described error is zero: that is no prediction,
    and what is missing is named.
    """
    missing = missing_clause(known)
    return (
        f"Every error that is described is zero{f', and {missing}' if missing else ''}: no "
        "accuracy is predicted."
    )


def caveats(known: States, *, missing: bool = True) -> list[str]:
    """Return what a headline says of the values behind it, in a sentence each: missing kinds of
    error, makers' limits, assumed values.

    missing  whether kinds that a real arm may be without are named too: they matter to an error of
             the tool, not to loads and compliance
    """
    rest = rests_on_sentences(known) if missing else assumed_value_sentences(known)
    return [
        *(assumed_drives_sentences(known) if missing else []),
        *missing_sentences(known),
        *upper_limit_sentences(known),
        *rest,
    ]


def assumed_drives_sentences(known: States) -> list[str]:
    """Return the sentence on drives that are all assumed; none where any is stated."""
    names = ", ".join(known.presets)
    return [f"Every drive is assumed ({names}): lengths of errors have one digit."] if names else []


def missing_sentences(known: States) -> list[str]:
    """Return the sentence that names what is missing of what a real arm must have; none where
    nothing is.
    """
    missing = missing_clause(known)
    ends = ", so the true error may be larger" if known.limits else ": errors are at least these"
    return [f"{missing[0].upper()}{missing[1:]}{ends}."] if missing else []


def assumed_value_sentences(known: States) -> list[str]:
    """Return the sentence of the headline that counts the assumed values; none where there are
    none.
    """
    return _rests_on(known.assumed_count)


def rests_on_sentences(known: States) -> list[str]:
    """Return the sentence on what is assumed, and on undescribed kinds of error that a real arm may
    be without; none without either.
    """
    count, optional = known.assumed_count, optional_kinds(known)
    so = "also not described: " if known.lower_bound else "not described, so taken as perfect: "
    named = so + _listed(optional) if optional else ""
    if count:
        return [f"This rests on {several(count, 'assumed value')}{f'; {named}' if named else ''}."]
    return [f"{named[0].upper()}{named[1:]}."] if named else []


def missing_kinds(known: States) -> list[str]:
    """Return the kinds of error that nothing describes, with the joints where others describe them:
    those that a real arm must have, then the rest.

    Joints without any error source are named elsewhere.
    """
    lines = [each for each in (*known.joints, *known.fixed) if not each.ideal]
    return [
        *_not_described([(each.joint, each.required, each.missing) for each in lines]),
        *optional_kinds(known),
    ]


def optional_kinds(known: States) -> list[str]:
    """Return the kinds of error that nothing describes and that a real arm may be without, with the
    joints where others describe them.

    Joints without any error source are named elsewhere, and a lumped error stands for every kind of
    its joint: neither is listed.
    """
    lines = []
    for each in known.joints:
        if not each.ideal and each.states.get("lumped", "ideal") == "ideal":
            having = [kind for kind in each.states if kind in OPTIONAL]
            lines.append(
                (each.joint, having, [kind for kind in having if each.states[kind] == "ideal"])
            )
    return [*_not_described(lines), *([BASE_TILT] if known.base.get("tilt") == "ideal" else [])]


def _not_described(lines: Sequence[tuple[str, Sequence[str], Sequence[str]]]) -> list[str]:
    """Return kinds with the joints that lack them, unless all do; each line: joint, kinds that it
    may have, those that it lacks.
    """
    out = []
    for kind in KINDS:
        without = [joint for joint, _, lacks in lines if kind in lacks]
        if without:
            everywhere = len(without) == sum(kind in having for _, having, _ in lines)
            where = (
                ", ".join(without)
                if len(without) <= _NAMED_JOINTS
                else several(len(without), "joint")
            )
            out.append(kind if everywhere else f"{kind} ({where})")
    return out


def _listed(kinds: Sequence[str]) -> str:
    """Return the first kinds by name, and how many more there are."""
    if headline_names(kinds):
        return ", ".join(kinds)
    return f"{', '.join(kinds[:_NAMED_KINDS])} and {len(kinds) - _NAMED_KINDS} more kinds of error"


def headline_names(kinds: Sequence[str]) -> bool:
    """Return whether a headline names every one of these kinds of error."""
    return len(kinds) <= _NAMED_KINDS + 1


def headline_names_all(known: States) -> bool:
    """Return whether a headline names every kind of error that nothing describes."""
    optional = optional_kinds(known)
    return headline_names(optional) and headline_names(
        missing_kinds(known)[: -len(optional) or None]
    )


def _rests_on(count: int) -> list[str]:
    return [f"This rests on {several(count, 'assumed value')}."] if count else []


def _states_section(known: States) -> Section:
    lines = (*known.joints, *known.fixed)
    shown = [
        kind for kind in KINDS if any(each.states.get(kind, "ideal") != "ideal" for each in lines)
    ]
    left = [kind for kind in KINDS if kind not in shown]
    heads = tuple(_HEADS.get(kind, kind) for kind in shown)
    rows = tuple(Row(each.joint, tuple(_cell(each, kind) for kind in shown)) for each in lines)
    if not shown:
        heads, rows = ("all kinds",), tuple(Row(each.joint, (in_words("ideal"),)) for each in lines)
    notes = [_MEANING]
    if left:
        notes.append(f"ideal for every joint: {', '.join(left)}")
    notes.append("base: " + ", ".join(f"{kind} {state}" for kind, state in known.base.items()))
    return Section("states", "What is known of each joint", heads, rows, "; ".join(notes))


def _cell(line: JointStates, kind: str) -> Cell:
    return in_words(line.states.get(kind, "-"))


def _assumed_facts(assumed: Sequence[AssumedValue]) -> list[dict[str, str]]:
    return [
        {"part": each.owner, "key": each.key, "reason": each.reason, "source": each.source}
        for each in assumed
    ]
