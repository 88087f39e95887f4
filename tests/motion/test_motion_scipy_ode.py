"""SciPy's integrators, imported alone."""

from __future__ import annotations

import sys

import numpy as np
import pytest
from scipy.integrate import ode

from mecanique.motion.simulation.integrators import methods


def swing(t: float, y: np.ndarray) -> np.ndarray:
    return np.array([y[1], -np.sin(y[0])])


def end(kind: type[ode]) -> list[float]:
    """The end of a motion by dop853."""
    solver = kind(swing).set_integrator("dop853", rtol=1e-12, atol=1e-12, beta=0.04)
    return [float(x) for x in solver.set_initial_value([2.0, 0.0], 0.0).integrate(10.0)]


def test_alone_it_gives_the_same_numbers(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delitem(sys.modules, "scipy.integrate")
    alone = methods.import_ode.__wrapped__()
    assert alone is not ode
    assert end(alone) == end(ode)


def test_what_is_imported_already_is_taken() -> None:
    assert methods.import_ode.__wrapped__() is ode


def test_where_scipy_is_built_otherwise_the_whole_is_imported(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def refuse(name: str) -> None:
        raise ImportError(name)

    monkeypatch.setattr(methods, "import_module", refuse)
    monkeypatch.setitem(sys.modules, "scipy.integrate", sys.modules["scipy.integrate"])
    monkeypatch.delitem(sys.modules, "scipy.integrate")
    assert methods.import_ode.__wrapped__().__name__ == "ode"
