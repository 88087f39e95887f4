"""Every tolerance of the reference, with its reason.

Gaps and Jacobians are in characteristic lengths and radians, unless something else is said. ε is
2⁻⁵². Steps, sweeps and lengths of steps stand where they are used: they cost time, not digits.
"""

EPSILON = 2.2e-16
"""ε, the relative rounding of a number."""

TINY = 1e-300
"""A divisor in place of zero, where the largest of some values may be zero."""

# gaps

OPEN = 1e-6
"""Gap beyond which loops are open, and the equations of motion without meaning.

Positions that are typed or read with seven digits stay below it.
"""

ASSEMBLED = 1e-9
"""Gap that an assembly may leave: a thousandth of `OPEN`, so that what it closes is closed."""

EXACT = 1e-15
"""Gap of mere rounding, 5 ε, which no step would reduce."""

ROUNDING = 1e-14
"""Rounding, 45 ε, of gaps and of entries of J where a loop closes a characteristic length away.

It grows with the way from the origin. Of bars of 1 mm, 1 km away and in any tilt, rows of rounding
reach 1 ε of that way; along chains the errors of all joints add up.
"""

TURNED = 1e-10
"""Gap halfway between the sides of a singular position from which on branches turn.

The least singular value of a turn is about the root of its gap g, and rounding of the accelerations
is enlarged by 1/σ²: by 1e-16/g. Branches cross where the gap is rounding (`ROUNDING`): a four-bar
measures 0.67 of what its bars differ by from a change point, and 9e-15 exactly at it, with a
rounding of 3e-14 to 5e-14. Between the two bounds rounding decides where the motion goes. Taken for
a crossing, a gap of 7e-13 cost 80 times the evaluations, and the motion took the wrong branch.
"""

EVIDENT = 1e-6
"""Gap that is no error of the interpolation, even between the states farthest apart."""

LANDED = 1e-11
"""Gap below which Newton's method ends where it stagnates: further sweeps change rounding only."""

# singular values of constraints

LEAST = 1e-12
"""Singular values below this are rounding: 4,500 ε, as all entries are of order one or less."""

RANK = 1e-10
"""Singular values below this part of the largest count as zero.

With J known to `ROUNDING`, four digits are left for what enlarges it in chains.
"""

RANK_ASSEMBLED = 1e-7
"""The same at assembled positions: a gap of `ASSEMBLED` makes a value of up to a hundred times it.

It does so in natural units, where short arms in long mechanisms count less than one.
"""

DEPENDENT = 1e-9
"""The same where least squares are to be bounded: of velocities, steps and forces of elements.

What is left out has an answer 1e9 times its cause, of which ε leaves seven digits.
"""

PIVOT = 1e-8
"""Pivots below this part of the largest count as zero in the choice of free coordinates.

They are those of a triangular factor, which may exceed the least singular value tenfold.
"""

INDEPENDENT_ROW = 1e-6
"""A row is independent of those before it if a larger part of it than this is new.

It is more than `RANK_ASSEMBLED`, as what is new of single rows exceeds the singular value.
"""

WEAK = 1e-4
"""Singular value, in the metric of kinetic energy, below which a position counts as singular.

Rounding of the accelerations grows with 1/σ²: to 1e-8, which integration still bears.
"""

DETERMINED = 1e-9
"""A multiplier is determined if its part in combinations that constrain nothing is below this."""

LOOSE = 1e-8
"""A component is determined if its self-stress is below this part of the largest: about √ε."""

WHOLE = 1 - 1e-9
"""A direction lies within a space if this part of its length does."""

EXPLAINED = 1e-6
"""Elements describe a guide if they leave no more than this part of its unit forces."""

BRANCH = 1e-5
"""Largest residual of J a + γ = 0 for the acceleration of a branch, relative to γ.

Next to a crossing J is known to the error of interpolation alone; off a branch it is of order one.
"""

UNBALANCED = 1e-8
"""Largest unbalanced part of driving forces, relative to their terms: about √ε."""

# masses

SINGULAR_MASS = 1e-13
"""Pivots and principal inertias below this are rounding, 450 ε, with a unit diagonal of M."""

MASSLESS = 1e-12
"""Generalized masses of free directions below this count as zero, in the metric of energy."""

EVEN = 0.03
"""Least Cholesky pivot at which M is factored directly: cancellation takes two digits or less."""

ILL_CONDITIONED = 1e6
"""The recursion is used only with a coordinate map whose condition number is below this."""

AGREEMENT = 1e-10
"""Largest relative residual of accelerations by the articulated-body recursion.

With a map at its limit of `ILL_CONDITIONED`, ε leaves 2e-10.
"""

# directions

TAKES_PART = 1e-6
"""Velocities up to this share of the largest do not take part in a motion that is named."""

PARALLEL = 1e-9
"""Axes whose angle has a smaller sine are parallel; a component of a turn below it is zero."""
