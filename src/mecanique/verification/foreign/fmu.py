"""Models of the FMI standard, for model exchange, run by FMPy. Loading one runs its code."""

from __future__ import annotations

import ctypes
import os
import shutil
from collections.abc import Sequence
from importlib.util import find_spec
from typing import Any

import numpy as np

from mecanique.arrays import Array
from mecanique.errors import InputError
from mecanique.model.mechanism import Mechanism
from mecanique.model.states import States
from mecanique.verification.foreign.child import ask_in_child

_ENERGIES = ("kinetic energy", "potential energy")


def ask_fmu(path: str | os.PathLike[str], mechanism: Mechanism, states: States) -> dict[str, Array]:
    """Return what a model gives at states, by quantity: accelerations, and energies if it has any.

    Its states are known by their names: those of the coordinates and velocities, or der(θ) for the
    velocity of θ. Its parameters and inputs are as it starts.
    """
    if find_spec("fmpy") is None:
        raise InputError("expected fmpy, which is not installed: pip install 'mecanique[fmpy]'")
    given = (path, mechanism, states)
    values: dict[str, Array] = ask_in_child(os.fspath(path), _run_file, *given)
    return values


def _run_file(
    path: str | os.PathLike[str], mechanism: Mechanism, states: States
) -> dict[str, Array]:
    import fmpy

    try:
        described = fmpy.read_model_description(os.fspath(path))
    except Exception as error:
        # FMPy raises whatever the file's fault leads to
        raise InputError(f"expected an FMU, but {path} cannot be read: {error}") from None
    if described.modelExchange is None or described.fmiVersion[:1] not in "23":
        raise InputError(
            f"expected an FMU for model exchange by FMI 2 or 3, got FMI {described.fmiVersion}"
            f"{'' if described.modelExchange else ' without model exchange'} in {path}"
        )
    folder = fmpy.extract(os.fspath(path))
    try:
        return _run(_Model(described, folder), described, mechanism, states)
    except (fmpy.fmi1.FMICallException, OSError) as error:
        raise InputError(f"the FMU {path} fails: {error}") from None
    finally:
        shutil.rmtree(folder, ignore_errors=True)


class _Model:
    """An instance of FMI 2 or 3."""

    def __init__(self, described: Any, folder: str) -> None:
        from fmpy.fmi2 import FMU2Model
        from fmpy.fmi3 import FMU3Model

        self._second = described.fmiVersion.startswith("2")
        kind = FMU2Model if self._second else FMU3Model
        self.said: list[str] = []
        self.fmu = kind(
            guid=described.guid,
            unzipDirectory=folder,
            modelIdentifier=described.modelExchange.modelIdentifier,
            instanceName="verify",
        )
        if self._second:
            self.fmu.instantiate()
            self.fmu.setupExperiment()
        else:
            self.fmu.instantiate(logMessage=lambda *said: self.said.append(str(said[-1])))
        self.fmu.enterInitializationMode()
        self.fmu.exitInitializationMode()
        if self._second:
            self.fmu.newDiscreteStates()
        else:
            self.fmu.updateDiscreteStates()
        self.fmu.enterContinuousTimeMode()

    def put(self, t: float, state: Sequence[float]) -> None:
        """Set the state."""
        self.fmu.setTime(t)
        numbers = (ctypes.c_double * len(state))(*state)
        self.fmu.setContinuousStates(numbers, len(state))

    def rates(self, size: int) -> Array:
        """Return the rates of its states."""
        numbers = (ctypes.c_double * size)()
        read = self.fmu.getDerivatives if self._second else self.fmu.getContinuousStateDerivatives
        read(numbers, size)
        return np.array(numbers)

    def read(self, references: Sequence[int]) -> list[float]:
        """Return variables."""
        get = self.fmu.getReal if self._second else self.fmu.getFloat64
        return list(get(references))


def _run(model: _Model, described: Any, mechanism: Mechanism, states: States) -> dict[str, Array]:
    names = [
        described_variable.variable.derivative.name for described_variable in described.derivatives
    ]
    order = _order(names, mechanism)
    variables = {variable.name: variable for variable in described.modelVariables}
    energies = [variables.get(name.replace(" ", "_")) for name in _ENERGIES]
    references = [
        described_variable.valueReference
        for described_variable in energies
        if described_variable is not None
    ]
    accelerations, energies_read = [], []
    for t, q, v in zip(states.t.tolist(), states.q, states.v, strict=True):
        model.put(t, np.concatenate([q, v])[order].tolist())
        rates = np.empty(len(order))
        rates[order] = model.rates(len(order))
        accelerations.append(rates[mechanism.nq :])
        if len(references) == len(_ENERGIES):
            energies_read.append(model.read(references))
    model.fmu.terminate()
    model.fmu.freeInstance()
    values: dict[str, Array] = {"acceleration": np.array(accelerations)}
    if energies_read:
        values |= zip(_ENERGIES, np.array(energies_read).T, strict=True)
    return values


def _order(names: Sequence[str], mechanism: Mechanism) -> list[int]:
    """Where each state of a model stands among the coordinates and velocities."""
    ours = [*mechanism.coordinates, *mechanism.velocities]
    places = {name: k for k, name in enumerate(ours)}
    for name in mechanism.velocities:
        if name.endswith("'"):
            places.setdefault(f"der({name[:-1]})", places[name])
    other = [name for name in names if name not in places]
    missing = [name for k, name in enumerate(ours) if k not in map(places.get, names)]
    if other or missing or len(names) != len(ours):
        raise InputError(
            f"expected the states {', '.join(ours)} in the FMU, got {', '.join(names) or 'none'}; "
            f"it lacks {', '.join(missing) or 'none'}, and {', '.join(other) or 'none'} are unknown"
        )
    return [places[name] for name in names]
