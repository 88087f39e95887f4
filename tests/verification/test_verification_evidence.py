"""What explains a difference: its parts one by one, against closed forms and full computations."""

from __future__ import annotations

from functools import cache
from itertools import pairwise, permutations
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from verification_injections import told_by

import mecanique as mq
from mecanique.derivation.numeric.recursion import Recursion
from mecanique.model import slips
from mecanique.model.bodies.tensor import moments_of
from mecanique.verification.causes import joints, links, search
from mecanique.verification.causes.evidence import (
    Amount,
    Evidence,
    Hypothesis,
    TreeChange,
    descend,
    fit,
    give,
    promising,
    say_turn,
    turn_about,
)
from mecanique.verification.states import random_states
from mecanique.verification.verdict import LikelyCause

Array = Any


def spatial_arm(factor: float = 1.0) -> mq.Mechanism:
    """Two boxes on hinges about crooked axes, the second with its mass times a factor."""
    first = mq.box(2.0, (0.3, 0.1, 0.2)).at((0.1, -0.2, 0.3), rpy=(0.3, 0.2, -0.4))
    second = mq.box(1.5 * factor, (0.1, 0.4, 0.2)).at((-0.2, 0.1, 0.2), rpy=(0.5, -0.7, 0.1))
    place = mq.Placement((0.4, 0.1, -0.2), (0.2, -0.3, 0.6))
    damper = mq.JointDamper("damper", "two", 0.7)
    return mq.Mechanism(
        "spatial",
        (mq.Body("ground"), mq.Body("a", first), mq.Body("b", second)),
        (
            mq.Revolute("one", "ground", "a", axis=(0.6, 0, 0.8), origin=mq.Placement((0, 0, 1.3))),
            mq.Revolute("two", "a", "b", axis=(0, 0.6, 0.8), origin=place),
        ),
        gravity=(0, 0, -9.81),
        forces=(damper,),
    )


@cache
def evidence() -> Evidence:
    ours, theirs = spatial_arm(), spatial_arm(1.3)
    states = random_states(ours, 6, 0)
    found = Evidence.of(ours, states, told_by(theirs)(states))
    assert found is not None
    return found


def samples(tau: Array, mechanism: mq.Mechanism | None = None) -> Evidence:
    """Evidence that consists of measured forces (n, nv)."""
    mechanism = spatial_arm() if mechanism is None else mechanism
    states = random_states(mechanism, len(tau), 0)
    found = Evidence.of(mechanism, states, {"inverse dynamics": tau})
    assert found is not None
    return found


def test_every_kind_of_experiment_weighs_one() -> None:
    """The larger of both sources' answers of a kind has the norm one, whatever its unit."""
    some = evidence()
    kinds = set(some.kind)
    assert kinds == {"mass matrix", "bias", "gravity", "forces"}
    for kind in kinds:
        rows = some.kind == kind
        sizes = [np.linalg.norm((x * some.weights)[rows]) for x in (some.tau, some.base)]
        assert max(sizes) == pytest.approx(1.0, rel=1e-12)
    # the entries have the unit of the roots of the masses
    ratio = some.weights[:, 0] / some.weights[:, 1]
    states = random_states(some.mechanism, 6, 0)
    M = Recursion(some.mechanism).mass_matrix(states)
    mean = np.diagonal(M, axis1=1, axis2=2).mean(axis=0)
    np.testing.assert_allclose(ratio, np.sqrt(mean[1] / mean[0]), rtol=0.05, atol=0)


def test_measured_forces_weigh_by_what_each_joint_bears() -> None:
    """An error of a twentieth of the root mean square in every joint is a twentieth."""
    tau = np.random.default_rng(1).normal(size=(50, 2)) * [100.0, 1e-3]
    some = samples(tau)
    assert some.is_measured
    assert not evidence().is_measured
    rms = np.sqrt((tau**2).mean(axis=0))
    assert some.misfit(tau + 0.05 * rms) == pytest.approx(0.05, rel=1e-12)
    assert some.misfit(tau) == 0
    # a joint that bears less than a billionth is judged by the largest
    for part, judged_by in ((0.0, 1.0), (0.9e-9, 1.0), (1.1e-9, 1.1e-9)):
        tau[:, 1] = part * np.sqrt((tau**2).mean(axis=0)[0])
        off = np.zeros_like(tau)
        off[:, 1] = 0.1 * judged_by * np.sqrt((tau**2).mean(axis=0)[0])
        assert samples(tau).misfit(tau + off) == pytest.approx(0.1 / np.sqrt(2), rel=1e-9)


def test_two_experiments_of_each_kind_choose() -> None:
    some = evidence()
    assert list(some.kind[some.few]) == [k for k in dict.fromkeys(some.kind) for _ in range(2)]


def test_many_changed_trees_answer_as_one_by_one_and_in_some_experiments_alone() -> None:
    some = evidence()
    J = some.recursion.moments[1]
    trees = [TreeChange(moments={1: k * J}) for k in (0.5, 1.0, 2.0)]
    trees.append(
        TreeChange(origins={0: some.recursion.origins[1]}, turns={1: np.diag([1, -1, -1, 1.0])})
    )
    together = some.change(trees)
    np.testing.assert_allclose(together[1], some.base, rtol=1e-12, atol=1e-12)
    for k, tree in enumerate(trees):
        np.testing.assert_allclose(some.change([tree])[0], together[k], rtol=1e-12, atol=1e-12)
    rows = np.array([3, 1])
    np.testing.assert_allclose(some.change(trees, rows), together[:, rows], rtol=1e-12, atol=1e-12)
    # masses enter linearly
    half = (together[2] - together[1]) - 2 * (together[1] - together[0])
    np.testing.assert_allclose(half, 0, rtol=0, atol=1e-10)


def test_what_is_chosen_already_counts_no_more() -> None:
    some = evidence()
    direction = np.random.default_rng(0).normal(size=(1, *some.tau.shape))
    left = some.after(np.zeros_like(some.tau), TreeChange(), direction)
    assert np.linalg.norm(left.weigh(direction)) < 1e-12
    assert np.linalg.norm(some.weigh(direction)) > 1e-3
    other = np.random.default_rng(1).normal(size=some.tau.shape)
    along = float((left.weigh(other) * some.weigh(direction)[0]).sum())
    assert abs(along) < 1e-12
    assert left.weights is some.weights
    assert some.chosen is None
    # of directions that differ by less than a billionth only one is chosen
    aside = other * np.linalg.norm(some.weigh(direction)) / np.linalg.norm(some.weigh(other))
    for apart, count in ((1e-8, 2), (1e-10, 1)):
        both = 1e6 * np.concatenate([direction, direction + apart * aside])
        chosen = some.after(np.zeros_like(some.tau), TreeChange(), both).chosen
        assert chosen is not None
        assert chosen.shape[1] == count


def test_a_change_of_the_tree_is_what_the_next_one_begins_with() -> None:
    some = evidence()
    tree = TreeChange(moments={1: 1.3 * some.recursion.moments[1]})
    left = some.after(np.zeros_like(some.tau), tree, None)
    np.testing.assert_allclose(left.base, some.change([tree])[0], rtol=1e-12, atol=1e-12)
    np.testing.assert_array_equal(left.tau, some.tau)
    plain = some.after(some.tau - some.base, TreeChange(), None)
    np.testing.assert_allclose(plain.tau, some.base, rtol=1e-12, atol=1e-12)
    assert plain.before < 1e-12


def test_amounts_of_effects_are_fitted_by_weighted_least_squares() -> None:
    some = evidence()
    random = np.random.default_rng(0)
    columns = random.normal(size=(3, *some.tau.shape)) * np.array([1e-3, 1.0, 1e3])[:, None, None]
    columns[1] = 0.0
    amounts, answers = fit(some, columns)
    assert amounts[1] == 0
    np.testing.assert_allclose(
        answers, some.base + amounts[0] * columns[0] + amounts[2] * columns[2], rtol=1e-12, atol=0
    )
    # what is left stands at right angles to every effect
    rest = ((some.tau - answers) * some.weights).ravel()
    for k in (0, 2):
        column = (columns[k] * some.weights).ravel()
        assert abs(rest @ column) < 1e-10 * np.linalg.norm(rest) * np.linalg.norm(column)
    np.testing.assert_array_equal(fit(some, 0 * columns)[0], 0)
    # an effect below 1e-12 of the largest is rounding
    for part, counts in ((1e-11, True), (1e-13, False)):
        size = 1e6 * np.array([1.0, part])[:, None, None]
        faint = np.stack([columns[0], columns[2] / 1e6]) * size
        assert (fit(some, faint)[0][1] != 0) == counts


def test_descent_ends_at_the_least_squares_of_each_problem() -> None:
    """A valley (10 (y − x²), 1 − x), and lines that miss the origin by a distance."""

    def residuals(trials: list[tuple[int, Array]]) -> Array:
        rows = []
        for k, x in trials:
            if k < 2:
                rows.append([10 * (x[1] - x[0] ** 2), 1 - x[0], 0.0])
            else:
                rows.append([x[0] - 2, x[0] + x[1] - 4, 0.5])
        return np.array(rows)

    starts = [np.array([-1.2, 1.0]), np.array([0.5, 0.0]), np.zeros(2), np.array([np.nan, 0.0])]
    unknowns, cost = descend(residuals, starts)
    np.testing.assert_allclose(unknowns[1], [1, 1], rtol=0, atol=1e-7)
    np.testing.assert_allclose(unknowns[2], [2, 2], rtol=0, atol=1e-6)
    assert cost[1] < 1e-7
    assert cost[2] == pytest.approx(0.5, rel=1e-9)
    assert np.isnan(cost[3])
    for k, x in enumerate(unknowns[:3]):
        assert cost[k] == pytest.approx(np.linalg.norm(residuals([(k, x)])), rel=1e-12, abs=1e-15)
    # where a full step would lead farther away, shorter ones do not
    (angle,), (left,) = descend(lambda trials: np.arctan([x for _, x in trials]), [np.array([2.5])])
    assert abs(angle[0]) < 1e-9
    assert left < 1e-9
    # only the best go on once it is seen which these are
    one = descend(residuals, [np.array([-1.2, 1.0]), np.array([0.99, 0.98])], 1)[1]
    assert one[1] < 1e-10
    assert one[0] > 1e-3


@pytest.mark.parametrize(
    ("value", "sigma", "text"),
    [
        (2.0, 0.0, "2"),
        (2.0, 2e-6, "2"),
        (2.0, 2.1e-6, "2.0000000 ± 0.0000021"),
        (1234.5678, 0.034, "1234.568 ± 0.034"),
        (-3.2, 12.0, "-3 ± 12"),
        (0.5, 0.1, "0.50 ± 0.10"),
    ],
)
def test_a_deviation_is_given_with_two_digits_where_it_can_be_seen(
    value: float, sigma: float, text: str
) -> None:
    assert give(value, sigma) == text


def assert_amount(amount: Amount, digits: int, ways: int, share: float) -> None:
    assert (amount.digits, amount.ways) == (digits, ways)
    assert amount.share == pytest.approx(share, rel=1e-9)


def test_how_plain_a_number_is() -> None:
    """The digits that state it, as itself, as a difference or as a factor; five are any number."""
    assert Amount.of(1234.0).digits == 4
    assert Amount.of(12345.0).digits == 6
    assert Amount.of(0.00250).digits == 2
    assert Amount.of(1e6).digits == 1
    assert_amount(Amount.of(2.34567 + 0.02, 2.34567), 1, 1, 0.02 / 2.34567)
    assert Amount.of(1.2 * 2.34567, 2.34567).digits == 2
    assert_amount(Amount.of(0.3, 0.1, beside=4.0, ways=3), 1, 3, 0.05)
    assert_amount(Amount.of_all(np.array([3.0, -4.0]), 10.0), 1, 2, 0.5)
    assert Amount.of_all(np.array([3.0, 4.0]), 0.0).share == 1.0


@pytest.mark.parametrize("angle", [0.3, np.pi / 2, 3.0])
def test_a_turn_is_told_by_angle_and_axis(angle: float) -> None:
    axis = np.array([2.0, -1.0, 2.0]) / 3
    R = turn_about(angle * axis)
    assert np.trace(R) == pytest.approx(1 + 2 * np.cos(angle), abs=1e-12)
    np.testing.assert_allclose(R @ axis, axis, rtol=0, atol=1e-12)
    across = np.cross(axis, [1.0, 0, 0])
    assert np.cross(across, R @ across) @ axis > 0
    assert (
        say_turn(angle * axis) == f"{np.degrees(angle):.6g}° about (0.666667, -0.333333, 0.666667)"
    )


def test_of_many_guesses_those_that_explain_two_experiments_of_each_kind_best_are_tried() -> None:
    some = evidence()
    J = some.recursion.moments[1]
    guesses = [
        joints.Frames("mass", "b", f"{k}", TreeChange(moments={1: k * J}))
        for k in np.linspace(0.2, 2, 19)
    ]
    asked: list[tuple[int, int]] = []

    def answer(few: list[joints.Frames], rows: Array) -> Array:
        asked.append((len(few), len(rows)))
        return some.change([guess.tree for guess in few], rows)

    kept = list(promising(some, guesses, answer))
    assert asked == [(19, len(some.few)), (8, len(some.tau))]
    nearest = sorted(guesses, key=lambda guess: abs(float(guess.text) - 1.3))[:6]
    assert {guess.text for guess in nearest} <= {one.text for one in kept}
    best = min(kept, key=lambda one: float(some.residual(one.answers)))
    assert float(best.text) == pytest.approx(1.3, rel=1e-9)
    assert some.residual(best.answers) < 1e-12
    asked.clear()
    assert len(list(promising(some, guesses[:8], answer))) == 8
    assert asked == [(8, len(some.tau))]


def test_a_turn_carries_one_direction_to_another_by_the_smallest_angle() -> None:
    random = np.random.default_rng(0)
    pairs = [random.normal(size=(2, 3)) for _ in range(5)]
    a, e = np.array([0.6, 0.0, 0.8]), np.eye(3)
    pairs += [np.array(x) for x in ((a, a), (a, -a), (e[0], -e[0]), (e[2], -e[2]), (e[0], e[1]))]
    pairs.append(np.array([[1.0, 2.0, -2.0], [-1.0, -2.0, 2.0]]))
    for pair in pairs:
        first, second = pair / np.linalg.norm(pair, axis=1, keepdims=True)
        R = joints._from_to(first, second)
        np.testing.assert_allclose(R @ first, second, rtol=0, atol=1e-12)
        np.testing.assert_allclose(R @ R.T, np.eye(3), rtol=0, atol=1e-12)
        assert np.linalg.det(R) > 0
        assert (np.trace(R) - 1) / 2 == pytest.approx(first @ second, abs=1e-12)


def test_mass_moments_give_mass_center_and_inertia_back() -> None:
    m, c = 2.0, np.array([0.1, -0.2, 0.3])
    inertia = np.array([[0.3, 0.01, 0.02], [0.01, 0.4, -0.03], [0.02, -0.03, 0.5]])
    mass, center, tensor = links.parts_of(moments_of(m, c, inertia))
    assert mass == m
    np.testing.assert_allclose(center, c, rtol=0, atol=1e-14)
    np.testing.assert_allclose(tensor, inertia, rtol=0, atol=1e-14)
    mass, center, _ = links.parts_of(moments_of(0.0, c, inertia))
    assert (mass, *center) == (0, 0, 0, 0)
    # a center of mass farther out, with the inertia about it as it was
    for weight, place in ((m, c), (m, np.array([0.1, 0.2, 0.0])), (0.0, c)):
        shifted = joints._shift(moments_of(weight, place, inertia), 3.0)
        expected = moments_of(weight, 3 * place, inertia)
        np.testing.assert_allclose(shifted, expected, rtol=0, atol=1e-14)


def test_a_link_of_any_moments_is_judged_by_ten_rows_as_by_all() -> None:
    """√(rest² + |what is left of ten|²) is the norm of all that is left."""
    some = evidence()
    J = some.recursion.moments[0]
    effect = links.LinkEffect.of(some, some.regressor[:, :, 0])
    random = np.random.default_rng(0)
    changed = [2 * J, J + (E := random.normal(size=(4, 4))) + E.T, J]
    answers = effect.answer(some, changed, J)
    np.testing.assert_allclose(
        answers, some.change([TreeChange(moments={0: x}) for x in changed]), rtol=1e-9, atol=1e-9
    )
    left = np.hypot(effect.rest, np.linalg.norm(effect.reduce(changed, J), axis=1))
    np.testing.assert_allclose(left, [some.misfit(x) for x in answers], rtol=1e-9, atol=0)
    solution, least = effect.any_change
    columns = (effect.columns * some.weights[..., None]).reshape(-1, 10)
    off = ((some.tau - some.base) * some.weights).ravel()
    assert least == pytest.approx(np.linalg.norm(off - columns @ solution), rel=1e-9)
    assert least == pytest.approx(
        np.linalg.norm(off - columns @ np.linalg.lstsq(columns, off, rcond=1e-12)[0]), rel=1e-9
    )


def test_each_slip_of_a_link_changes_what_its_words_say_and_nothing_else() -> None:
    m, c = 2.0, np.array([0.1, -0.2, 0.3])
    inertia = np.array([[0.3, 0.01, 0.02], [0.01, 0.4, -0.03], [0.02, -0.03, 0.5]])
    J, pose = moments_of(m, c, inertia), np.eye(4)
    pose[:3, :3], pose[:3, 3] = turn_about(np.array([0.3, -0.5, 0.7])), [1.0, 2.0, -0.5]
    frame = turn_about(np.array([0.2, 0.4, -0.1]))
    found = [
        (what, slip, *links.parts_of(slip.value))
        for what, slip in links._variants(J, pose, frame, root=False)
    ]
    assert len(found) > 40
    assert len({(what, slip.text, slip.value.tobytes()) for what, slip, *_ in found}) == len(found)
    for what, slip, mass, center, tensor in found:
        if what in ("center of mass", "inertia") or what.startswith("center of mass and"):
            assert mass == pytest.approx(m, rel=1e-12)
        if what in ("mass", "inertia"):
            np.testing.assert_allclose(center, c, rtol=0, atol=1e-12)
        if what in ("mass", "center of mass"):
            size = 1e-9 * max(1.0, float(np.abs(slip.value).max()))
            np.testing.assert_allclose(tensor, inertia, rtol=0, atol=size)
        if what == "mass and inertia":
            np.testing.assert_allclose(tensor, mass / m * inertia, rtol=1e-9, atol=1e-12)
        if what.startswith("center of mass and"):
            factor = center[0] / c[0]
            np.testing.assert_allclose(center, factor * c, rtol=1e-12, atol=0)
            np.testing.assert_allclose(tensor, factor**2 * inertia, rtol=1e-6, atol=1e-9)
    texts = {(what, slip.text): slip.value for what, slip, *_ in found}
    for factor, _, text in slips.GRAMS:
        said = f"{text} ({slips.say_factor(factor)})"
        np.testing.assert_allclose(texts["mass and inertia", said], factor * J, rtol=1e-12, atol=0)
        assert links.parts_of(texts["mass", said])[0] == pytest.approx(factor * m, rel=1e-12)
    for factor, _, text in slips.MILLIMETERS:
        said = f"{text} ({slips.say_factor(factor)})"
        center = links.parts_of(texts["center of mass", said])[1]
        np.testing.assert_allclose(center, factor * c, rtol=1e-12, atol=0)
    for factor, _, text in slips.INERTIA:
        said = f"{text} ({slips.say_factor(factor)})"
        tensor = links.parts_of(texts["inertia", said])[2]
        np.testing.assert_allclose(tensor, factor * inertia, rtol=1e-9, atol=1e-12)
    # units of mass and length at once are rarer, and stand last
    order = [slip.text for what, slip, *_ in found if what == "inertia"]
    rare = [f"{u.text} ({slips.say_factor(u.factor)})" for u in slips.INERTIA[4:]]
    assert order[-len(rare) :] == rare
    assert len(links.parts_of(texts["center of mass", "left out"])[1].nonzero()[0]) == 0
    np.testing.assert_array_equal(texts["mass and inertia", "counted twice"], 2 * J)
    np.testing.assert_array_equal(texts["mass and inertia", "left out"], 0 * J)


def test_an_inertia_in_other_axes_or_about_the_world_is_turned_or_moved() -> None:
    m, c = 2.0, np.array([0.1, -0.2, 0.3])
    inertia = np.array([[0.3, 0.01, 0.02], [0.01, 0.4, -0.03], [0.02, -0.03, 0.5]])
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = turn_about(np.array([0.3, -0.5, 0.7])), [1.0, 2.0, -0.5]
    R, frame = pose[:3, :3], turn_about(np.array([0.2, 0.4, -0.1]))
    found: dict[str, list[Array]] = {}
    for what, slip in links._variants(moments_of(m, c, inertia), pose, frame, root=True):
        if what == "inertia":
            found.setdefault(slip.text, []).append(links.parts_of(slip.value)[2])
    for said, turn in (("world's", R), ("parent's", frame)):
        (there,), (back,) = (
            found[f"in the {said} axes{more}"] for more in ("", ", turned the wrong way")
        )
        np.testing.assert_allclose(there, turn.T @ inertia @ turn, rtol=0, atol=1e-12)
        np.testing.assert_allclose(back, turn @ inertia @ turn.T, rtol=0, atol=1e-12)
    # Steiner's part of the way from the world's origin, in the link's axes
    way = c + R.T @ pose[:3, 3]
    steiner = m * (way @ way * np.eye(3) - np.outer(way, way))
    (about,), (moved,) = (
        found["about the world's origin"],
        found["moved from the world's origin, in vain"],
    )
    np.testing.assert_allclose(about, inertia + steiner, rtol=0, atol=1e-10)
    np.testing.assert_allclose(moved, inertia - steiner, rtol=0, atol=1e-10)
    principal = np.linalg.eigvalsh(inertia)
    for tensor in found["in its axes of figure"]:
        np.testing.assert_allclose(np.diag(np.diag(tensor)), tensor, rtol=0, atol=1e-12)
        np.testing.assert_allclose(np.sort(np.diag(tensor)), principal, rtol=0, atol=1e-12)
    assert len(found["in its axes of figure"]) == 6
    light = links._variants(moments_of(1e-9 * m, c, 1e-9 * inertia), pose, frame, root=True)
    assert sum(slip.text == "in its axes of figure" for _, slip in light) == 6


@pytest.mark.parametrize(
    ("mass", "moments", "physical"),
    [
        (1.0, (1.0, 2.0, 3.0), True),
        (0.0, (0.0, 0.0, 0.0), True),
        (-1e-9, (1.0, 2.0, 3.0), False),
        (1.0, (-0.9e-9, 1.0, 1.0), True),
        (1.0, (-1.9e-9, 1.0, 2.0), True),
        (1.0, (-1.1e-9, 1.0, 1.0), False),
        (1.0, (np.nan, 1.0, 1.0), False),
    ],
)
def test_no_body_has_a_negative_mass_or_moment(
    mass: float, moments: tuple[float, float, float], physical: bool
) -> None:
    assert links._is_physical(mass, np.zeros(3), np.diag(moments)) == physical
    assert not links._is_physical(mass, np.array([np.inf, 0, 0]), np.diag(moments))


def ranking(
    left: list[tuple[float, str, str, int]], before: float = 0.3
) -> tuple[LikelyCause, ...]:
    """Causes of changes given by what each leaves, its kind, its place and how many it fits."""
    changes = [
        Hypothesis(kind, where, f"{kind} {where} {k}", np.array([after]), free)
        for k, (after, kind, where, free) in enumerate(left)
    ]
    some: Any = SimpleNamespace(
        before=before, is_measured=False, residual=lambda answers: float(answers[0])
    )
    return search._rank(some, changes)


def test_a_change_that_leaves_more_than_half_is_not_worth_a_word() -> None:
    assert [c.after for c in ranking([(0.15, "a", "x", 0), (0.1501, "b", "y", 0)])] == [0.15]
    assert ranking([(0.151, "a", "x", 0)]) == ()


def test_of_changes_that_explain_as_well_the_plainest_is_first_and_has_the_others_alike() -> None:
    """Within a fifth of the least, fewer numbers first; others by what they leave."""
    causes = ranking(
        [(0.1, "a", "x", 3), (0.119, "b", "y", 1), (0.121, "c", "z", 0), (0.12, "d", "w", 1)]
    )
    assert [cause.kind for cause in causes] == ["b", "d", "a", "c"]
    assert [cause.kind for cause in causes[0].alike] == ["d", "a"]
    assert not any(cause.alike for cause in causes[1:])


def test_of_one_mistake_in_one_place_only_the_plainest_stays() -> None:
    causes = ranking([(0.1, "a", "x", 3), (0.1, "a", "x", 1), (0.1, "a", "y", 2)])
    assert [cause.text for cause in causes] == ["a x 1", "a y 2"]


def test_beside_a_change_that_removes_the_difference_only_others_that_do_stand() -> None:
    least = [(1e-12, "a", "x", 0), (0.9e-8, "b", "y", 0), (1.1e-8, "c", "z", 0)]
    causes = ranking([*least, (1e-12, "other inertia", "w", 9)])
    assert [cause.kind for cause in causes] == ["a", "b"]
    assert [cause.kind for cause in causes[0].alike] == ["b"]
    # of a small difference a ten thousandth
    causes = ranking([(1e-12, "a", "x", 0), (0.9e-9, "b", "y", 0), (1.1e-9, "c", "z", 0)], 1e-5)
    assert [cause.kind for cause in causes[0].alike] == ["b"]


def test_five_causes_are_told_at_most() -> None:
    causes = ranking([(0.1 + 0.001 * k, f"{k}", "x", 0) for k in range(9)])
    assert len(causes) == 5
    assert len(causes[0].alike) == 8


def test_samples_choose_by_information_and_ways_to_make_a_slip() -> None:
    """n ln s² + k ln n + 2 ln ways, ten less than without, and rivals within ten of the best."""
    n = 200

    def told(*changes: tuple[float, int, int]) -> list[tuple[str, list[str]]]:
        tried = [
            Hypothesis(f"{k}", "x", f"{k}", np.zeros(1), free, Amount(ways=ways))
            for k, (_, free, ways) in enumerate(changes)
        ]
        some: Any = SimpleNamespace(before=0.5, tau=np.zeros((n // 2, 2)))
        after = np.array([one[0] for one in changes])
        causes = search._rank_samples(some, tried, after)
        return [(cause.kind, [one.kind for one in cause.alike]) for cause in causes]

    def worse(by: float) -> float:
        """The factor of what is left that costs so much."""
        return float(np.exp(by / (2 * n)))

    assert told((0.5 / worse(10.1), 0, 1)) == [("0", [])]
    assert told((0.5 / worse(9.9), 0, 1)) == []
    assert told((0.5 / worse(10.1 + np.log(n)), 1, 1)) == [("0", [])]
    assert told((0.5 / worse(9.9 + np.log(n)), 1, 1)) == []
    assert told((0.5 / worse(10.1 + 2 * np.log(7)), 0, 7)) == [("0", [])]
    assert told((0.5 / worse(9.9 + 2 * np.log(7)), 0, 7)) == []
    # what is left below 1e-8 is rounding: of 0 and 0.3e-8, the second is ln 1.09 a sample worse
    assert told((0.0, 0, 1), (0.1e-8, 0, 1)) == [("0", ["1"]), ("1", [])]
    assert told((0.0, 0, 1), (0.3e-8, 0, 1)) == [("0", []), ("1", [])]
    best = (0.1, 0, 1)
    assert told(best, (0.1 * worse(9.9), 0, 1)) == [("0", ["1"]), ("1", [])]
    assert told(best, (0.1 * worse(10.1), 0, 1)) == [("0", []), ("1", [])]
    assert [kind for kind, _ in told((0.1, 1, 1), best)] == ["1", "0"]


def test_other_orders_of_coordinates_are_each_named_once_with_its_inverse() -> None:
    names = ["b", "c", "a"]
    found = {tuple(order): text for text, order in joints._orders(names)}
    assert found == {
        ("a", "b", "c"): "coordinates in alphabetical order",
        ("c", "a", "b"): "coordinates in alphabetical order",
        ("a", "c", "b"): "coordinates in reverse order",
        ("c", "b", "a"): "coordinates 'b' and 'c' exchanged",
        ("b", "a", "c"): "coordinates 'c' and 'a' exchanged",
    }
    assert list(joints._orders(["q"])) == []


def test_experiments_ask_one_thing_each() -> None:
    """M a at rest and without gravity, bias at constant velocity, gravity at rest, and loads."""
    some = evidence()
    inputs, kinds = some.inputs, list(dict.fromkeys(some.kind))
    assert kinds == ["mass matrix", "bias", "gravity", "forces"]
    flags = {
        "mass matrix": (False, True, True, False, False),
        "bias": (True, False, True, True, False),
        "gravity": (False, False, True, True, False),
        "forces": (True, False, False, True, True),
    }
    for kind, (moves, accelerates, inertia, heavy, loads) in flags.items():
        rows = some.kind == kind
        assert inputs.v[rows].any() == moves
        assert inputs.a[rows].any() == accelerates
        assert (inputs.inertia[rows] == inertia).all()
        assert (inputs.heavy[rows] == heavy).all()
        assert (inputs.loads[rows] == loads).all()
    assert all(a <= b for a, b in pairwise(map(kinds.index, some.kind)))
    np.testing.assert_allclose(
        some.tau[some.kind == "forces"],
        0.7 * inputs.v[some.kind == "forces"] * [0, 1],
        atol=1e-12,
        rtol=0,
    )
    np.testing.assert_allclose(
        some.base[some.kind == "forces"], some.tau[some.kind == "forces"], atol=1e-12, rtol=0
    )
    a = inputs.a[some.kind == "mass matrix"]
    states = random_states(some.mechanism, 6, 0)
    sizes = np.abs(a).mean(axis=0) / np.abs(states.v).mean(axis=0)
    assert ((sizes > 0.3) & (sizes < 3)).all()


def test_each_family_of_a_link_says_what_it_changes_and_how_plain_that_is() -> None:
    """At numbers of a quarter; without any, nothing is changed."""
    some, J = evidence(), evidence().recursion.moments[1]
    m, c, inertia = links.parts_of(J)
    effect = links.LinkEffect.of(some, some.regressor[:, :, 1])
    families = list(links._families(links._Link(1, "link 'b'", J), effect, root=False))
    size, third = np.sqrt(np.trace(inertia) / m), np.trace(inertia) / 3
    quarter, whole = size / 4 * np.eye(3), third / 4 * np.ones((3, 3))
    point = moments_of(m, c, inertia)
    point[3, 3] += m / 4
    expected: list[tuple[str, str, Any, Amount]] = [
        (
            "link mass",
            f"mass of link 'b': {1.25 * m:.6g} kg",
            (1.25 * m, c, inertia),
            Amount.of(1.25 * m, m, ways=1),
        ),
        (
            "link mass",
            f"times 1.25 (mass {1.25 * m:.6g} kg)",
            (1.25 * m, c, 1.25 * inertia),
            Amount.of(1.25 * m, m, ways=7),
        ),
        (
            "link mass",
            f"a point mass of {m / 4:.6g} kg more",
            links.parts_of(point),
            Amount.of(1.25 * m, m, ways=10),
        ),
        *(
            (
                "center of mass",
                f"moved by {size / 4:.6g} m along {'xyz'[k]}",
                (m, c + quarter[k], inertia),
                Amount.of(c[k] + size / 4, c[k], float(np.linalg.norm(c)), ways=3),
            )
            for k in range(3)
        ),
        (
            "center of mass",
            f"moved by ({size / 4:.6g}, ",
            (m, c + size / 4, inertia),
            Amount.of_all(np.full(3, size / 4), float(np.linalg.norm(c))),
        ),
        ("inertia", "times 1.25", (m, c, 1.25 * inertia), Amount.of(1.25, 1.0, ways=6)),
    ]
    for i, k in ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)):
        new = inertia.copy()
        new[i, k] = new[k, i] = inertia[i, k] + third / 4
        name, old = f"i{'xyz'[i]}{'xyz'[k]}", inertia[i, k]
        text = f"{name} of link 'b': {new[i, k]:.6g} kg·m² instead of {old:.6g}"
        expected.append(("inertia", text, (m, c, new), Amount.of(new[i, k], old, ways=6)))
    turn = turn_about(np.full(3, 0.25))
    expected += [
        (
            "inertia turn",
            "turned by 24.8098° about (0.57735, ",
            (m, c, turn @ inertia @ turn.T),
            Amount.of_all(np.degrees(np.full(3, 0.25)), 180.0),
        ),
        (
            "inertia",
            f"izz = {inertia[0, 0] + third / 4:.6g}, ",
            (m, c, inertia + whole),
            Amount.of_all((inertia + whole)[np.triu_indices(3)], third),
        ),
    ]
    assert len(families) == len(expected)
    for family, (kind, text, moved, amount) in zip(families, expected, strict=True):
        assert family.kind == kind
        assert not family.starts[0].any()
        x = np.full(len(family.starts[0]), 0.25)
        assert text in family.say(x, np.zeros(len(x)))
        mass, center, tensor = links.parts_of(family.change(x).moments[1])
        assert mass == pytest.approx(moved[0], rel=1e-12)
        np.testing.assert_allclose(center, moved[1], rtol=1e-9, atol=1e-12)
        np.testing.assert_allclose(tensor, moved[2], rtol=1e-9, atol=1e-12)
        still = family.change(0 * x).moments[1]
        np.testing.assert_allclose(still, J, rtol=1e-12, atol=1e-14)
        assert_amount(family.amount(x), amount.digits, amount.ways, amount.share)
    for which in (0, 1, 7):
        times = Amount.of(2.5 * (m if which < 2 else 1.0), m if which < 2 else 1.0)
        assert families[which].amount(np.array([1.5])).digits == times.digits
    lighter = families[2].say(np.array([-0.25]), np.zeros(1))
    assert f"a point mass of {m / 4:.6g} kg less" in lighter


@pytest.mark.parametrize(
    ("inertia", "grams", "millimeters"),
    [
        (np.diag([0.3, 0.4, 0.5]) + 0.01, 1e3, 1.0),
        (np.diag([0.3, 0.4, 0.5]) + 0.01, 1.0, 1e3),
        (np.zeros((3, 3)), 1e3, 1.0),
    ],
    ids=["grams", "millimeters", "grams of a particle"],
)
def test_families_of_a_link_change_the_same_in_any_unit(
    inertia: Array, grams: float, millimeters: float
) -> None:
    some = evidence()
    effect = links.LinkEffect.of(some, some.regressor[:, :, 1])
    J = moments_of(2.5, np.array([0.5, -0.25, 1.0]), inertia)  # exact: a particle stays one
    units = np.diag([millimeters, millimeters, millimeters, 1.0])
    kilograms, others = (
        list(links._families(links._Link(1, "link 'b'", moments), effect, root=False))
        for moments in (J, grams * units @ J @ units)
    )
    assert len(kilograms) == len(others) == (16 if inertia.any() else 7)
    for family, other in zip(kilograms, others, strict=True):
        x = np.full(len(family.starts[0]), 0.25)
        changed, expected = other.change(x).moments[1], family.change(x).moments[1]
        assert np.abs(expected - J).max() > 1e-8
        np.testing.assert_allclose(
            changed, grams * units @ expected @ units, rtol=1e-9, atol=1e-12 * grams
        )


def test_turns_of_an_inertia_begin_on_all_sides() -> None:
    some = evidence()
    effect = links.LinkEffect.of(some, some.regressor[:, :, 1])
    link = links._Link(1, "link 'b'", some.recursion.moments[1])
    families = links._families(link, effect, root=False)
    (none, _, *others), *more = (f.starts for f in families if f.kind == "inertia turn")
    assert not more
    assert not none.any()
    assert (np.min(others, axis=0) < -0.5).all()
    assert (np.max(others, axis=0) > 0.5).all()


def test_each_family_of_a_joint_moves_turns_or_tilts_it_as_it_says() -> None:
    some = evidence()
    k, X = 1, evidence().recursion.origins[1]
    found = {family.way: family for family in joints._families(some, k)}
    p, R = X[:3, 3], X[:3, :3]
    size = float(max(np.linalg.norm(frame[:3, 3]) for frame in some.recursion.origins))
    assert joints._size(some) == pytest.approx(size, rel=1e-15)
    far, e, rpy = float(np.linalg.norm(p)), np.eye(3), np.array([0.2, -0.3, 0.6])
    moves: dict[str, tuple[Array, Array, str, Amount]] = {
        "longer": (1.25 * p, R, "times 1.25", Amount.of(1.25, 1.0, ways=3)),
        "shift": (
            p + size / 4,
            R,
            f"moved by ({size / 4:.6g}, ",
            Amount.of_all(np.full(3, size / 4), far),
        ),
        "turn": (
            p,
            R @ turn_about(np.full(3, 0.25)),
            "turned by 24.8098° about (0.57735, ",
            Amount.of_all(np.degrees(np.full(3, 0.25)), 180.0),
        ),
        "place": (
            p + size / 4,
            R @ turn_about(np.full(3, 0.25)),
            "and turned by 24.8098° about",
            Amount.of_all(np.full(3, size / 4), far),
        ),
    }
    for i, axis in enumerate("xyz"):
        moves[f"shift {axis}"] = (
            p + size / 4 * e[i],
            R,
            f"moved by {size / 4:.6g} m along {axis}",
            Amount.of(p[i] + size / 4, p[i], far, ways=3),
        )
        moves[f"turn {axis}"] = (
            p,
            R @ turn_about(0.25 * e[i]),
            f"turned by {np.degrees(0.25):.6g}° about its {axis}",
            Amount.of(np.degrees(0.25), beside=180.0, ways=3),
        )
        name, new = ("roll", "pitch", "yaw")[i], rpy + 0.25 * e[i]
        plain = [
            Amount.of(unit * new[i], unit * rpy[i], unit * np.pi, ways=3)
            for unit in (1.0, np.degrees(1.0))
        ]
        moves[name] = (
            p,
            slips.turn_of(new),
            f"{name} of joint 'two': {new[i]:.6g} rad instead of {rpy[i]:.6g}",
            min(plain),
        )
    assert found.keys() == {*moves, "tilt"}
    for name, (place, turn, text, amount) in moves.items():
        family = found[name]
        x = np.full(len(family.starts[0]), 0.25)
        frame = family.change(x).origins[k]
        np.testing.assert_allclose(frame[:3, 3], place, rtol=0, atol=1e-12)
        np.testing.assert_allclose(frame[:3, :3], turn, rtol=0, atol=1e-12)
        np.testing.assert_allclose(family.change(0 * x).origins[k], X, rtol=0, atol=1e-14)
        assert text in family.say(x, x), name
        assert_amount(family.amount(x), amount.digits, amount.ways, amount.share)
    # as plain as the factor or what it adds to one
    assert found["longer"].amount(np.array([1.5])).digits == 2
    # an axis is tilted to either side by the angle that is given
    along = np.array([0, 0.6, 0.8])
    for x in (np.array([0.25, 0.0]), np.array([0.0, -0.25])):
        turned = found["tilt"].change(x).turns[k][:3, :3] @ along
        assert turned @ along == pytest.approx(np.cos(0.25), abs=1e-12)
        digits = Amount.of_all(np.degrees(x), 180.0)
        assert found["tilt"].amount(x) == digits
        assert f"({', '.join(f'{c:.6g}' for c in turned)})" in found["tilt"].say(x, x)


def test_an_axis_along_another_is_reversed_once() -> None:
    pendulum = mq.textbook.load("double_pendulum")
    states = random_states(pendulum, 2, 0)
    some = Evidence.of(pendulum, states, told_by(pendulum)(states))
    assert some is not None
    axis = np.array(pendulum.joints[0].axis)  # type: ignore[union-attr]  # a hinge's
    tried = [change.tree.turns[0][:3, :3] @ axis for change in joints._axes(some, 0)]
    turned = {tuple((x.round(9) + 0.0).tolist()) for x in tried}
    assert len(turned) == len(tried) == 5


def test_axes_are_reversed_one_by_one_or_together() -> None:
    readings = joints._readings(evidence(), ["one", "two"])
    where = [reading.where for reading in readings if reading.kind == "axis sign"]
    assert where == ["joint 'one'", "joint 'two'", ""]


def test_slips_of_every_joint_are_those_of_each_together() -> None:
    """Only where more than one can be made: both joints are displaced, the second alone turned."""
    some = evidence()
    found = {frames.text: frames for frames in joints._variants(some)}
    together = {text: f for text, f in found.items() if " of every joint: " in text}
    assert {text.split()[0] for text in together} == {"position"}
    for text, frames in together.items():
        assert frames.where == ""
        assert frames.tree.origins.keys() == {0, 1}
        for k, joint in enumerate(("one", "two")):
            single = found[text.replace("every joint", f"joint {joint!r}")]
            assert (single.kind, single.where) == (frames.kind, f"joint {joint!r}")
            np.testing.assert_array_equal(single.tree.origins[k], frames.tree.origins[k])
    for factor, kind, text in slips.MILLIMETERS:
        for of, power in (("joints, centers and inertias", 2), ("joints and centers", 0)):
            scaled = found[f"every length, of {of}: {text} ({slips.say_factor(factor)})"]
            assert (scaled.kind, scaled.where) == (kind, "")
            for k, (X, J) in enumerate(
                zip(some.recursion.origins, some.recursion.moments, strict=True)
            ):
                m, c, inertia = links.parts_of(J)
                np.testing.assert_allclose(
                    scaled.tree.origins[k][:3],
                    np.c_[X[:3, :3], factor * X[:3, 3]],
                    rtol=1e-12,
                    atol=0,
                )
                expected = moments_of(m, factor * c, factor**power * inertia)
                np.testing.assert_allclose(
                    scaled.tree.moments[k],
                    expected,
                    rtol=0,
                    atol=1e-12 * float(np.abs(expected).max()),
                )


def test_other_axes_of_a_joint_are_each_tried_once() -> None:
    """Its own the other way, x, y and z both ways, and with its entries exchanged or reversed."""
    axis = np.array([0.6, 0.0, 0.8])
    first, *others = joints._axes(evidence(), 0)
    assert first.text == "axis of joint 'one': reversed"
    wanted = {tuple(sign * e) for e in np.eye(3) for sign in (1, -1)}
    wanted |= {tuple(axis[list(order)]) for order in permutations(range(3))}
    wanted |= {(-0.6, 0.0, 0.8), (0.6, 0.0, -0.8)}
    wanted -= {tuple(axis)}
    found = [(f.text, tuple((f.tree.turns[0][:3, :3] @ axis).round(9) + 0.0)) for f in others]
    assert sorted(turned for _, turned in found) == sorted(wanted)
    for text, turned in found:
        assert text == f"axis of joint 'one' along ({', '.join(f'{x:.6g}' for x in turned)})"
    np.testing.assert_allclose(first.tree.turns[0][:3, :3] @ axis, -axis, rtol=0, atol=1e-12)


@pytest.mark.parametrize("wrong", [1, 3])
def test_of_each_way_the_three_joints_that_explain_most_get_a_closer_look(
    wrong: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """One of five joints is shifted by a little along its y: no other explains it as well."""
    bodies, chain, last = [mq.Body("ground")], list[mq.Joint](), "ground"
    random = np.random.default_rng(7)
    for k in range(5):
        x, y, z, *rpy = random.uniform(0.2, 0.9, 6).tolist()
        bodies.append(mq.Body(f"b{k}", mq.box(1.0 + k, (0.3, 0.2, 0.5)).at((0.1, 0.3, -0.2))))
        place = mq.Placement((x, y, z), tuple(rpy))
        chain.append(mq.Revolute(f"j{k}", last, f"b{k}", axis=(0.6, 0, 0.8), origin=place))
        last = f"b{k}"
    ours = mq.Mechanism("chain", tuple(bodies), tuple(chain), gravity=(0, 0, -9.81))
    states = random_states(ours, 5, 0)
    some = Evidence.of(ours, states, told_by(ours)(states))
    assert some is not None
    X = some.recursion.origins[wrong].copy()
    X[1, 3] += 1e-4
    some.tau = some.change([TreeChange(origins={wrong: X})])[0]

    def residuals(trees: list[TreeChange]) -> Array:
        return np.asarray(some.weigh(some.change(trees) - some.tau))

    by_joint = [{family.way: family for family in joints._families(some, k)} for k in range(5)]
    families = [family for ways in by_joint for family in ways.values()]
    kept = joints._choose(families, residuals, some.weigh(some.base - some.tau))
    for name in by_joint[0]:
        chosen = [family for family in kept if family.way == name]
        assert len(chosen) == 3
        if len(chosen[0].starts[0]) > 1:
            continue
        # what it leaves by a small change, by differences of another size to both sides
        left = []
        for family in (joint[name] for joint in by_joint):
            rise, fall = residuals([family.change(np.array([x])) for x in (1e-5, -1e-5)])
            off, slope = some.weigh(some.base - some.tau), rise - fall
            along = slope * (slope @ off) / max(float(slope @ slope), 1e-20)
            left.append(float(np.linalg.norm(off - along)))
        by_family = dict(zip((id(joint[name]) for joint in by_joint), left, strict=True))
        least = sorted(by_family[id(family)] for family in chosen)
        np.testing.assert_allclose(least, sorted(left)[:3], rtol=1e-3, atol=1e-4 * max(left))
    shifted = by_joint[wrong]["shift y"]
    assert any(family is shifted for family in kept)
    looked = list[Any]()

    def look(_: Evidence, families: list[Any], *__: Any) -> list[Hypothesis]:
        looked.extend(families)
        return []

    monkeypatch.setattr(joints, "fit_families", look)
    assert list(joints.placement_changes(some)) == []
    assert [(f.where, f.way) for f in looked] == [(f.where, f.way) for f in kept]


@pytest.mark.parametrize("count", [1, 2])
def test_what_follows_stands_still_or_goes_the_other_way(count: int) -> None:
    """Alone, or all of them where there are several; told by the changed mechanism itself."""
    lead = mq.coordinate("lead")
    laws = dict([("first", 0.7 * lead - 0.2), ("second", -1.3 * lead)][:count])

    def arm(**changed: Any) -> mq.Mechanism:
        names = ("lead", *laws)
        place = mq.Placement((0.4, 0.1, -0.2), (0.2, -0.3, 0.6))
        links = (mq.box(2.0 - 0.3 * k, (0.3, 0.1, 0.2)).at((0.1, 0.2, 0.3)) for k in range(3))
        bodies = [mq.Body(f"of {name}", link) for name, link in zip(names, links, strict=False)]
        parents = ["ground", *(body.name for body in bodies)]
        return mq.Mechanism(
            "arm",
            (mq.Body("ground"), *bodies),
            tuple(
                mq.Revolute(name, parent, body.name, axis=(0, 0.6, 0.8), origin=place)
                for name, parent, body in zip(names, parents, bodies, strict=False)
            ),
            coordinates=mq.Coordinates(("lead",), {**laws, **changed}),
        )

    ours = arm()
    states = random_states(ours, 3, 0)

    def evidence_by(theirs: mq.Mechanism) -> Evidence:
        some = Evidence.of(ours, states, told_by(theirs)(states))
        assert some is not None
        return some

    expected = {
        **{f"'{name}' does not follow (mimic ignored)": arm(**{name: 0.0}) for name in laws},
        **{f"'{name}' follows the other way": arm(**{name: -law}) for name, law in laws.items()},
    }
    if count > 1:
        expected["no joint follows another (mimic ignored)"] = arm(**dict.fromkeys(laws, 0.0))
    some = evidence_by(ours)
    # an axis in the map is another mistake
    assert "axis sign" not in {reading.kind for reading in joints._readings(some, ["lead"])}
    changes = list(joints.map_changes(some))
    assert {change.text for change in changes} == expected.keys()
    for change in changes:
        told = evidence_by(expected[change.text]).tau
        np.testing.assert_allclose(change.answers, told, rtol=1e-11, atol=1e-11)
