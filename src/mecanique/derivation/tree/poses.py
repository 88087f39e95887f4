"""Compute poses of all bodies in any arithmetic: floats, batched arrays, jets, Poisson series.

A pose is three rows of four scalars (the fourth row of the homogeneous matrix is always 0 0 0 1).
Entries that are the plain numbers 0 and 1 remain plain numbers and cost nothing, which keeps series
short.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from typing import Any, TypeAlias, final

import numpy as np

from mecanique.derivation.tolerances import WHOLE
from mecanique.derivation.tree.links import Axis, Link
from mecanique.model import Body, Mechanism, Placement
from mecanique.model.expression import Scalar, evaluate, numpy_function, plain


def quaternion_product(p: Sequence[Any], r: Sequence[Any]) -> list[Any]:
    """Return the product p ⊗ r, four scalars (Goldstein, Classical Mechanics, 1980, sect. 4-5)."""
    x, y, z, w = p
    a, b, c, *scalar = r
    out = [
        w * a + y * c - z * b,
        w * b + z * a - x * c,
        w * c + x * b - y * a,
        -(x * a + y * b + z * c),
    ]
    return (
        [vector_part + scalar[0] * part for vector_part, part in zip(out, p, strict=True)]
        if scalar
        else out
    )


def quaternion_rotation(x: Any, y: Any, z: Any, w: Any) -> tuple[tuple[Any, Any, Any], ...]:
    """Return the rotation matrix of a unit quaternion, three rows of three scalars."""
    return (
        (1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)),
        (2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)),
        (2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)),
    )


Matrix: TypeAlias = "list[list[Any]]"
"""Rows of scalars."""

IDENTITY: Matrix = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0]]


@final
@dataclass(frozen=True)
class Arithmetic:
    """The operations of one kind of scalar that poses need."""

    # returns the function with a sympy name, e.g. "sin"
    function: Callable[[str], Callable[..., Any]] = numpy_function
    # converts a constant (a float or a sympy number) into the scalar
    number: Callable[[Any], Any] = float

    def __call__(self, scalar: Scalar | Fraction, values: Mapping[str, Any]) -> Any:
        """Evaluate a scalar of the description; whole numbers 0, 1 and −1 stay plain."""
        if isinstance(scalar, Fraction):
            return self.number(scalar)
        scalar = plain(scalar)
        if isinstance(scalar, float) and scalar in (0.0, 1.0, -1.0):
            return int(scalar)
        return evaluate(scalar, values, function=self.function, number=self.number)

    def direction(self, axis: Axis) -> list[Any]:
        """Return the components of a unit vector, of length one exactly unless they are floats."""
        return [self(c, {}) for c in (axis if self.number is float else exact_direction(axis))]

    def sine_cosine(self, angle: Any) -> tuple[Any, Any]:
        """Return the sine and the cosine of an angle [rad]."""
        return self.function("sin")(angle), self.function("cos")(angle)


def joint_values(
    mechanism: Mechanism, values: Mapping[str, Any], arithmetic: Arithmetic
) -> dict[str, Any]:
    """Add the values of the driven joint coordinates: r = φ(q, t)."""
    driven = {
        name: arithmetic(scalar, values) for name, scalar in mechanism.coordinates.driven.items()
    }
    return {**values, **driven}


def poses(tree: Sequence[Link], values: Mapping[str, Any], arithmetic: Arithmetic) -> list[Matrix]:
    """Return the pose of every link in the world, in the order of the tree."""
    placed: list[Matrix] = []
    for link in tree:
        here = product(origin(link.origin, values, arithmetic), local(link, values, arithmetic))
        placed.append(product(placed[link.parent], here) if link.parent >= 0 else here)
    return placed


def origin(placement: Placement, values: Mapping[str, Any], arithmetic: Arithmetic) -> Matrix:
    """Return a placement as a matrix."""
    exact = None if arithmetic.number is float else exact_rotation(placement)
    pose = []
    for k, (row, offset) in enumerate(zip(placement.rotation, placement.xyz, strict=True)):
        if exact is None:
            turned = [arithmetic(entry, values) for entry in row]
        else:
            turned = [int(c) if c in (0, 1, -1) else arithmetic.number(c) for c in exact[k]]
        pose.append([*turned, arithmetic(offset, values)])
    return pose


def exact_rotation(placement: Placement) -> Matrix | None:
    """Return a tilt by any angles in fractions that are exactly orthogonal; None for others."""
    # R Rᵀ of floats is off by ε, and what should cancel in series stays as terms of rounding. With
    # t = tan(θ/2) the point ((1 − t²), 2t)/(1 + t²) lies on the unit circle exactly.
    if not all(isinstance(angle, float) for angle in placement.rpy):
        return None
    if all(_is_known(min(np.cos(angle) ** 2, np.sin(angle) ** 2)) for angle in placement.rpy):
        return None
    (cr, sr), (cp, sp), (cy, sy) = (_on_circle(float(angle)) for angle in placement.rpy)
    return [
        [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
        [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
        [-sp, cp * sr, cp * cr],
    ]


@lru_cache(maxsize=256)
def exact_direction(axis: Axis) -> Sequence[float | Fraction]:
    """Return a unit vector in fractions of length one exactly; one with known roots as it is."""
    if all(_is_known(component**2) for component in axis):
        return axis
    # a fraction's stereographic projection, here from far behind, lies on the unit sphere exactly
    front = int(np.argmax(np.abs(axis)))
    plane = [Fraction(float(c / (1 + abs(axis[front])))) for c in axis]
    plane[front] = Fraction(0)
    below = 1 + sum((c * c for c in plane), Fraction(0))
    exact = [2 * c / below for c in plane]
    exact[front] = (2 / below - 1) * (1 if axis[front] > 0 else -1)
    return exact


def _is_known(square: float) -> bool:
    """Return whether a number, by its square, is taken for zero or the root of a fraction."""
    root = float(Fraction(square).limit_denominator(1000))
    return square < WHOLE**2 or bool(abs(root - square) <= 2e-15 * square)


def _on_circle(angle: float) -> tuple[Fraction, Fraction]:
    """Return fractions for cosine and sine, whose squares add up to one exactly."""
    cosine, sine = np.cos(angle), np.sin(angle)
    if min(abs(cosine), abs(sine)) < WHOLE:
        return Fraction(round(cosine)), Fraction(round(sine))
    t = Fraction(float(np.tan(angle / 2)))
    return (1 - t * t) / (1 + t * t), 2 * t / (1 + t * t)


def placement_matrix(placement: Placement, values: Mapping[str, float]) -> np.ndarray:
    """Return a placement as a homogeneous matrix of numbers, shape (4, 4)."""
    matrix: np.ndarray = stack(origin(placement, values, Arithmetic()), 1)[0]
    return matrix


def stack(rows: Matrix, n: int) -> np.ndarray:
    """Stack a pose over n states as homogeneous matrices, shape (n, 4, 4)."""
    out = np.zeros((n, 4, 4))
    out[:, 3, 3] = 1.0
    for i, row in enumerate(rows):
        for k, entry in enumerate(row):
            out[:, i, k] = entry
    return out


def local(link: Link, values: Mapping[str, Any], arithmetic: Arithmetic) -> Matrix:
    """Return the pose of a link relative to its own frame."""
    # A turn by θ about the unit axis n is cos θ 1 + sin θ n̂ + (1 − cos θ) n nᵀ (Rodrigues 1840); a
    # quaternion's rotation matrix is that of Hamilton (Goldstein, Classical Mechanics, 1980, eq.
    # 4-47').
    if link.kind == "turn":
        return turn_by(link.axis, *arithmetic.sine_cosine(values[link.coordinates[0]]), arithmetic)
    if link.kind == "slide":
        x = values[link.coordinates[0]]
        pairs = zip(IDENTITY, arithmetic.direction(link.axis), strict=True)
        return [[*row[:3], times(c, x)] for row, c in pairs]
    if link.kind in ("ball", "free"):
        *position, x, y, z, w = (values[name] for name in link.coordinates)
        turn = quaternion_rotation(x, y, z, w)
        return [[*row, offset] for row, offset in zip(turn, position or (0, 0, 0), strict=True)]
    return [list(row) for row in IDENTITY]


def moments(body: Body, values: Mapping[str, Any], arithmetic: Arithmetic) -> Matrix:
    """Return the mass moments of a body about its origin, ∫ (p, 1)(p, 1)ᵀ dm, shape (4, 4)."""
    # Its upper left block is ½ tr(I) 1 − I + m c cᵀ, with I about the center of mass c
    total: Matrix = [[0] * 4 for _ in range(4)]
    for shape in body.shapes:
        mass = arithmetic(shape.mass, values)
        center = [arithmetic(c, values) for c in shape.center]
        ixx, iyy, izz, ixy, ixz, iyz = (arithmetic(i, values) for i in shape.inertia)
        half = arithmetic(0.5, values)
        second = [
            [half * (iyy + izz - ixx), -ixy, -ixz],
            [-ixy, half * (ixx + izz - iyy), -iyz],
            [-ixz, -iyz, half * (ixx + iyy - izz)],
        ]
        first = [times(mass, c) for c in center]
        for i in range(3):
            for k in range(3):
                moment = plus(second[i][k], times(first[i], center[k]))
                total[i][k] = plus(total[i][k], moment)
            total[i][3] = total[3][i] = plus(total[i][3], first[i])
        total[3][3] = plus(total[3][3], mass)
    return total


def product(a: Matrix, b: Matrix) -> Matrix:
    """Multiply two poses."""
    columns, rows = transpose(b), []
    for row in a:
        out = [combination(row[:3], column) for column in columns]
        out[3] = plus(out[3], row[3])
        rows.append(out)
    return rows


def transpose(rows: Sequence[Sequence[Any]]) -> Matrix:
    """Transpose a matrix of scalars."""
    return [list(column) for column in zip(*rows, strict=True)]


def times_point(pose: Matrix, point: Sequence[Any]) -> list[Any]:
    """Transform a body's point to the world, three scalars [m]; point (3,)."""
    return [plus(combination(row[:3], point), row[3]) for row in pose]


def combination(factors: Iterable[Any], terms: Iterable[Any]) -> Any:
    """Return the sum of products of two sequences; zeros and ones cost nothing."""
    # Shapes: factors (n,), terms (n,)
    total: Any = 0
    for a, b in zip(factors, terms, strict=True):
        total = plus(total, times(a, b))
    return total


def turn_by(
    axis: tuple[float, float, float], sine: Any, cosine: Any, arithmetic: Arithmetic
) -> Matrix:
    """Return a turn about a unit axis, given its sine and cosine; linear in both."""
    n = x, y, z = arithmetic.direction(axis)
    cross = ((0, -z, y), (z, 0, -x), (-y, x, 0))
    rows: Matrix = []
    for i in range(3):
        row: list[Any] = []
        for k in range(3):
            square = times(n[i], n[k])
            # cos δᵢₖ + (1 − cos) nᵢ nₖ: if n is a frame's axis this is exactly cos or 1
            if _is(square, 0):
                along = cosine if i == k else square
            elif i == k and _is(square, 1):
                along = 1
            else:
                along = times(square, 1 - cosine)
                along = plus(cosine, along) if i == k else along
            row.append(plus(along, times(cross[i][k], sine)))
        rows.append([*row, 0])
    return rows


def _is(scalar: Any, number: int) -> bool:
    return scalar.__class__ in _NUMBERS and bool(scalar == number)


_NUMBERS = frozenset({bool, int, float, np.float64})
"""Kinds of plain numbers; sums and products ask for them so often that `isinstance` would cost."""


def plus(a: Any, b: Any) -> Any:
    """Return a + b; zeros cost nothing."""
    if a.__class__ in _NUMBERS and a == 0:
        return b
    return a if b.__class__ in _NUMBERS and b == 0 else a + b


def times(a: Any, b: Any) -> Any:
    """Return a b; zeros and ones cost nothing."""
    a_is_number, b_is_number = a.__class__ in _NUMBERS, b.__class__ in _NUMBERS
    if not (a_is_number or b_is_number):
        return a * b
    if (a_is_number and a == 0) or (b_is_number and b == 0):
        return 0
    if a_is_number and a == -1:
        return -b
    if b_is_number and b == -1:
        return -a
    if a_is_number and a == 1:
        return b
    return a if b_is_number and b == 1 else a * b
