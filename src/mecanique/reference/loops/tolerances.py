"""Tolerances of loops; gaps in characteristic lengths or radians, Jacobians scaled alike."""

__all__ = [
    "ASSEMBLED",
    "DEPENDENT",
    "DETERMINED",
    "EPSILON",
    "EXACT",
    "INDEPENDENT_ROW",
    "LEAST",
    "LOOSE",
    "MASSLESS",
    "OPEN",
    "PIVOT",
    "RANK",
    "RANK_ASSEMBLED",
    "ROUNDING",
    "TINY",
    "WEAK",
]

OPEN = 1e-6
"""Gap beyond which loops are open: the equations of motion mean nothing there."""

ASSEMBLED = 1e-9
"""Gap that an assembly may leave."""

EXACT = 1e-15
"""Gap that no step would reduce: rounding alone."""

ROUNDING = 1e-14
"""Gap that rounding leaves of closed loops, one characteristic length from the origin."""

EPSILON = 2.2e-16
"""Relative rounding of a number."""

LEAST = 1e-12
"""Singular values of the constraints below this are rounding."""

RANK = 1e-10
"""Singular values below this part of the largest count as zero."""

RANK_ASSEMBLED = 1e-7
"""The same at assembled positions, which are closed to rounding only."""

DEPENDENT = 1e-9
"""The same where dependent velocities, or a position next to the loops, follow by least squares."""

WEAK = 1e-4
"""Singular value, in the metric of kinetic energy, below which a position counts as singular."""

PIVOT = 1e-8
"""Pivots below this part of the largest count as zero where free coordinates are chosen."""

INDEPENDENT_ROW = 1e-6
"""Part of a row that must be new for it to count as independent of those before it."""

DETERMINED = 1e-9
"""Part of a combination that constrains nothing below which a row counts as determined."""

LOOSE = 1e-8
"""Part of the largest self-stress below which a component is determined."""

MASSLESS = 1e-12
"""Generalized masses below this part of the largest count as zero."""

TINY = 1e-300
"""Divides safely where the largest of some values may be zero."""
