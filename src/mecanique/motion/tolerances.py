"""Every tolerance of motions and of small motions, with its reason.

ε is 2⁻⁵². Where nothing else is said, a tolerance is a part of the largest value of its kind.
Steps, numbers of samples and estimates of time stand where they are used: they cost time, not
digits.
"""

EPSILON = 2.2e-16
"""ε, the relative rounding of a number."""

TINY = 1e-300
"""A divisor in place of zero, where the largest of some values may be zero."""

INSTANT = 1e-13
"""Times are solved for to this, 450 ε [s]: what the curve through the steps can tell apart."""

BY_PROGRAM = 1e3
"""Slip in space this many times faster than rounding has a direction that a program may take from
the state, to three digits at worst; slower, the engine keeps that of the mode."""

# integration

LEAST_RTOL = 1e-14
"""The least tolerance of a step, 45 ε: below it, rounding decides which step is taken."""

GREATEST_RTOL = 0.1
"""The greatest: with a digit fewer a step says nothing."""

SCIPY_RTOL = 2.3e-14
"""The least that SciPy's classes take; they refuse less than 100 ε."""

TIGHT_RTOL = 1e-10
"""At this tolerance, the default, or a smaller one, the whole motion is to be about that accurate,
not each step alone: an orbit's phase otherwise errs by the square of the time."""

LYAPUNOV_RTOL = 1e-12
"""Of the motions that depart from each other: 1e-5 of their distance `SEPARATION`."""

INERTIAL_RTOL = 1e-12
"""Of a motion on the turning earth and of the same at rest, as their difference is small."""

AMPLITUDE_RTOL = 1e-11
"""Of the motions that linear ones are compared with: 1e-3 of `SAME_MOTION`."""

LOST = 1e-6
"""A duration below this part of the start time is lost beside it."""

SAMPLES_APART = 1e-6
"""Of the distance of samples: a last one nearer to the one before than this is left out."""

KINKS_APART = 1e-9
"""Kinks nearer to the ends than this part of the duration need no step of their own."""

NO_STEP = 1e-13
"""Part of a time below which no step is left: dop853 takes none below 10 ε of it."""

NO_SERIES_STEP = 1e-12
"""Steps of Taylor series below this part of the duration are only rounding."""

SERIES_ROUNDING = 1e-15
"""Rounding of a state of Taylor series, 5 ε."""

UNRESOLVED = 1e-6
"""Intervals below this part of the median are not halved: no step resolves the kink in them."""

OUTSIDE = 1e-12
"""Times beyond the ends by this part of them count as the ends: they come from sums of steps."""

INDEFINITE = 1e-13
"""Eigenvalues of the scaled mass matrix above minus this, 450 ε, are zero to rounding."""

# loops, limits, contacts and events along a motion

OFF_LOOPS = 1e-3
"""A state has left the loops where this part of the tolerance, or more, brings it back."""

ON_LOOPS = 1e-14
"""The same for the smallest tolerances: 45 ε, the rounding of gaps (`reference.tolerances`)."""

REPORTED = 1e-9
"""Changes of given values beyond this are reported when the constraints are met at the start:
what is typed with nine digits is taken as it is."""

AT_LIMIT = 1e-3
"""A coordinate this near to its limit has reached it, relative to the limits' distance or 1.

A motion may touch the limit and turn back, as the abscissa of a point on a circle does.
"""

BEYOND_LIMIT = 1e-9
"""A joint's limit that is passed by less [rad or m] is only touched."""

IDLE = 1e-12
"""A row of constraints or contacts, in natural units, that no motion changes by more, is idle."""

NOT_LEFT = 1e-6
"""A quantity below this part of what it comes to, a look later, may be zero to rounding still."""

SHORTEST_FLIGHT = 1e-9
"""Impacts closer together than this part of the duration are a lasting contact."""

UNYIELDING = 1e-14
"""An impulse that changes an event's quantity by this part of its terms, or less, cannot change it:
the sum of its terms is rounding."""

SLACK_CORD = 1e-9
"""A cord that would have to push by this part of its largest tension is slack."""

# the motion against the reference

SUMS = 1e-12
"""Sums over the bodies that differ by this part of the largest are the same.

Over the catalogue, at 24 random states each, energies differ by at most 1e-15.
"""

ACCELERATIONS = 1e-9
"""The same of accelerations, which the inverse of the mass matrix enlarges."""

BALANCED = 1e-13
"""Relative residuals of balances below `GROWTH` times this are never held against a motion."""

UNCHANGED = 1e-14
"""What changes a momentum or an energy by this part of it in the whole motion is rounding, 45 ε."""

NO_MOMENTUM = 1e-9
"""A momentum below this part of the largest counts as zero: what cancels leaves such a rest."""

NO_STATE = 1e-12
"""Sizes of states are at least this, and a thousandth of the largest; errors are parts of them."""

SEPARATION = 1e-7
"""Distance of the neighbor whose departure gives the Lyapunov exponent, relative to the state:
about √ε, so that it is small beside the state and large beside rounding."""

ANOTHER = 1e-6
"""A file whose accelerations differ from the mechanism's by more holds another's motion: it
changes by as much with a parameter in its sixth digit."""

FLAT_CURVE = 1e-12
"""A curve below this part of the others is rounding, and is drawn as zero."""

# equilibria

SLOPE_STEP = 1e-6
"""Step of the central differences in Newton's search [rad or m], near ε^(1/3)."""

NEWTON_STEP = 1e-14
"""Newton's steps below this end the search in a tree: they change rounding only."""

NEWTON_STEP_ON_LOOPS = 1e-12
"""The same on loops, which are closed to no less than `ON_LOOPS` after each step."""

AT_REST = 1e-10
"""Forces that remain at an equilibrium, of those that hold the mechanism or that a unit of a
coordinate causes."""

NO_FORCE = 1e-14
"""Forces below this are zero where no force is there to compare with [N or N·m]."""

AT_REST_ON_LOOPS = 1e-9
"""The same on loops, row by row."""

FLAT_SLOPE = 1e-10
"""Singular values of the slope of the forces below this part are zero: no step is taken there."""

SAME_PLACE = 1e-6
"""Positions closer than this are one equilibrium."""

IN_LINE = 1e-10
"""Where the least inertia is this part of its usual one, or less, two coordinates fall in line."""

TURN = 1e-9
"""Angles are brought to −π…π, where π itself may be missed by this."""

SAME_FORCES = 1e-8
"""Forces that change by less with a whole turn do not depend on it, as those of a spring do."""

UNRESISTED = 1e-9
"""Directions with stiffnesses below this part are free: equilibria along them are one family."""

FLAT_HELD = 1e-8
"""Slopes of forces below this part of the loads that contacts bear there, over a unit of the
coordinate, are rounding: differences over `SLOPE_STEP` leave 1e-10."""

SMALL_ACCELERATION = 1e-9
"""Accelerations of this part of those that other changes cause are rounding."""

# linear motions

DIFFERENCES = 1e-11
"""Relative error of differences that is good enough; below it K counts as symmetric."""

UNDAMPED = 1e-10
"""C and the skew part of K below this part of their scale are zero: ten times `DIFFERENCES`."""

NO_SQUARE = 1e-14
"""ω² below this part of the largest is rounding, 45 ε: along it nothing pulls back."""

OSCILLATES = 1e-9
"""Imaginary parts of exponents below this part of the largest exponent count as zero."""

STABLE = 1e-7
"""Real parts of exponents up to this part of the largest exponent count as zero.

A double exponent is known to the root of the error of the matrix, √1e-14.
"""

ACCELERATES = 1e-8
"""Accelerations below this are those of an equilibrium, where a position errs by 1e-11."""

NO_DAMPING = 1e-14
"""Damping ratios up to this are not printed."""

ALIKE = 1e-9
"""Components of a mode, moments of inertia and coefficients that differ by this part are equal."""

NO_COMPONENT = 1e-12
"""Components of a mode below this set no limit to its amplitude."""

SAME_MOTION = 1e-8
"""Differences between linear and exact motions below this are the integrator's."""

KINKED = 1e-6
"""Where linear and exact motions still differ with this part of the first amplitude, the forces
have a kink."""

SAME_AMPLITUDE = 1e-8
"""An amplitude has the difference asked for to this part of it."""

SAME_SPEED = 1e-10
"""Critical speeds are solved for to this [1], as far as exponents are known."""

FITS = 1e-8
"""Polynomials in the speed may miss the matrices by this part of the largest entry."""

AGREES = 1e-10
"""A polynomial through matrices A may miss another by this part of its largest entry."""

# steady motions

CONSTANT = 1e-9
"""Rates below this part of the square of the angular velocity count as zero."""

LEAST_SPIN = 1e-12
"""Angular velocities below this count as rest [rad/s]."""

SMALLEST_ANGLE = 1e-3
"""Hinges about axes that enclose a smaller angle than this do not describe an attitude [rad]."""

NO_ENTRY = 1e-8
"""Entries of the matrix A of a steady motion below this part of the largest count as zero."""

STEADY = 1e-6
"""Rates and accelerations of a steady motion may be this large [1/s, 1/s²]."""
