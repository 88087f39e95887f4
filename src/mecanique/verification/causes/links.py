"""Mistakes in the mass, the center of mass and the inertia of a link."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import permutations
from typing import final

import numpy as np

from mecanique.arrays import Array
from mecanique.model import slips
from mecanique.model.bodies.tensor import moments_of
from mecanique.model.slips import Slip, say_factor
from mecanique.model.states import States
from mecanique.verification.causes.evidence import (
    Amount,
    Evidence,
    Family,
    Hypothesis,
    TreeChange,
    fit_families,
    give,
    give_all,
    say_turn,
    turn_about,
)


def parts_of(J: Array) -> tuple[float, Array, Array]:
    """Return mass, center of mass and inertia about it."""
    m = float(J[3, 3])
    c = J[:3, 3] / m if m else np.zeros(3)
    second = J[:3, :3] - m * np.outer(c, c)
    return m, c, np.trace(second) * np.eye(3) - second


_UPPER = np.triu_indices(4)
_POINT = np.diag([0.0, 0.0, 0.0, 1.0])
"""Mass moments of a unit mass at the origin."""

_HEAVIEST = 100
"""Masses that many times too large are no likely mistake, except those of units."""

_CLOSER = 8
"""Links whose numbers are fitted."""

_TURNS = 6
"""Random turns to begin with besides none."""


@final
@dataclass(frozen=True, eq=False)
class LinkEffect:
    """The effect of a link's mass moments in all experiments, reduced to ten rows."""

    columns: Array  # what each mass moment adds, shape (n, nv, 10)
    R: Array  # triangle of the weighted columns' QR factors
    y: Array  # the weighted differences along these columns
    rest: float  # norm of what they leave

    @classmethod
    def of(cls, evidence: Evidence, Y: Array) -> LinkEffect:
        """Return it of a link's regressor, shape (n, nv, 4, 4)."""
        both = Y + np.swapaxes(Y, -1, -2)
        both[..., range(4), range(4)] /= 2
        columns = both[..., _UPPER[0], _UPPER[1]]
        flat = evidence.weigh(np.moveaxis(columns, -1, 0)).T
        off = evidence.weigh(evidence.tau - evidence.base)
        Q, R = np.linalg.qr(flat)
        y = Q.T @ off
        return cls(columns, R, y, float(np.linalg.norm(off - Q @ y)))

    @property
    def any_change(self) -> tuple[Array, float]:
        """The change of the mass moments that leaves least, shape (10,), and what it leaves."""
        solution = np.asarray(np.linalg.lstsq(self.R, self.y, rcond=1e-12)[0], dtype=np.float64)
        left = float(np.linalg.norm(self.R @ solution - self.y))
        return solution, float(np.hypot(self.rest, left))

    def reduce(self, moments: Sequence[Array], J: Array) -> Array:
        """Return what changes of the mass moments J leave, without `rest`, shape (changes, 10)."""
        rows: Array = np.array([changed[_UPPER] - J[_UPPER] for changed in moments]) @ self.R.T
        return rows - self.y

    def answer(self, evidence: Evidence, moments: Sequence[Array], J: Array) -> Array:
        """Return what the other source would say of changes of J, shape (changes, n, nv)."""
        changes = np.array([changed[_UPPER] - J[_UPPER] for changed in moments])
        predicted: Array = evidence.base + np.einsum("nvc,kc->knv", self.columns, changes)
        return predicted


def fit_inertias(evidence: Evidence) -> Iterator[Hypothesis]:
    """Yield the changes of a link with numbers that fit, of the links that explain most."""
    recursion = evidence.recursion
    if not evidence.inputs.inertia.any():
        return
    fits = []
    for k, link in enumerate(recursion.tree):
        J = recursion.moments[k]
        if link.body is not None and J.any():
            effect = LinkEffect.of(evidence, evidence.regressor[:, :, k])
            solution, least = effect.any_change
            if least < evidence.before:
                fits.append((least, k, effect))
                where = f"link {link.body!r}"
                text = f"mass, center or inertia of {where} differ, in no way known as a mistake"
                change = np.zeros((4, 4))
                change[_UPPER] = solution
                fitted = J + change + np.triu(change, 1).T
                yield Hypothesis(
                    "other inertia",
                    where,
                    text,
                    effect.answer(evidence, [fitted], J)[0],
                    len(solution),
                    tree=TreeChange(moments={k: fitted}),
                    slopes=np.moveaxis(effect.columns, -1, 0),
                )
    for _, k, effect in sorted(fits, key=lambda fit: fit[0])[:_CLOSER]:
        yield from _fit(evidence, effect, k)


def _fit(evidence: Evidence, effect: LinkEffect, k: int) -> Iterator[Hypothesis]:
    """The changes of a link at some place in the tree, with numbers that fit."""
    link, J = evidence.recursion.tree[k], evidence.recursion.moments[k]
    m, c, inertia = parts_of(J)
    if m <= 0:
        return
    physical = _is_physical(m, c, inertia)
    families = list(_families(_Link(k, f"link {link.body!r}", J), effect, root=link.parent < 0))
    for change in fit_families(
        evidence,
        families,
        lambda trees: effect.reduce([tree.moments[k] for tree in trees], J),
        lambda trees: effect.answer(evidence, [tree.moments[k] for tree in trees], J),
    ):
        fitted = parts_of(change.tree.moments[k])
        if fitted[0] <= _HEAVIEST * m and (_is_physical(*fitted) or not physical):
            yield change


def principal_turn(effect: LinkEffect, J: Array) -> Array:
    """Return the turn of the principal axes to those of the inertia that fits best, shape (3,)."""
    m, c, inertia = parts_of(J)
    units = [_symmetric(unit) for unit in np.eye(6)]
    columns = [effect.R @ (moments_of(m, c, inertia + E) - J)[_UPPER] for E in units]
    change = np.linalg.lstsq(np.array(columns).T, effect.y, rcond=1e-9)[0]
    axes, fitted_axes = (np.linalg.eigh(I)[1] for I in (inertia, inertia + _symmetric(change)))
    R = fitted_axes @ axes.T
    from scipy.spatial.transform import Rotation  # not wanted before a cause is looked for

    # signs of axes mean nothing: what mirrors turns the other way
    turned: Array = Rotation.from_matrix(np.linalg.det(R) * R).as_rotvec()
    return turned


@final
class _Link:
    """A link with what it weighs, and the families of its changes."""

    def __init__(self, k: int, where: str, J: Array) -> None:
        self.where, self.J = where, J
        self.m, self.c, self.inertia = parts_of(J)
        self._k = k

    def family(
        self,
        kind: str,
        make: Callable[[Array], tuple[float, Array, Array]],
        say: Callable[[Array, Array], str],
        amount: Callable[[Array], Amount],
        *starts: Array,
    ) -> Family:
        """Return the family that gives mass, center and inertia about it by some numbers."""

        def change(x: Array) -> TreeChange:
            return TreeChange(moments={self._k: moments_of(*make(x))})

        return Family(kind, self.where, change, say, amount, starts or (np.zeros(1),))


def _families(link: _Link, effect: LinkEffect, *, root: bool) -> Iterator[Family]:
    mass = "root mass" if root else "link mass"
    where = link.where
    m, c, inertia, J = link.m, link.c, link.inertia, link.J

    def heavier(numbers: int) -> Callable[[Array], Amount]:
        return lambda x: Amount.of(m * (1 + x[0]), m, ways=numbers)

    yield link.family(
        mass,
        lambda x: (m * (1 + x[0]), c, inertia),
        lambda x, s: f"mass of {where}: {give(m * (1 + x[0]), m * s[0])} kg instead of {m:.6g} kg",
        heavier(1),
    )
    yield link.family(
        mass,
        lambda x: (m * (1 + x[0]), c, inertia * (1 + x[0])),
        lambda x, s: (
            f"mass and inertia of {where} times {give(1 + x[0], s[0])} "
            f"(mass {give(m * (1 + x[0]), m * s[0])} kg)"
        ),
        heavier(7),
    )
    if c.any():
        yield link.family(
            mass,
            lambda x: parts_of(J + m * x[0] * _POINT),
            lambda x, s: (
                f"a point mass of {give(m * abs(x[0]), m * s[0])} kg "
                f"{'more' if x[0] > 0 else 'less'} at the origin of {where} (mass {m:.6g} kg)"
            ),
            heavier(10),
        )
    size = float(np.sqrt(max(np.trace(inertia), 1e-12 * m) / m))
    for axis, name in zip(np.eye(3), "xyz", strict=True):
        yield _move_along(link, size, axis, name)
    yield link.family(
        "center of mass",
        lambda x: (m, c + size * x, inertia),
        lambda x, s: f"center of mass of {where} moved by ({give_all(size * x)}) m",
        lambda x: Amount.of_all(size * x, float(np.linalg.norm(c))),
        np.zeros(3),
    )
    if inertia.any():
        yield from _inertias(link, principal_turn(effect, J))


def _move_along(link: _Link, size: float, axis: Array, name: str) -> Family:
    def amount(x: Array) -> Amount:
        old = float(link.c @ axis)
        return Amount.of(old + size * x[0], old, float(np.linalg.norm(link.c)), ways=3)

    return link.family(
        "center of mass",
        lambda x: (link.m, link.c + x[0] * size * axis, link.inertia),
        lambda x, s: (
            f"center of mass of {link.where} moved by {give(size * x[0], size * s[0])} m along "
            f"{name}"
        ),
        amount,
    )


def _inertias(link: _Link, turned: Array) -> Iterator[Family]:
    m, c, inertia, where = link.m, link.c, link.inertia, link.where
    size = float(np.trace(inertia)) / 3
    upper = np.triu_indices(3)
    yield link.family(
        "inertia",
        lambda x: (m, c, inertia * (1 + x[0])),
        lambda x, s: f"inertia of {where} times {give(1 + x[0], s[0])}",
        lambda x: Amount.of(1 + x[0], 1.0, ways=6),
    )
    for i, k in zip(*upper, strict=True):
        yield _change_entry(link, size, (int(i), int(k)))
    rng = np.random.default_rng(0)
    yield link.family(
        "inertia turn",
        lambda x: (m, c, turn_about(x) @ inertia @ turn_about(x).T),
        lambda x, s: f"inertia of {where} turned by {say_turn(x)}",
        lambda x: Amount.of_all(np.degrees(x), 180.0),
        *(np.zeros(3), turned, *rng.uniform(-2, 2, size=(_TURNS, 3))),
    )
    yield link.family(
        "inertia",
        lambda x: (m, c, inertia + size * _symmetric(x)),
        lambda x, s: (
            f"inertia of {where} about its center of mass: ixx, ixy, ixz, iyy, iyz, izz = "
            f"{give_all((inertia + size * _symmetric(x))[upper])} kg·m²"
        ),
        lambda x: Amount.of_all(inertia[upper] + size * x, size),
        np.zeros(6),
    )


def _change_entry(link: _Link, size: float, at: tuple[int, int]) -> Family:
    i, k = at
    E = np.zeros((3, 3))
    E[i, k] = E[k, i] = size
    name = f"i{'xyz'[i]}{'xyz'[k]}"
    entry = link.inertia[i, k]
    return link.family(
        "inertia",
        lambda x: (link.m, link.c, link.inertia + x[0] * E),
        lambda x, s: (
            f"{name} of {link.where}: {give(entry + size * x[0], size * s[0])} kg·m² "
            f"instead of {entry:.6g} kg·m²"
        ),
        lambda x: Amount.of(entry + size * x[0], entry, ways=6),
    )


def _is_physical(m: float, c: Array, inertia: Array) -> bool:
    """Whether a body may have mass [kg], center [m] and inertia [kg·m²]: none is negative."""
    if not (m >= 0 and np.isfinite(c).all() and np.isfinite(inertia).all()):
        return False
    moments = np.linalg.eigvalsh(inertia)
    return bool(moments.min() >= -1e-9 * np.abs(moments).max())


def _symmetric(x: Array) -> Array:
    triangle = np.zeros((3, 3))
    triangle[np.triu_indices(3)] = x
    upper: Array = triangle + np.triu(triangle, 1).T
    return upper


def link_changes(evidence: Evidence) -> Iterator[Hypothesis]:
    """Wrong points, axes, signs and units of inertias, wrong masses, of one link and of all."""
    Y, recursion = evidence.regressor, evidence.recursion
    if not evidence.inputs.inertia.any():
        return
    neutral = States.of(evidence.mechanism, None)
    standing = [pose[0] for pose in recursion.poses(neutral)]
    of_all: dict[tuple[str, str], Array] = {}
    places = [
        k
        for k, link in enumerate(recursion.tree)
        if link.body is not None and recursion.moments[k].any()
    ]
    for k in places:
        link, J = recursion.tree[k], recursion.moments[k]
        where, root = f"link {link.body!r}", link.parent < 0
        for what, slip in _variants(J, standing[k], recursion.origins[k][:3, :3], root=root):
            effect = np.einsum("nvab,ab->nv", Y[:, :, k], slip.value - J)
            answers, text = evidence.base + effect, f"{what} of {where}: {slip.text}"
            tree = TreeChange(moments={k: slip.value})
            yield Hypothesis(slip.kind, where, text, answers, tree=tree)
            key = slip.kind, f"{what} of every link: {slip.text}"
            of_all[key] = of_all.get(key, 0.0) + effect
    if len(places) > 1:
        for (kind, text), effect in of_all.items():
            if kind not in ("link mass", "root mass"):
                yield Hypothesis(kind, "", text, evidence.base + effect)


def _variants(J: Array, pose: Array, frame: Array, *, root: bool) -> Iterator[tuple[str, Slip]]:
    """Yield each way to get a link's mass moments wrong: what is wrong, and the moments."""
    m, c, inertia = parts_of(J)
    mass, both, center, tensor = "mass", "mass and inertia", "center of mass", "inertia"
    yield both, Slip("root mass" if root else "link mass", slips.LEFT_OUT, np.zeros((4, 4)))
    yield both, Slip("root mass" if root else "link mass", slips.TWICE, 2 * J)
    for factor, kind, text in slips.GRAMS:
        text = f"{text} ({say_factor(factor)})"
        yield mass, Slip(kind, text, moments_of(factor * m, c, inertia))
        yield both, Slip(kind, text, factor * J)
    for factor, kind, text in slips.MILLIMETERS if c.any() else ():
        text = f"{text} ({say_factor(factor)})"
        yield center, Slip(kind, text, moments_of(m, factor * c, inertia))
        squared = moments_of(m, factor * c, factor**2 * inertia)
        yield f"{center} and, squared, inertia", Slip(kind, text, squared)
    units = [
        Slip(unit.kind, f"{unit.text} ({say_factor(unit.factor)})", unit.factor * inertia)
        for unit in slips.INERTIA
        if inertia.any()
    ]
    # a unit of both mass and length is rarer than one of them, and stands last
    tensors = [*units[:4], *slips.mistake_point(m, c, inertia)]
    for slip in tensors:
        yield tensor, slip._replace(value=moments_of(m, c, slip.value))
    if c.any():
        yield center, Slip("center of mass", slips.LEFT_OUT, moments_of(m, np.zeros(3), inertia))
        for slip in slips.mistake_vector("center of mass", c):
            yield center, slip._replace(value=moments_of(m, slip.value, inertia))
    turn, away = pose[:3, :3], pose[:3, :3] @ c + pose[:3, 3]
    far = slips.lever_of(m, turn.T @ away)
    tensors = []
    lever = slips.lever_of(m, c)
    if far.any() and not np.allclose(far, lever, rtol=0, atol=1e-12 * np.abs(lever).max()):
        about, moved = "about the world's origin", "moved from the world's origin, in vain"
        tensors = [
            Slip("wrong point", about, inertia + far),
            Slip("wrong point", moved, inertia - far),
        ]
    tensors += [*slips.mistake_products(inertia), *_rotate_axes(inertia, turn, frame), *units[4:]]
    for slip in tensors:
        yield tensor, slip._replace(value=moments_of(m, c, slip.value))


def _rotate_axes(inertia: Array, turn: Array, frame: Array) -> Iterator[Slip]:
    """Yield the inertia given in other axes than the link's."""
    turns = [("in the world's axes", turn), ("in the parent's axes", frame)]
    tensors = [(said, R.T @ inertia @ R) for said, R in turns]
    tensors += [(f"{said}, turned the wrong way", R @ inertia @ R.T) for said, R in turns]
    tensors += [(slip.text, slip.value) for slip in slips.mistake_axes(inertia)]
    principal, axes = np.linalg.eigh(inertia)
    size = np.abs(inertia).max()
    if np.abs(inertia - np.diag(np.diag(inertia))).max() > 1e-12 * size:
        tensors.append(("in its axes of figure", axes.T @ inertia @ axes))
        for order in permutations(range(3)):
            tensors.append(("in its axes of figure", np.diag(principal[list(order)])))
    yield from slips.list_once("wrong axes", tensors, inertia, 1e-12 * max(size, 1e-300))
