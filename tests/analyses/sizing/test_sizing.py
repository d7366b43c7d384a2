"""Lightest links within limits: against closed forms, brute force, and the beam model of a
study.
"""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from scipy.optimize import brentq

import lostmotion
from lostmotion.analyses.sizing.sizing import rms_error, size_links
from lostmotion.catalogue import materials
from lostmotion.error_model.poses import Poses
from lostmotion.mechanism.arm import Arm
from lostmotion.mechanism.load_causes import bending
from lostmotion.parts.family import BoxFamily, IFamily, RodFamily, TubeFamily, family_around
from lostmotion.parts.section import Box, ISection, Rectangle, Rod, Tube
from lostmotion.sizing.candidates import LinkOptions
from lostmotion.sizing.lightest import PAPER, Limits, LinkTask, lightest, with_section
from lostmotion.sizing.link_deflection import LinkLoads

# A row of docs/validation.md each: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "lightest sections of links",
        (
            "closed form of a cantilever; brute force over one, two and three free sizes and "
            "over all pairs of a list; bending in the study at "
            "4096 other poses"
        ),
        "1e-9; none lighter",
    ),
)

ARCMIN = math.pi / 10800
ALUMINIUM = materials()["aluminium"]


def two_links(
    first=None, second=None, *, payload=3.0, elbow=(-2.0, 2.0), elbow_mass=1.0, lengths=(0.5, 0.5)
):
    """Make a shoulder and an elbow in a vertical plane."""
    tube = Tube(outer=0.08, wall=0.003)
    links = [
        {"length": length, "section": each or tube, "material": ALUMINIUM}
        for length, each in zip(lengths, (first, second), strict=True)
    ]
    joints = [
        {
            "name": "shoulder",
            "type": "revolute",
            "axis": "y",
            "limits": (-1.5, 1.5),
            "link": links[0],
        },
        {
            "name": "elbow",
            "type": "revolute",
            "axis": "y",
            "limits": elbow,
            "mass": elbow_mass,
            "link": links[1],
        },
    ]
    return Arm(name="two", joints=joints, payload={"mass": payload})


def task(arm, joint, limits=PAPER, count=64, tilt=None):
    """Return the task of one link of an arm, and the poses."""
    q = lostmotion.sample_poses(arm, count).q
    return LinkTask(arm.joints[joint], LinkLoads.of(arm, joint, q, tilt), limits), q


def largest(arm, q):
    """Return slope and deflection of each link by the beam model of a study, over the paper's
    limits.
    """
    found = bending(arm, q, np.zeros((len(q), 3)), 0.0)
    return {
        each.joint: (each.slope / PAPER.slope, each.deflection * PAPER.deflection / each.length)
        for each in found
    }


def test_the_lightest_section_of_a_cantilever_has_a_closed_form():
    """The height found for a level cantilever is where F l²/(2 E I) + M l/(E I) + w l³/(6 E I) is
    the slope allowed.
    """
    length, width, mass, lever = 0.4, 0.03, 5.0, 0.1
    joint = {"name": "A", "type": "revolute", "axis": "y", "limits": (-1e-9, 1e-9)}
    joint["link"] = {
        "length": length,
        "section": Rectangle(width=width, height=0.05),
        "material": ALUMINIUM,
    }
    arm = Arm(
        name="bar",
        joints=[joint],
        payload={"mass": mass, "centre_of_mass": (lever, 0.0, 0.0)},
        gravity=9.81,
    )
    limits = Limits(0.5 * ARCMIN, 10.0)
    loads = LinkLoads.of(arm, 0, np.zeros((1, 1)), None)
    family = type(family_around(Rectangle(width=width, height=0.05)))(
        height="10 mm .. 200 mm", width="30 mm"
    )
    found = lightest(LinkTask(arm.joints[0], loads, limits), family)

    def slope(height):
        stiff = ALUMINIUM.young * width * height**3 / 12
        force, weight = mass * 9.81, ALUMINIUM.density * width * height * 9.81
        return (
            force * length**2 / (2 * stiff)
            + force * lever * length / stiff
            + weight * length**3 / (6 * stiff)
        )

    assert found.section.height == pytest.approx(
        brentq(lambda h: slope(h) - limits.slope, 0.01, 0.2, xtol=1e-15), rel=1e-9
    )
    assert found.utilisation == pytest.approx(1, abs=1e-9)
    assert found.meets_limits


def test_no_lighter_section_of_one_free_size_is_within_the_limits():
    """Of all tubes in steps of 0.1 mm, none lighter than the result is within the limits, and the
    result is.
    """
    arm = two_links()
    sought, _ = task(arm, 0)
    family = TubeFamily(outer="40 mm .. 160 mm", wall="3 mm")
    found = lightest(sought, family, 1e-4)
    assert found.meets_limits
    every = [family.section((outer / 1e4, family.wall.low)) for outer in range(400, 1601)]
    most = sought.mass(found.section)
    # heavier ones are no lighter than the result, whether they hold or not
    holding = [
        sought.mass(section)
        for section in every
        if sought.mass(section) <= most * (1 + 1e-9)
        and sought.section_utilisation(section).max() <= 1
    ]
    assert most == pytest.approx(min(holding), rel=1e-12)


@pytest.mark.parametrize(
    "family",
    [
        TubeFamily(outer="40 mm .. 160 mm", wall="3 mm"),
        TubeFamily(outer="40 mm .. 160 mm", wall="5 %"),
        TubeFamily(outer="40 mm .. 120 mm", wall="1 mm .. 8 mm"),
        BoxFamily(height="40 mm .. 160 mm", width="66.7 %", wall="3 mm"),
        BoxFamily(height="80 mm .. 120 mm", width="40 mm .. 80 mm", wall="3 mm .. 5 mm"),
    ],
)
def test_usual_sizes_are_the_lightest_of_all_usual_ones_within_the_limits(family):
    """Without a step every free size, and one in proportion to it, is in the list of usual sizes;
    of all such sections none lighter is enough.
    """
    sought, _ = task(two_links(payload=6.0), 0, count=32)
    found, exact = lightest(sought, family, None), lightest(sought, family, 0.0)
    assert found.meets_limits
    assert sought.section_utilisation(found.section).max() <= 1 + 1e-9
    outside = [
        0.02,
        0.022,
        0.025,
        0.028,
        0.03,
        0.032,
        0.035,
        0.038,
        *np.arange(40, 49, 1) / 1e3,
        *np.arange(50, 101, 5) / 1e3,
        *np.arange(110, 161, 10) / 1e3,
    ]
    outside = [size for size in outside if round(size * 1e3) not in {41, 43, 44, 46, 47}]
    walls = np.array([1, 1.2, 1.5, 2, 2.5, 3, 3.5, 4, 4.5, 5, 5.5, 6, 7, 8]) / 1e3
    usual = {name: walls if name == "wall" else np.array(outside) for name in family.names}
    for name, span in zip(family.names, family.spans, strict=True):
        if span.free or span.share:
            assert np.abs(usual[name] - getattr(found.section, name)).min() < 1e-12
    lighter = []
    for leading, *others in itertools.product(
        *(
            _allowed(span, usual[name])
            for name, span in zip(family.names, family.spans, strict=True)
        )
    ):
        section = family.section(
            (
                leading,
                *(
                    _share(other, span, leading, usual[name])
                    for other, name, span in zip(
                        others, family.names[1:], family.spans[1:], strict=True
                    )
                ),
            )
        )
        if section is not None and sought.mass(section) < sought.mass(found.section) * (1 - 1e-9):
            lighter.append(section)
    assert all(sought.section_utilisation(section).max() > 1 for section in lighter)
    assert sought.mass(exact.section) <= sought.mass(found.section) * (1 + 1e-9)


def _allowed(span, usual):
    """Return the usual sizes within a span, or the value of a fixed one."""
    return (
        [span.low] if not span.free else [size for size in usual if span.low <= size <= span.high]
    )


def _share(value, span, leading, usual):
    """Return a share as that of the usual size nearest to it; any other value as it is."""
    return usual[np.abs(usual - value * leading).argmin()] / leading if span.share else value


@pytest.mark.parametrize(
    ("family", "steps"),
    [
        (TubeFamily(outer="40 mm .. 120 mm", wall="2 mm .. 8 mm"), 14),
        (BoxFamily(height="30 mm .. 120 mm", width="20 mm .. 80 mm", wall="2 mm .. 5 mm"), 7),
        (
            IFamily(
                height="40 mm .. 120 mm", width="30 mm .. 80 mm", web="3 mm", flange="3 mm .. 8 mm"
            ),
            7,
        ),
    ],
)
def test_brute_force_over_several_free_sizes_finds_nothing_lighter(family, steps):
    """A grid over all free sizes has no section that is lighter than the result and within the
    limits.
    """
    arm = two_links(payload=6.0)
    sought, _ = task(arm, 0, count=32)
    found = lightest(sought, family)
    assert found.meets_limits
    assert found.utilisation <= 1 + 1e-9
    grids = [np.linspace(span.low, span.high, steps if span.free else 1) for span in family.spans]
    sections = [
        section
        for values in itertools.product(*grids)
        if (section := family.section(tuple(values))) is not None
    ]
    masses = [(sought.mass(section), section) for section in sections]
    lighter = [
        section for mass, section in masses if mass < sought.mass(found.section) * (1 - 1e-6)
    ]
    assert len(lighter) > 5, "the grid must try sections lighter than the one found"
    assert min(sought.section_utilisation(section).max() for section in lighter) > 1


def test_a_thicker_wall_may_deflect_more_under_its_own_weight():
    """Where a thick wall deflects under its own weight and a thin one under the payload, the
    thinnest within the limits is between.
    """
    arm = two_links(payload=0.2, elbow_mass=0.0)
    sought, _ = task(arm, 1)
    family = TubeFamily(outer="30 mm", wall="0.1 mm .. 14.9 mm")
    walls = np.geomspace(1e-4, 14.9e-3, 400)
    over = np.array(
        [sought.section_utilisation(Tube(outer=0.03, wall=wall)).max() for wall in walls]
    )
    least = int(over.argmin())
    assert 0 < least < len(walls) - 1
    limit = math.sqrt(over[least] * over[-1])
    looser = LinkTask(sought.joint, sought.loads, PAPER.scaled(limit))
    found = lightest(looser, family)
    first = int((over <= limit).argmax())
    assert walls[first - 1] < found.section.wall <= walls[first]
    narrow = LinkTask(sought.joint, sought.loads, PAPER.scaled(float(over[least]) * (1 + 1e-6)))
    assert lightest(narrow, family).meets_limits
    strict = lightest(
        LinkTask(sought.joint, sought.loads, PAPER.scaled(float(over[least]) * 0.99)), family
    )
    assert not strict.meets_limits
    assert strict.utilisation == pytest.approx(1 / 0.99, rel=1e-4)


def test_the_lightest_of_a_list_within_the_limits():
    """The result of a list is within the limits and every lighter one is not; where none is, it has
    the least utilisation.
    """
    arm = two_links()
    sought, _ = task(arm, 0)
    stock = (
        *tuple(
            Tube(outer=outer / 1000.0, wall=wall / 1000.0)
            for outer in range(40, 130, 10)
            for wall in (2, 3, 5)
        ),
        Rod(diameter=0.09),
    )
    found = lightest(sought, stock)
    assert found.meets_limits
    for section in stock:
        assert (sought.mass(section) >= sought.mass(found.section)) or sought.section_utilisation(
            section
        ).max() > 1
    thin = stock[:6]
    missed = lightest(sought, thin)
    assert not missed.meets_limits
    assert missed.utilisation == pytest.approx(
        min(sought.section_utilisation(section).max() for section in thin)
    )


@pytest.mark.usefixtures("few_scales")
def test_one_pass_from_the_tip_is_the_lightest_arm():
    """Of every pair of sections for two links, the lightest arm within all limits is that of one
    inward pass, and so is each link.
    """
    arm = two_links()
    stock = tuple(Tube(outer=outer / 1e3, wall=0.003) for outer in range(50, 130, 12))
    poses = lostmotion.sample_poses(arm, 16)
    sizing = size_links(
        arm, {"shoulder": LinkOptions(stock), "elbow": LinkOptions(stock)}, PAPER, poses
    )
    assert sizing.meets_limits
    holding = []
    for first, second in itertools.product(stock, stock):
        other = two_links(first, second)
        if max(max(shares) for shares in largest(other, sizing.q).values()) <= 1:
            holding.append((sum(joint.link.total_mass for joint in other.joints), first, second))
    chosen = [link.section for link in sizing.links]
    lightest_arm = min(holding, key=lambda each: each[0])
    assert chosen == list(lightest_arm[1:])
    assert all(
        first.outer >= chosen[0].outer and second.outer >= chosen[1].outer
        for _, first, second in holding
    )
    assert all(not link.relieved_by for link in sizing.links)


@pytest.mark.usefixtures("few_scales")
def test_a_link_that_relieves_another_is_reported():
    """A link that folds back relieves the one before: a heavier one could make that lighter, and
    the result names it.
    """
    arm = two_links(
        payload=0.0, elbow=(math.pi - 0.1, math.pi + 0.1), elbow_mass=20.0, lengths=(0.5, 1.0)
    )
    family = TubeFamily(outer="20 mm .. 160 mm", wall="2 mm")
    sizing = size_links(
        arm,
        {"shoulder": LinkOptions(family), "elbow": LinkOptions(family)},
        PAPER,
        lostmotion.sample_poses(arm, 32),
    )
    assert sizing.links[0].relieved_by == ("elbow",)
    task_now, _ = task(sizing.sized, 0)
    heavier = sizing.sized.joints[1].model_copy(
        update={"link": sizing.sized.joints[1].link.model_copy(update={"mass": 5.0})}
    )
    relieved, _ = task(
        sizing.sized.model_copy(update={"joints": (sizing.sized.joints[0], heavier)}), 0
    )
    section = sizing.links[0].section
    assert relieved.section_utilisation(section).max() < task_now.section_utilisation(section).max()


@pytest.mark.usefixtures("few_scales")
def test_the_sized_arm_is_within_its_limits_at_other_poses():
    """By the beam model of a study, at poses not used in the sizing, no sized link exceeds its
    limits, and each is close to one.
    """
    arm = two_links()
    family = TubeFamily(outer="40 mm .. 160 mm", wall="3 mm")
    sizing = size_links(
        arm,
        {name: LinkOptions(family) for name in ("shoulder", "elbow")},
        PAPER,
        lostmotion.sample_poses(arm, 64),
    )
    other_poses = lostmotion.sample_poses(arm, 4096, seed=11).q
    for shares in largest(sizing.sized, other_poses).values():
        assert max(shares) <= 1 + 1e-6
        assert max(shares) > 0.99
    assert sizing.validated_utilisation <= 1 + 1e-6


def test_over_tilts_the_worst_is_that_of_every_gravity():
    """The maximum over tilts is not exceeded by any sampled gravity within the tilt, with a process
    force, and is nearly reached.
    """
    arm = two_links().model_copy(
        update={"payload": lostmotion.Payload(mass=3.0, force=(40.0, 60.0, -20.0))}
    )
    tilt = 0.4
    q = lostmotion.sample_poses(arm, 16).q
    loads = LinkLoads.of(arm, 0, q, tilt)
    link = arm.joints[0].elastic_link
    whole = loads.deflections(link)
    rng = np.random.default_rng(5)
    away = np.concatenate([np.full(400, tilt), np.arccos(rng.uniform(math.cos(tilt), 1, 400))])
    around = np.concatenate([np.linspace(0, 2 * math.pi, 400), rng.uniform(0, 2 * math.pi, 400)])
    best = np.zeros_like(whole)
    for a, b in zip(away, around, strict=True):
        gravity = arm.gravity * np.array(
            [math.sin(a) * math.cos(b), math.sin(a) * math.sin(b), -math.cos(a)]
        )
        felt = np.stack([loads.at_pose(k, gravity) for k in range(len(q))])
        standing = LinkLoads(felt, None, None, gravity, None)
        best = np.maximum(best, standing.deflections(link))
    assert (best <= whole * (1 + 2e-5)).all()
    assert (best > whole * (1 - 2e-3)).all()
    worst = loads.worst(link)
    gravity = loads.worst_gravity(link, worst.slope_index, 0)
    there = LinkLoads(loads.at_pose(worst.slope_index, gravity)[None], None, None, gravity, None)
    assert there.deflections(link)[0, 0] == pytest.approx(worst.slope, rel=2e-5)
    assert math.acos(-gravity[2] / arm.gravity) <= tilt + 1e-9


def test_deflection_without_a_tilt_is_that_of_a_study():
    """Slope and deflection at the command equal those of `load_causes.bending` where the arm
    stands, but for the turn of its links, by which the loads on them turn.
    """
    arm = two_links()
    q = lostmotion.sample_poses(arm, 64).q
    bent = bending(arm, q, np.zeros((len(q), 3)), 0.0)
    turn = sum(each.slope for each in bent)
    for k, found in enumerate(bent):
        worst = LinkLoads.of(arm, k, q, None).worst(arm.joints[k].elastic_link)
        assert worst.slope == pytest.approx(found.slope, rel=turn)
        assert worst.deflection == pytest.approx(found.deflection, rel=turn)
        level = LinkLoads.of(arm, k, q, 0.0).worst(arm.joints[k].elastic_link)
        assert level.slope == pytest.approx(worst.slope, rel=1e-5)


def test_additional_mass_remains():
    """A stated mass above that of the section remains as additional mass; without a section all of
    it remains.
    """
    joint = two_links().joints[0]
    own = joint.link.total_mass
    stated = joint.model_copy(update={"link": joint.link.model_copy(update={"mass": own + 0.7})})
    thin = Tube(outer=0.06, wall=0.002)
    bare = with_section(joint, thin).link.total_mass
    assert with_section(stated, thin).link.total_mass == pytest.approx(bare + 0.7)
    rigid = joint.model_copy(
        update={
            "link": joint.link.model_copy(update={"mass": 2.0, "section": None, "material": None})
        }
    )
    assert with_section(rigid, thin, ALUMINIUM).link.total_mass == pytest.approx(bare + 2.0)
    steel = materials()["steel"]
    assert with_section(joint, thin, steel).link.total_mass == pytest.approx(
        bare * steel.density / ALUMINIUM.density
    )


def test_wider_limits_give_lighter_links_and_larger_errors():
    """Along the trade-off mass falls and the tool error grows, and at the stated limits both are
    those of the sized arm.
    """
    arm = two_links()
    sizing = size_links(
        arm,
        {"shoulder": LinkOptions(family_around(Tube(outer=0.08, wall=0.003)))},
        PAPER,
        lostmotion.sample_poses(arm, 64),
    )
    masses, errors = (
        [getattr(each, name) for each in sizing.trade_off] for name in ("mass", "rms_error")
    )
    assert all(a > b for a, b in itertools.pairwise(masses))
    assert all(a < b for a, b in itertools.pairwise(errors))
    here = next(each for each in sizing.trade_off if each.scale == 1)
    assert here.mass == pytest.approx(sizing.links[0].mass)
    assert here.rms_error == pytest.approx(sizing.rms_error)
    assert sizing.unchanged == ("elbow",)


def test_the_exact_error_is_that_of_a_study():
    """The r.m.s. error of the exact sums is the root of bias squared plus variances, term by
    term.
    """
    arm = two_links()
    q = lostmotion.sample_poses(arm, 32).q
    matrix = lostmotion.screws(lostmotion.state_of(arm, q))
    drawn = [k for k, info in enumerate(matrix.infos) if info.level != "design"]
    square = np.sum(matrix.bias[:, 3:] ** 2) + sum(
        np.sum(matrix.tool[:, 3:, k] ** 2) for k in drawn
    )
    assert rms_error(arm, q) == pytest.approx(math.sqrt(square / len(q)), rel=1e-12)


def test_additional_poses_are_used():
    """A link is sized for an additional pose that is worse than all others."""
    arm = two_links()
    folded = Poses(np.array([[-1.5, -2.0], [-1.5, -1.9]]), "given")
    wanted = {"shoulder": LinkOptions(TubeFamily(outer="30 mm .. 160 mm", wall="3 mm"))}
    sizing = size_links(arm, wanted, PAPER, folded, also=np.array([[0.0, 0.0]]))
    assert sizing.given == 1
    worst = sizing.q[sizing.links[0].index]
    assert abs(worst[1]) < 0.2
    assert largest(sizing.sized, np.array([[0.0, 0.0]]))["shoulder"][0] <= 1 + 1e-6


def test_a_family_around_a_section_holds_it():
    """The family made from a section has sections of its kind and walls, from well below to well
    above it.
    """
    for section in (
        Tube(outer=0.08, wall=0.003),
        Rod(diameter=0.03),
        Box(width=0.03, height=0.06, wall=0.002),
        Rectangle(width=0.02, height=0.05),
    ):
        family = family_around(section)
        values = tuple(
            getattr(section, name) / (section.height if span.share else 1)
            for name, span in zip(family.names, family.spans, strict=True)
        )
        assert family.section(values) == section
        assert family.spans[0].low < values[0] < family.spans[0].high
        assert family.section(tuple(span.low for span in family.spans)) is not None
    flanged = ISection(width=0.04, height=0.08, web=0.003, flange=0.005)
    assert (
        family_around(flanged).section(tuple(span.low for span in family_around(flanged).spans))
        is not None
    )


def test_the_search_never_leaves_the_family():
    """The stiffest section of a family too weak is its largest, and its misfit is what the whole
    look says.
    """
    arm = two_links()
    sought, _ = task(arm, 0)
    found = lightest(sought, RodFamily(diameter="10 mm .. 30 mm"), 1e-4)
    assert found.section.diameter == 0.03
    assert found.utilisation == pytest.approx(
        float(sought.section_utilisation(found.section).max())
    )
    assert not found.meets_limits


@pytest.mark.usefixtures("few_scales")
def test_an_arm_of_every_joint_is_sized_and_one_without_load_gets_the_smallest():
    """Links behind fixed and prismatic joints are sized too; without weight the smallest section is
    enough and no limit governs.
    """
    section = Tube(outer=0.08, wall=0.003)
    link = {"length": 0.3, "section": section, "material": ALUMINIUM}
    joints = [
        {"name": "post", "type": "fixed", "link": link},
        {"name": "slide", "type": "prismatic", "axis": "x", "limits": (0.0, 0.2), "link": link},
        {"name": "wrist", "type": "revolute", "axis": "y", "limits": (-1.0, 1.0), "link": link},
    ]
    wanted = {
        name: LinkOptions(TubeFamily(outer="20 mm .. 200 mm", wall="2 mm"))
        for name in ("post", "slide", "wrist")
    }
    arm = Arm(name="all", joints=joints, payload={"mass": 5.0})
    sizing = size_links(arm, wanted, PAPER, lostmotion.sample_poses(arm, 16))
    assert [link.joint for link in sizing.links] == ["post", "slide", "wrist"]
    assert sizing.meets_limits
    assert all(0.98 < max(link.utilisation) <= 1 for link in sizing.links)
    assert sizing.q[sizing.links[0].index][0] == pytest.approx(0.2)
    weightless = arm.model_copy(update={"gravity": 0.0})
    free = size_links(weightless, wanted, PAPER, lostmotion.sample_poses(arm, 16), tilt=0.1)
    assert all(link.section.outer == 0.02 for link in free.links)
    assert all(max(link.utilisation) == 0 for link in free.links)


def test_a_range_may_begin_with_impossible_tubes():
    """Where the smallest tubes of a range are impossible, the search uses the others."""
    sought, _ = task(two_links(), 1)
    found = lightest(sought, TubeFamily(outer="10 mm .. 200 mm", wall="8 mm"), 1e-4)
    assert found.meets_limits
    assert sought.section_utilisation(Tube(outer=found.section.outer - 2e-4, wall=0.008)).max() > 1
    both = lightest(sought, TubeFamily(outer="10 mm .. 200 mm", wall="1 mm .. 20 mm"), 1e-4)
    assert both.meets_limits
    assert both.section.wall == 0.001
