"""Compare formulas with the true quantities of a mechanism in many states."""
