"""Key frames of a scene: sampled evenly, rounded to a tolerance, differenced, packed as bytes.

Every number of a scene that changes with time is a column of one table. A column is rounded to its
step, differenced as often as it pays (a smooth motion leaves small integers), and written as
variable-length integers; constant columns and points that ride on a body are not written at all.
The page sums the integers back, which loses nothing beyond the rounding.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, final

import numpy as np
from numpy.typing import NDArray

from mecanique.arrays import spread
from mecanique.model.quaternions import conjugate, turn
from mecanique.viewing.scene.scene import Floats, Scene

FRAME_RATE = 60.0
SHORT, LEAST_FRAMES = 0.5, 241
"""A motion of at most this length [s] has so many frames, as far as there are samples."""

MOST_FRAMES = 7200
POSITION_STEP = 1e-4  # [m] for a scene of 1 m or more; the error is half a step
QUATERNION_STEP = 5e-5
ARROW_STEP = 2e-5  # of the arrow's greatest length
SERIES_STEP = 1e-6  # of the series' greatest magnitude
_MOST_ORDER = 3


@final
@dataclass(frozen=True)
class Packed:
    """Key frames ready for the page."""

    header: dict[str, Any]
    body: bytes  # the columns' integers


def pack(scene: Scene) -> Packed:
    """Pack everything that moves in a scene."""
    extent = float(np.clip(np.ptp(scene.positions, axis=(0, 1)).max(initial=0.0), 1e-6, 1.0))
    t = resample(scene.t)
    anchors = _anchors(scene, 1e-6 * extent)
    columns, steps = _table(scene, POSITION_STEP * extent)
    columns = _sample(scene, columns, t)
    kept: list[bytes] = []
    orders: list[int] = []
    start = columns[0].tolist()
    riding = {column for first, _, _ in anchors for column in range(first, first + 3)}
    for j, (column, step) in enumerate(zip(columns.T, steps, strict=True)):
        # three differences of numbers below 2**28 stay within the 32 bits JavaScript's operators
        # have
        step = steps[j] = max(step, np.abs(column).max() / 2**28, 1e-300)
        whole = np.round(column / step).astype(np.int64)
        if j in riding or not np.any(whole - whole[0]):
            orders.append(-1)
            continue
        order, rest = _cheapest(whole)
        orders.append(order)
        kept.append(varints(rest))
    header = {
        "n": len(t),
        "first": float(t[0]),
        "dt": float(t[1] - t[0]) if len(t) > 1 else 0.0,
        "orders": orders,
        "steps": steps.tolist(),
        "start": start,
        "anchors": [[first, body, *local] for first, body, local in anchors],
    }
    return Packed(header, b"".join(kept))


def resample(t: Floats) -> Floats:
    """Return the evenly spaced times a page plays."""
    if len(t) < 2:
        return t
    length = float(t[-1] - t[0])
    even = bool(np.allclose(np.diff(t), length / (len(t) - 1), rtol=1e-6, atol=0))
    least = min(len(t), LEAST_FRAMES) - 1 if length <= SHORT else 1
    rare = len(t) - 1 <= least or length / (len(t) - 1) >= 0.999 / FRAME_RATE
    if even and rare and len(t) <= MOST_FRAMES:
        return t
    count = int(min(max(round(length * FRAME_RATE), least), MOST_FRAMES - 1)) + 1
    return np.linspace(t[0], t[-1], count)


def varints(whole: NDArray[np.int64]) -> bytes:
    """Pack integers below 2**34 in magnitude: seven bits per byte, the sign in the lowest."""
    folded = ((whole << 1) ^ (whole >> 63)).astype(np.uint64)
    longest = max(1, math.ceil(int(folded.max(initial=0)).bit_length() / 7))
    rest = folded[:, None] >> np.arange(0, 7 * longest, 7, dtype=np.uint64)
    groups = (rest & np.uint64(0x7F)).astype(np.uint8)
    used = rest > 0
    groups[:, :-1] |= np.where(used[:, 1:], np.uint8(0x80), np.uint8(0))
    used[:, 0] = True
    return bytes(groups[used])


def _cheapest(whole: NDArray[np.int64]) -> tuple[int, NDArray[np.int64]]:
    """The order of differences that leaves the smallest integers, and what it leaves."""
    best, rest = 0, whole
    least, now = float(np.sum(np.log2(1.0 + np.abs(whole)))), whole
    for order in range(1, _MOST_ORDER + 1):
        now = np.diff(now, prepend=0)
        cost = float(np.sum(np.log2(1.0 + np.abs(now))))
        if cost < least:
            best, rest, least = order, now, cost
    return best, rest


def _table(scene: Scene, step: float) -> tuple[Floats, Floats]:
    """Everything that moves as columns, in the order of `Frame`, and each column's step."""
    n, nb = len(scene.t), len(scene.bodies)
    parts: list[Floats] = [
        np.concatenate([scene.positions, scene.quaternions], axis=2).reshape(n, -1)
    ]
    steps: list[float] = [*[step] * 3, *[QUATERNION_STEP] * 4] * nb
    for arrow in scene.arrows:
        parts += [arrow.origin, arrow.vector]
        steps += [step] * 3 + [ARROW_STEP * float(np.linalg.norm(arrow.vector, axis=1).max())] * 3
    points = [line.points.reshape(n, 6) for line in scene.lines] + [
        trace.points for trace in scene.traces
    ]
    parts += points
    steps += [step] * sum(array.shape[1] for array in points)
    values = [series.values[:, None] for series in scene.series] + [
        r.values for r in scene.document.ledger.rows
    ]
    parts += values
    steps += [SERIES_STEP * float(np.abs(column).max()) for array in values for column in array.T]
    return np.concatenate(parts, axis=1), np.array(steps)


def _sample(scene: Scene, columns: Floats, t: Floats) -> Floats:
    """The columns at other times, by linear interpolation."""
    if t is scene.t:
        return columns
    sampled = np.stack([np.interp(t, scene.t, column) for column in columns.T], axis=1)
    nb = len(scene.bodies)
    turned = sampled[:, : 7 * nb].reshape(len(t), nb, 7)
    turned[..., 3:] /= np.linalg.norm(turned[..., 3:], axis=2, keepdims=True)
    return sampled


def _anchors(scene: Scene, tolerance: float) -> list[tuple[int, int, list[float]]]:
    """Points that ride on a body: their first column, the body, the place in its frame."""
    # most forces and springs act at fixed points, which then follow from the body's pose
    if len(scene.t) < 3:
        return []
    first = 7 * len(scene.bodies)
    points: list[tuple[int, Floats]] = []
    for arrow in scene.arrows:
        points.append((first, arrow.origin))
        first += 6
    for line in scene.lines:
        points += [(first, line.points[:, 0]), (first + 3, line.points[:, 1])]
        first += 6
    for trace in scene.traces:
        points.append((first, trace.points))
        first += 3
    anchors = []
    few = spread(len(scene.t), 24)
    for column, point in points:
        if np.ptp(point, axis=0).max() == 0:
            continue
        for b in range(len(scene.bodies)):
            p, q = scene.positions[:, b], scene.quaternions[:, b]
            near = turn(conjugate(q[few]), point[few] - p[few])
            if np.ptp(near, axis=0).max() > tolerance:
                continue
            local = turn(conjugate(q), point - p)
            if np.ptp(local, axis=0).max() <= tolerance:
                anchors.append((column, b, local.mean(axis=0).tolist()))
                break
    return anchors
