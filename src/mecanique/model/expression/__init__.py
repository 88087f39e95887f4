"""Scalars: numbers, parameters and expressions in parameters, coordinates and time."""

from mecanique.model.expression.scalars import (
    DISTANCE,
    FUNCTIONS,
    POSITION,
    Scalar,
    Vector,
    compile_scalars,
    coordinate,
    distance,
    evaluate,
    finite,
    numpy_function,
    plain,
    position,
    symbols_in,
    time,
    velocity,
)

__all__ = [
    "DISTANCE",
    "FUNCTIONS",
    "POSITION",
    "Scalar",
    "Vector",
    "compile_scalars",
    "coordinate",
    "distance",
    "evaluate",
    "finite",
    "numpy_function",
    "plain",
    "position",
    "symbols_in",
    "time",
    "velocity",
]
