"""Tolerances of the derivations: what counts as zero, and why.

Where singular values are compared with their largest, the gap was measured over the closed, rolling
and guided systems of the catalogue, 24 linkages in random tilts, offsets and sizes, and wheels,
balls and blades, six states each: what counts is 1e-5 and more, what does not 1e-16 and less, so
that a bound between is neither near the one nor the other.
"""

from __future__ import annotations

ROUNDING = 1e-14
"""A sum below this part of its terms is rounding: 45 ε. Products of poses along a linkage leave 0.6
ε at most (200 linkages in any tilt, closed by every kind of loop), a tilt's R Rᵀ 2 ε."""

MEASURED = 10_000
"""Numbers with larger denominators, or larger multiples of their common measure, are measured, not
written: they stay decimals, whose common factors say nothing."""

WHOLE = 4e-16
"""Entries of rotations this close to 0, 1 or −1 are rounded to these: 2 ε, as cos(π/2) = 6e-17."""

RANK = 1e-9
"""Singular values of constraints and of unit forces below this part of the largest count as zero.
Measured: kept 6.8e-5 and more, dropped 1.1e-16 and less."""

RANK_UNSCALED = 1e-12
"""The same for the balances of bodies, whose forces and accelerations are in no common unit.
Measured: kept 1.3e-5 and more, dropped 3e-18 and less; a light body beside a heavy one takes more
of the gap below."""

RANK_CLOSED = 1e-7
"""The same at positions found by iteration, closed to `CLOSED` only: near a singular position the
rest of a gap grows to its root. Measured: kept 2.8e-2 and more, dropped 6e-9 and less."""

INDEPENDENT = 1e-8
"""A row of constraints, or a mass matrix scaled to a unit diagonal, with a least singular value or
eigenvalue above this in some random state is independent, or definite."""

CLOSED = 1e-11
"""Constraints hold at a position found by iteration if their residual is below this part of their
units: Newton's last step squares 1e-6, rounding leaves 1e-15."""

ON_LOOPS = 1e-12
"""Residuals of loops and rates below this, in their units, are those of a state as it is given:
corrected, they would grow with every order of a jet."""

SHARE = 1e-8
"""Parts of sets of forces that balance one another below this count as zero: the square root of ε,
as singular vectors at a gap of 1e-8 are rotated by."""

LOOSE = 1e-6
"""Motions without inertia have more than this of a singular vector of unit length."""

OUTSIDE = 1e-4
"""A unit wrench with a smaller part than this outside the idle directions of a guide lies in them;
directions are told apart by angles of textbook size, not by rounding."""

EXPLAINED = 1e-6
"""Elements describe a guide if they leave no more than this part of its unit forces."""

OPPOSITE = 1e-26
"""Square of |z + n| below which the normal of a sphere counts as opposite to its plane's: unit
vectors are rounded to 1e-16, a thousandth of the root."""

DEFINITE = 1e-6
"""Least eigenvalue of a definite form, as a part of the largest second derivative."""

REGULAR = 0.3
"""Least singular value that the dependent columns of J must have, relative to J's: each Newton step
of a jet multiplies rounding by its inverse, 3 at most."""

NEAT = 1e-9
"""A coordinate of an equilibrium this close to zero or to a multiple of π/12 is replaced by it."""

BALANCED = 1e-7
"""Forces balance at an equilibrium if their sum is at most this part of the largest of them."""

SAME_EXPONENT = 1e-7
"""Parts of an exponent of small deviations below this part of the largest are zero: the square root
of ε that a double one is rounded by, five times."""

ALIGNED = 1e-12
"""Unit vectors whose cosine, or sine, is this close to 1, or 0, are parallel: axes are given to 16
digits, and turned by at most a few hundred ε along a tree."""

CLOSED_WELL = 1e-13
"""Loops of textbook size, gaps of some meters at most, are closed for comparison to 100 ε, so that
the comparison to 1e-9 is not of the gaps."""

FIRM = 1e-2
"""Random states in which the Jacobian of loops has a smaller singular value, or a coefficient a
smaller divisor, are not compared: they amplify rounding a hundredfold."""

# elements that switch

CLOSED_GAP = 1e-10
"""A gap below this many characteristic lengths is closed, where another element switches."""

EVEN = 1e-15
"""A gap is closed where it is minus this many characteristic lengths, 5 ε: bodies that only touch
part and meet by rounding."""

NO_GAP = 1e-16
"""Gaps below this many characteristic lengths, half of ε, cannot be made smaller."""

PARTED = 1e-13
"""Bodies that part are one within the other by the rounding of their gap, at most this many
characteristic lengths."""

TAIL = 1e-9
"""Bounces that stay below this many characteristic lengths are the tail of a geometric sum. Lower
ones last a time that the rounding of gaps makes uncertain, by a part of 1e-4 where they are over;
higher ones are under a force that changes."""

STILL = 1e-12
"""Speeds below this part of those around are rounding."""

DEAD = 1e-13
"""Margins of forces are passed by this part of the largest force, more than their rounding."""

LEAST_MARGIN = 1e-30
"""A margin above zero where nothing presses [N]."""

FRICTIONLESS = 1e-30
"""Part of the rate that a unit normal impulse causes, added to what friction causes: it makes the
direction of sticking zero, not 0/0, where nothing rubs, and is far below rounding elsewhere."""

SAME_PROGRAM = 1e-9
"""A program agrees with the engine's quantities to this part of the largest."""

DRIFTED = 1e-13
"""A state that is brought back onto the rows held by more than this has drifted."""

SLACK = 1e-9
"""Conditions are met if they are missed by this part of the terms that they compare."""

REDUNDANT = 1e-11
"""Singular values below this part of the largest are zero: the rows are redundant."""

SPENT = 10.0
"""Slip after static friction is spent may shrink by so many times the rounding of its growth.

Next to a contact that opens, a coefficient of 10⁶ gives the margin a slope of 10⁷ N/s, of which
the last digit of the time leaves 10⁻⁸ N.
"""

SAME_ANSWER = 1e-7
"""Answers that differ by less, of the speeds or accelerations around, are the same answer."""

TURNED = 0.8660254037844387
"""Cosine of 30°, after which slip in space that has turned is followed anew."""

SAME_WAY = 0.5
"""Cosine of 60°, within which the direction of slip in space is its own.

A step may pass the first. Slip that ends passes both at once, as it comes back from where it went.
"""

BEGUN = 1e7
"""Slip in space has begun once it is this many times faster than rounding.

Slower, its direction is that in which it grows: slip turns towards that at the rate μ g over its
speed, which is as stiff as slip is slow. What this neglects of the speed across is of second order.
"""

ANGLES = 72
"""Directions in which a root of the direction of slip in space is looked for."""

SAME_DIRECTION = 1e-13
"""Parts of directions of slip that differ by less are the same to rounding."""

DIRECTION_STEPS = 30
"""Steps of Newton's method towards the directions in which slip begins."""

SMALL_TURN = 1e-6
"""Turn of a direction for slopes by differences: half of the digits of a number are left [rad]."""

PROJECTIONS = 1000
"""Projections of friction on what presses, after which directions are near those of slip."""

SWITCHING = {
    "CLOSED_GAP": CLOSED_GAP,
    "EVEN": EVEN,
    "TAIL": TAIL,
    "STILL": STILL,
    "DEAD": DEAD,
    "LEAST_MARGIN": LEAST_MARGIN,
    "SLACK": SLACK,
    "REDUNDANT": REDUNDANT,
    "SAME_ANSWER": SAME_ANSWER,
    "TURNED": TURNED,
    "SMALL_TURN": SMALL_TURN,
    "PROJECTIONS": PROJECTIONS,
    "SAME_WAY": SAME_WAY,
    "BEGUN": BEGUN,
    "SAME_DIRECTION": SAME_DIRECTION,
    "ANGLES": ANGLES,
    "DIRECTION_STEPS": DIRECTION_STEPS,
}
"""Those that pages and code in C take, too."""
