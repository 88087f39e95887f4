"""The true quantities of a mechanism at many states, and the comparison with them."""
