"""Provenance of the values of an arm: the table of states by joint, the assumed values, and their sentences in the headline."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final

from lostmotion.error_model.provenance import KINDS, assumed_in_part, given_in_part
from lostmotion.error_model.upper_limits import in_error, in_repeats
from lostmotion.parts.provenance import DEFAULT_SCATTER
from lostmotion.reporting.inputs import inputs_section
from lostmotion.reporting.laws_used import laws_section
from lostmotion.reporting.sheet import Card, Figure, Row, Section, in_words, several

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from lostmotion.error_model.provenance import AssumedValue, JointStates, States
    from lostmotion.reporting.sheet import Sheet

# Columns in a word or two, so that the table fits on a screen.
_HEADS: Final = {"transmission error": "transm. error", "axis mounting": "axis"}
# Titles of cards that show scatter between visits alone.
_REPEATS: Final = ("repeatability", "RP")
_MEANING: Final = "ideal: nothing is described, taken as perfect; assumed: some value behind it is, see below; -: the joint has none"
BASE_TILT: Final = "base tilt"
# Joints, and kinds of error, that a headline names; of more it says how many.
_NAMED_JOINTS: Final = 2
_NAMED_KINDS: Final = 3


def provenance_sections(known: States) -> tuple[Section, ...]:
    """Return the table of states, one line per joint, every value that went in, and the laws that its parts use."""
    return (_states_section(known), *inputs_section(known.given, known), *laws_section(known.given))


def provenance_facts(known: States) -> dict[str, Any]:
    """Return what result.json holds of the states: of every joint by kind, of the base, and every assumed value."""
    return {
        "states": {
            "described": known.described,
            "ideal_joints": list(known.ideal_joints),
            "joints": [{"joint": each.joint, "states": dict(each.states)} for each in known.joints],
            "fixed_joints": [{"joint": each.joint, "states": dict(each.states)} for each in known.fixed],
            "base": dict(known.base),
            "upper_limits": [
                {"joint": each.joint, "model": each.model, "key": each.key, "share": each.of_error, "share_between_visits": each.of_repeat}
                for each in known.limits
            ],
            "assumed": _assumed_facts(known.assumed),
        }
    }


def with_inputs(sheet: Sheet, part: object, owner: str) -> Sheet:
    """Return the sheet of one part with what went in: as a table, what is assumed counted in the headline, and listed in what result.json holds."""
    given, assumed = given_in_part(part, owner), assumed_in_part(part, owner)
    facts = {**sheet.facts, "states": {"assumed": _assumed_facts(assumed)}}
    verdict = " ".join([sheet.verdict, *_rests_on(assumed)])
    return replace(sheet, verdict=verdict, sections=(*sheet.sections, *inputs_section(given), *laws_section(given)), facts=facts)


def at_least(text: object, known: States) -> str:
    """Return a figure of the headline, as a lower bound where some joints are taken as perfect, or an upper one where makers' limits count."""
    if known.ideal_joints:
        return f"at least {text}"
    return _at_most(text, known) if in_error(known) else str(text)


def error_sentence(within: str, known: States) -> str:
    """Return the first sentence of a headline: the error that 95 % of positions stay within, as a bound where its values are such."""
    ideal = ideal_joints_clause(known)
    return f"At least {within} for 95 % of positions: {ideal}." if ideal else f"Expect 95 % of positions within {at_least(within, known)}."


def repeatability_sentence(repeats: str, known: States) -> str:
    """Return the sentence about repeatability, as a lower or an upper bound where its values are such."""
    if known.ideal_joints:
        return f"RP is at least {repeats} for 95 % of the robots."
    return f"95 % of the robots repeat within {repeats_bounded(repeats, known)}."


def repeats_bounded(repeats: object, known: States) -> str:
    """Return a repeatability as a lower bound where some joints are taken as perfect, or an upper one where makers' limits count in it."""
    if known.ideal_joints:
        return f"at least {repeats}"
    return _at_most(repeats, known) if in_repeats(known) else str(repeats)


def share_within_bounded(share: object, known: States) -> str:
    """Return the share of robots within a target as an upper bound where some joints are taken as perfect, since their errors are missing from it."""
    return f"at most {share}" if known.ideal_joints else str(share)


def _at_most(text: object, known: States) -> str:
    """Return a figure as an upper bound, unless kinds of error are not described for some joint: then it bounds nothing."""
    return str(text) if known.ideal_kinds else f"at most {text}"


def upper_limit_sentences(known: States) -> list[str]:
    """Return the sentence that names the makers' upper limits that count, and the largest contributor of them; none where none counts."""
    if not known.limits:
        return []
    keys: dict[str, dict[str, None]] = {}
    for each in known.limits:
        keys.setdefault(each.model or f"the gearbox of {each.joint}", {})[each.key.replace("_", " ")] = None
    named = "; ".join(f"{', '.join(of)} of {model}" for model, of in keys.items())
    first = known.limits[0]
    repeat = max(known.limits, key=lambda each: each.of_repeat)
    sizes = f"{Figure(100 * first.of_error, '%')} of the mean-square error"
    if first is repeat and repeat.of_repeat:
        sizes += f" and {Figure(100 * repeat.of_repeat, '%')} of its part between visits"
    elif repeat.of_repeat:
        sizes += f"; between visits {repeat.key.replace('_', ' ')} at {repeat.joint}, {Figure(100 * repeat.of_repeat, '%')}"
    ends = ": errors that rest on them are at most these"
    if known.ideal_joints:
        ends = "; parts of these figures rest on them, so the true error may also be less"
    return [f"Makers' upper limits stand for {named}{ends}. The largest of them is {first.key.replace('_', ' ')} at {first.joint}: {sizes}."]


def ideal_joints_clause(known: States) -> str:
    """Return the clause that names the joints that are taken as perfect; empty where there are none."""
    return f"nothing is described for {', '.join(known.ideal_joints)} (taken as perfect)" if known.ideal_joints else ""


def zero_error_sentence(known: States) -> str:
    """Return the headline of an arm of which every described error is zero: that is no prediction, and the joints without any are named."""
    ideal = ideal_joints_clause(known)
    return f"Every error that is described is zero{f', and {ideal}' if ideal else ''}: no accuracy is predicted."


def caveats(known: States, *, missing: bool = True) -> list[str]:
    """Return what a headline says of the values behind it, in a sentence each: ideal joints, makers' limits, assumed values.

    missing  whether kinds of error that nothing describes are named too: they matter to an error of the tool, not to loads and compliance
    """
    ideal = ideal_joints_clause(known)
    rest = rests_on_sentences(known) if missing else assumed_value_sentences(known)
    ends = ", so the true error may be larger" if known.limits else ": errors are at least these"
    return [*([f"{ideal[0].upper()}{ideal[1:]}{ends}."] if ideal else []), *upper_limit_sentences(known), *rest]


def assumed_value_sentences(known: States) -> list[str]:
    """Return the sentence of the headline that counts the assumed values; none where there are none."""
    return _rests_on(known.assumed)


def rests_on_sentences(known: States) -> list[str]:
    """Return the sentence on what is assumed, and on the kinds of error that are missing because nothing describes them; none without either."""
    count, missing = assumed_count(known.assumed), missing_kinds(known)
    named = "not described, so taken as perfect: " + _listed(missing) if missing else ""
    if count:
        return [f"This rests on {several(count, 'assumed value')}{f'; {named}' if named else ''}."]
    return [f"{named[0].upper()}{named[1:]}."] if named else []


def missing_kinds(known: States) -> list[str]:
    """Return the kinds of error that nothing describes, with the joints where others describe them.

    Joints without any error source are named elsewhere, and a lumped error stands for every kind: neither is listed.
    """
    joints = [each for each in known.joints if not each.ideal and each.states.get("lumped", "ideal") == "ideal"]
    out = []
    for kind in KINDS:
        having = [each for each in joints if kind in each.states]
        ideal = [each.joint for each in having if each.states[kind] == "ideal"]
        if kind != "lumped" and ideal:
            where = "" if len(ideal) == len(having) else " of " + (", ".join(ideal) if len(ideal) <= _NAMED_JOINTS else several(len(ideal), "joint"))
            out.append(kind + where)
    return [*out, *([BASE_TILT] if known.base.get("tilt") == "ideal" else [])]


def _listed(kinds: Sequence[str]) -> str:
    """Return the first kinds by name, and how many more there are."""
    if headline_names(kinds):
        return ", ".join(kinds)
    return f"{', '.join(kinds[:_NAMED_KINDS])} and {len(kinds) - _NAMED_KINDS} more kinds of error"


def headline_names(kinds: Sequence[str]) -> bool:
    """Return whether a headline names every one of these kinds of error."""
    return len(kinds) <= _NAMED_KINDS + 1


def assumed_count(assumed: Sequence[AssumedValue]) -> int:
    """Return the number of assumed values. A scatter is no value of its own: it is listed in the table, and not counted."""
    return sum(each.reason != DEFAULT_SCATTER for each in assumed)


def _rests_on(assumed: Sequence[AssumedValue]) -> list[str]:
    count = assumed_count(assumed)
    return [f"This rests on {several(count, 'assumed value')}."] if count else []


def bounded_cards(cards: Iterable[Card], known: States, bounded: Sequence[str]) -> tuple[Card, ...]:
    """Return cards, those whose title begins with one of `bounded` with the sign of a lower or an upper bound where they are one."""
    return tuple(replace(card, number=_bounded(card, known)) if card.title.startswith(tuple(bounded)) else card for card in cards)


def _bounded(card: Card, known: States) -> str:
    number = card.number.removeprefix("≥ ").removeprefix("≤ ")
    if not number[:1].isdigit():
        return card.number
    counts = in_repeats(known) if card.title.startswith(_REPEATS) else in_error(known)
    if known.ideal_joints:
        return number if counts else f"≥ {number}"
    if counts:
        return number if known.ideal_kinds else f"≤ {number}"
    return card.number


def _states_section(known: States) -> Section:
    lines = (*known.joints, *known.fixed)
    shown = [kind for kind in KINDS if any(each.states.get(kind, "ideal") != "ideal" for each in lines)]
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


def _cell(line: JointStates, kind: str) -> Figure:
    return in_words(line.states.get(kind, "-"))


def _assumed_facts(assumed: Sequence[AssumedValue]) -> list[dict[str, str]]:
    return [{"part": each.owner, "key": each.key, "reason": each.reason, "source": each.source} for each in assumed]
