"""Scalars: numbers, parameters and expressions in parameters, coordinates and time."""

from mecanique.model.expression.scalars import (
    FUNCTIONS,
    Scalar,
    Vector,
    accept_arrays,
    compile_scalars,
    coordinate,
    evaluate,
    finite,
    numpy_function,
    plain,
    symbols_in,
    time,
    velocity,
)

__all__ = [
    "FUNCTIONS",
    "Scalar",
    "Vector",
    "accept_arrays",
    "compile_scalars",
    "coordinate",
    "evaluate",
    "finite",
    "numpy_function",
    "plain",
    "symbols_in",
    "time",
    "velocity",
]
