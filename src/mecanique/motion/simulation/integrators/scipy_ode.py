"""Import SciPy's compiled integrators without the rest of `scipy.integrate`."""

from __future__ import annotations

import sys
from functools import cache
from importlib import import_module
from importlib.util import find_spec
from types import ModuleType
from typing import Any


@cache
def import_ode() -> Any:
    """Return SciPy's class `ode`.

    `scipy.integrate` imports sparse matrices, optimization and special functions for its other
    half: 0.3 s of processor time, a third of a first motion. The module that `ode` stands in needs
    none of them, and is imported alone unless the whole is there already; where another version of
    SciPy is built otherwise, the whole is imported.
    """
    if "scipy.integrate" not in sys.modules:
        spec = find_spec("scipy.integrate")
        assert spec is not None, "SciPy is required"
        # a package of the same folder, which imports nothing by itself
        package = ModuleType("_scipy_ode_alone")
        package.__path__ = list(spec.submodule_search_locations or ())
        sys.modules[package.__name__] = package
        try:
            return import_module("_scipy_ode_alone._ode").ode
        except (ImportError, AttributeError):
            pass  # the same from where everybody takes it
    from scipy.integrate import ode

    return ode
