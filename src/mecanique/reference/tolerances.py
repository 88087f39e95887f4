"""Tolerances of loops: gaps in characteristic lengths or radians, Jacobians in the same units."""

OPEN = 1e-6
"""Gap beyond which loops are open, and the equations of motion without meaning."""

ASSEMBLED = 1e-9
"""Gap that an assembly may leave."""

EXACT = 1e-15
"""Gap of mere rounding, which no step would reduce."""

ROUNDING = 1e-14
"""Gap that rounding leaves in closed loops, one characteristic length from the origin."""

EPSILON = 2.2e-16
"""Relative rounding of a number."""

LEAST = 1e-12
"""Singular values of the constraints below this are rounding."""

RANK = 1e-10
"""Singular values below this part of the largest count as zero."""

RANK_ASSEMBLED = 1e-7
"""The same at assembled positions, which are closed only up to rounding."""

DEPENDENT = 1e-9
"""The same where least squares give dependent velocities, or a closed position nearby."""

WEAK = 1e-4
"""Singular value, in the metric of kinetic energy, below which a position counts as singular."""

PIVOT = 1e-8
"""Pivots below this part of the largest count as zero in the choice of free coordinates."""

INDEPENDENT_ROW = 1e-6
"""A row is independent of those before it if a larger part of it than this is new."""

DETERMINED = 1e-9
"""A multiplier is determined if its part in combinations that constrain nothing is below this."""

LOOSE = 1e-8
"""A component is determined if its self-stress is below this part of the largest."""

MASSLESS = 1e-12
"""Generalized masses below this part of the largest count as zero."""

TINY = 1e-300
"""A divisor in place of zero, where the largest of some values may be zero."""
