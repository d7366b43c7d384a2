"""The pose matrix of example arms and of seven random arms with every kind of part, joint and base
mount.
"""

from __future__ import annotations

import ast
import functools
import math
from collections import defaultdict
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pytest

import lostmotion
from lostmotion.error_model.closing import mean_and_change
from lostmotion.error_model.pose_matrix import Columns, pose_matrix, screws
from lostmotion.laws.distributions import COMPARED, Cosine, Sine, product_mean
from lostmotion.mechanism.state import state_of
from lostmotion.parts.forms import Constant, Harmonic, Linear
from tests.arms import arm_of
from tests.error_model.arms import ARMS
from tests.parts.random_arms import random_poses

every_arm = pytest.mark.parametrize("arm", ARMS, ids=[arm.name for arm in ARMS])


def approach_of(name, q):
    """Return an unknown approach, or signs of -1, 0 (unknown) and 1 that vary over joints and
    poses.
    """
    return (
        np.random.default_rng(1).integers(-1, 2, q.shape).astype(float) if name == "mixed" else 0.0
    )


@every_arm
@pytest.mark.parametrize("approach", ["unknown", "mixed"])
def test_merged_columns_are_uncorrelated(arm, approach):
    """The draws of two merged columns are uncorrelated and have mean square one, for an unknown and
    a partly known approach.
    """
    q = random_poses(arm, 4)
    merged = screws(state_of(arm, q), approach=approach_of(approach, q)).merged
    assert len(set(merged.infos)) == len(merged.infos)

    def mean(one, other):
        by_stream = defaultdict(list)
        for stream, law in (*one.draws, *other.draws):
            by_stream[stream].append(law)
        return math.prod(mean_of(tuple(laws)) for laws in by_stream.values())

    for k, one in enumerate(merged.infos):
        assert mean(one, one) == pytest.approx(1.0, abs=1e-8)
        assert all(abs(mean(one, other)) <= 1e-8 for other in merged.infos[:k]), one


@functools.cache
def mean_of(laws):
    """Return the mean of the product of the laws of one stream."""
    # The state of a play, closed or open, is a draw of mean 0 and mean square 1.
    if laws[0] == COMPARED:
        return float(len(laws) == 2)
    return product_mean(tuple(sorted(laws, key=repr) if len(laws) > 1 else laws))


@every_arm
def test_a_pose_has_the_same_bits_alone_as_among_many(arm):
    """Columns that are numbered once give each pose by itself; few poses are carried to the tool in
    another way than many.
    """
    q = random_poses(arm, 40)
    many, columns = screws(state_of(arm, q)), Columns(arm)
    assert columns.infos == many.infos
    for k in (0, 17, 39):
        one = columns.matrix(state_of(arm, q[k : k + 1]))
        for name in ("tool", "local", "bias", "scale", "place"):
            found, expected = getattr(one, name), getattr(many, name)
            np.testing.assert_array_equal(
                found, expected if name in {"scale", "place"} else expected[k : k + 1], err_msg=name
            )
        np.testing.assert_array_equal(one.closed[:, 0], many.closed[:, k])
        np.testing.assert_array_equal(one.merged.tool, many.merged.tool[k : k + 1])


@every_arm
@pytest.mark.parametrize("approach", ["unknown", "mixed"])
def test_merging_loses_no_error(arm, approach):
    """The merged columns displace the tool exactly as the single columns do, for any draws."""
    q = random_poses(arm, 8)
    matrix = screws(state_of(arm, q), approach=approach_of(approach, q))
    drawn = dict(
        zip(matrix.groups, np.random.default_rng(2).normal(size=len(matrix.groups)), strict=True)
    )
    single = matrix.tool @ np.array([drawn[info.draws] for info in matrix.infos])
    merged = matrix.merged.tool @ np.array([drawn[info.draws] for info in matrix.merged.infos])
    np.testing.assert_allclose(merged, single, rtol=1e-12, atol=1e-12 * np.abs(single).max())


@every_arm
def test_a_known_approach_fixes_the_side_of_every_sided_error(arm):
    """A known approach fixes every sided error on the side behind the last motion, and the reverse
    approach on the opposite side.
    """
    q = random_poses(arm, 8)
    either, up, down = (screws(state_of(arm, q), approach=sign) for sign in (0.0, 1.0, -1.0))
    assert [info.of for info in up.infos] == [info.of for info in either.infos]
    for k, info in enumerate(either.infos):
        if info.of.term.sided:
            assert (up.infos[k].visit, up.infos[k].robot) == (None, info.robot)
            np.testing.assert_array_equal(up.local[:, :, k], -either.local[:, :, k])
            np.testing.assert_array_equal(down.local[:, :, k], either.local[:, :, k])
        else:
            np.testing.assert_array_equal(up.local[:, :, k], either.local[:, :, k])


@dataclass
class Record:
    """Record of one place for a controller: a constant mean screw, matrices, one constant
    covariance and a short list of other terms.

    shared: constant screw per unit of each draw that places have in common, such as the
    temperature.
    """

    mean: np.ndarray = field(default_factory=lambda: np.zeros(6))
    compliance: np.ndarray = field(default_factory=lambda: np.zeros((6, 6)))
    own_weight: np.ndarray = field(default_factory=lambda: np.zeros((6, 3)))
    per_kelvin: np.ndarray = field(default_factory=lambda: np.zeros(6))
    covariance: np.ndarray = field(default_factory=lambda: np.zeros((6, 6)))
    shared: dict = field(default_factory=lambda: defaultdict(lambda: np.zeros(6)))
    design: list = field(default_factory=list)
    drawn: list = field(default_factory=list)
    plays: list = field(default_factory=list)


def lowered(arm):
    """Return one record per place and joint from the fields of an arm's terms alone."""
    out = defaultdict(Record)
    for of in arm.terms:
        term, form, here = of.term, of.term.form, out[of.place, of.joint]
        if form.threshold is not None:
            here.plays.append((of.owner, term))
        elif term.level == "design":
            if isinstance(form, Constant):
                here.mean += term.scale * form.direction
            elif isinstance(form, Linear):
                here.compliance += term.scale * form.matrix
                here.own_weight += term.scale * (
                    0.0 if form.own_weight is None else form.own_weight
                )
                here.per_kelvin += term.scale * (
                    0.0 if form.per_kelvin is None else form.per_kelvin
                )
            else:
                here.design.append(term)
        elif isinstance(form, Constant) and (term.robot or term.visit).shared:
            here.shared[term.robot or term.visit] += term.scale * form.direction
        elif isinstance(form, Constant) and not term.sided:
            here.covariance += term.scale**2 * np.outer(form.direction, form.direction)
        elif (
            isinstance(form, Harmonic)
            and form.envelope is None
            and isinstance(term.robot.law, Cosine | Sine)
        ):
            # The sine and cosine of one phase have a total variance that is constant over the
            # angle.
            here.covariance += term.scale**2 / 2 * np.outer(form.direction, form.direction)
        else:
            here.drawn.append((of.owner, term))
    return out


@every_arm
def test_records_of_the_terms_have_the_mean_and_covariance_of_the_pose_matrix(arm):
    """Records of summed matrices, curves and plays have the bias and covariance of the pose matrix,
    so the fields of a term are complete.
    """
    q = random_poses(arm, 20)
    state = state_of(arm, q)
    matrix, felt = screws(state), state.conditions()
    drawn = matrix.merged.tool[:, :, matrix.merged.columns("robot", "visit", "robot x visit")]
    mean, covariance, shared = (
        np.zeros((len(q), 6)),
        np.zeros((len(q), 6, 6)),
        defaultdict(lambda: np.zeros((len(q), 6))),
    )
    for (place, joint), record in lowered(arm).items():
        condition = felt(next(of for of in arm.terms if (of.place, of.joint) == (place, joint)))
        local = (
            record.mean[:, None]
            + record.compliance @ condition.wrench
            + record.own_weight @ condition.gravity
        )
        local += record.per_kelvin[:, None] * condition.temperature_rise
        local = local + sum(term.scale * term.form.screw(condition) for term in record.design)
        some = [
            (
                owner,
                term,
                *mean_and_change(term.form.threshold.share(condition), above=term.form.above),
            )
            for owner, term in record.plays
        ]
        local = local + sum(
            term.scale * term.form.screw(condition) * mean
            for _, term, mean, _ in some
            if term.level == "design"
        )
        spread = np.tile(record.covariance, (len(q), 1, 1))
        by_draw = defaultdict(lambda: np.zeros((6, len(q))))
        parts = [(owner, term, None, 1.0) for owner, term in record.drawn]
        parts += [
            (owner, term, None, mean) for owner, term, mean, _ in some if term.level != "design"
        ]
        parts += [(owner, term, term.form.threshold, changed) for owner, term, _, changed in some]
        for owner, term, closing, share in parts:
            # Draws of the last motion alone belong to the joint; any other draw belongs to its
            # part.
            of = None if term.sided and term.robot is closing is None else owner
            by_draw[of, term.robot, term.visit, closing] += (
                term.scale * term.form.screw(condition) * share
            )
        to_tool = state.carry(place)
        for (_, *draws), screw in by_draw.items():
            drawn_by = [draw for draw in draws if draw is not None]
            # the temperature of all places, or a batch of material
            if len(drawn_by) == 1 and getattr(drawn_by[0], "shared", ""):
                shared[drawn_by[0]] += np.einsum("pij,jp->pi", to_tool, screw)
            else:
                spread += np.einsum("ip,jp->pij", screw, screw)
        mean += np.einsum("pij,jp->pi", to_tool, local)
        covariance += to_tool @ spread @ to_tool.transpose(0, 2, 1)
        for draw, screw in record.shared.items():
            shared[draw] += to_tool @ screw
    covariance += sum(np.einsum("pi,pj->pij", each, each) for each in shared.values())
    np.testing.assert_allclose(
        mean, matrix.bias, rtol=1e-12, atol=1e-12 * np.abs(matrix.bias).max()
    )
    np.testing.assert_allclose(
        covariance,
        drawn @ drawn.transpose(0, 2, 1),
        rtol=1e-12,
        atol=1e-12 * np.abs(covariance).max(),
    )


@every_arm
def test_terms_that_differ_only_in_size_share_a_form(arm):
    """Columns of one form at one place are proportional to their sizes at every pose."""
    matrix = screws(state_of(arm, random_poses(arm, 8)))
    by_form = defaultdict(list)
    for k, info in enumerate(matrix.infos):
        by_form[info.of.place, info.of.term.form, info.closing].append(k)
    for first, *others in by_form.values():
        for k in others:
            np.testing.assert_allclose(
                matrix.local[:, :, k] * matrix.scale[first],
                matrix.local[:, :, first] * matrix.scale[k],
                rtol=1e-12,
                atol=1e-300,
            )


@every_arm
def test_every_term_has_a_unique_name_and_a_cause_without_numbers(arm):
    """Every term has a unique name, and a cause without numbers that a budget can add over
    joints.
    """
    names = [of.name for of in arm.terms]
    assert len(set(names)) == len(names)
    for of in arm.terms:
        assert of.term.cause
        assert not any(letter.isdigit() for letter in of.term.cause)
        assert of.term.exponent in {1, -1}


SOURCES = Path(lostmotion.__file__).parent
# Code that tests for one of these types depends on the part that causes an error; joints belong to
# the mechanism and are exempt.
PARTS = {
    "Gearbox",
    "CatalogueGearbox",
    "CycloidalGearbox",
    "PlanetaryGearbox",
    "StrainWaveGearbox",
    "WolfromGearbox",
    "WormGearbox",
}
PARTS |= {
    "DrawnBearing",
    "RollingPair",
    "CrossedRoller",
    "BallPair",
    "RollerPair",
    "Link",
    "ElasticLink",
    "Encoder",
    "Lumped",
    "Mounting",
    "Base",
}


@pytest.mark.parametrize(
    "package", ["mechanism", "error_model", "propagation", "analyses", "reporting", "runs", "cli"]
)
def test_no_analysis_depends_on_the_type_of_a_part(package):
    """Packages after the parts read terms: none tests the type of a part, and none before the
    analyses parses names by regular expressions.
    """
    for path in sorted((SOURCES / package).rglob("*.py")):
        text = path.read_text(encoding="utf-8")
        assert (
            package in {"analyses", "reporting", "runs", "cli"}
            or path.name == "stopping.py"
            or "\nimport re\n" not in text
        ), path
        for node in ast.walk(ast.parse(text)):
            if isinstance(node, ast.Call) and getattr(node.func, "id", "") == "isinstance":
                assert not PARTS & {
                    each.id for each in ast.walk(node.args[1]) if isinstance(each, ast.Name)
                }, f"{path}:{node.lineno}"


def test_a_known_side_moves_a_settled_arm_as_it_moves_any_other():
    """The mean of both known sides is the displacement of the settled arm, and half their
    difference is the play: no remainder of the equilibrium takes it away.
    """
    arm = arm_of(2)
    q = np.array([[0.3, -0.4], [-0.2, 0.8]])
    ahead, behind, either = (pose_matrix(arm, q, approach=side).bias for side in (1.0, -1.0, 0.0))
    np.testing.assert_allclose((ahead + behind) / 2, either, atol=1e-15)
    first, last = (screws(state_of(arm, q), approach=side).bias for side in (1.0, -1.0))
    assert np.abs(first - last).max() > 1e-6
    np.testing.assert_allclose(ahead - behind, first - last, rtol=1e-2, atol=1e-8)
