"""Build the program of chosen quantities from equations of motion."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from mecanique.derivation.equations import Equations
from mecanique.errors import UnknownNameError
from mecanique.generation.identifiers import file_stem
from mecanique.generation.mechanics.dynamics import TapeDynamics, dynamics_of
from mecanique.generation.mechanics.free_body_forces import FreeBodyForces
from mecanique.generation.program import Answer, Program, ProgramInput
from mecanique.generation.quantities import QUANTITIES, Output, choose
from mecanique.model.mechanism import Mechanism
from mecanique.model.mechanism_units import per_second, units
from mecanique.program.tape import Value
from mecanique.program.traced import values_of


def build_program(
    equations: Equations,
    what: str | Sequence[str],
    parameters: Sequence[str] | None = None,
    name: str | None = None,
    *,
    moves: bool = False,
) -> Program:
    """Build the program that computes some quantities of a mechanism."""
    mechanism = equations.mechanism
    quantities = choose(what, mechanism)
    if moves:
        others = [quantity for quantity in quantities if quantity.name != "rhs"]
        quantities = (QUANTITIES["rhs"], *others)
    stem = file_stem(mechanism.name, name)
    dynamics = dynamics_of(equations, require_known(mechanism, parameters))
    answers = []
    for quantity in quantities:
        values = _values(dynamics, quantity.base or quantity.name)
        if quantity.by:
            values = dynamics.differentiate(values, quantity.by)
        shape = _find_shape(quantity, mechanism, len(values))
        answers.append(Answer(quantity, tuple(values), shape))
    program = assemble(dynamics, stem, answers)
    if moves and mechanism.constrained:
        return replace(program, landing=dynamics.landing)
    return program


def require_known(mechanism: Mechanism, parameters: Sequence[str] | None) -> tuple[str, ...]:
    """Return the parameters and inputs that remain arguments, all by default."""
    known = (*mechanism.values, *(signal.symbol for signal in mechanism.inputs))
    for symbol in parameters or ():
        if symbol not in known:
            raise UnknownNameError("parameter", symbol, known)
    return known if parameters is None else tuple(parameters)


def assemble(dynamics: TapeDynamics, name: str, answers: Sequence[Answer]) -> Program:
    """Assemble a program from answers on the tape of a mechanism's dynamics."""
    mechanism, tape = dynamics.letters.mechanism, dynamics.letters.tape
    return Program(
        mechanism, name, dynamics.title, tape, _collect_letters(dynamics), tuple(answers)
    )


def _values(dynamics: TapeDynamics, name: str) -> list[Value]:
    """Return the values of a quantity."""
    if name != "reactions":
        return dynamics.answer(name)
    reactions = FreeBodyForces(dynamics).joint_reactions()
    return values_of([entry for wrench in reactions for entry in (*wrench.force, *wrench.moment)])


def _collect_letters(dynamics: TapeDynamics) -> dict[str, tuple[ProgramInput, ...]]:
    """Return the inputs by kind."""
    mechanism = dynamics.letters.mechanism
    unit = units(mechanism)
    neutral = dict(zip(mechanism.coordinates, mechanism.neutral().tolist(), strict=True))
    named = {p.symbol: p for p in mechanism.parameters} | {s.symbol: s for s in mechanism.inputs}
    constants = []
    for symbol in dynamics.letters.open:
        letter = named[symbol]
        value = mechanism.values.get(symbol, getattr(letter, "signal", 0.0))
        known = float(value) if isinstance(value, float) else 0.0
        constants.append(ProgramInput(symbol, symbol, letter.unit, letter.meaning, known))
    speeds, meaning = mechanism.velocities, _describe_free_joints(mechanism)
    return {
        "t": (ProgramInput("t", "t", "s", "time"),),
        "q": tuple(
            ProgramInput(q, q, unit[q], meaning.get(q, ""), neutral[q])
            for q in mechanism.coordinates
        ),
        "v": tuple(ProgramInput(v, v, unit[v], meaning.get(v, "")) for v in speeds),
        "a": tuple(ProgramInput(f"{v}'", f"a {v}", per_second(unit[v])) for v in speeds),
        "tau": tuple(
            ProgramInput(
                f"tau_{v}", f"tau {v}", _find_force_unit(unit[v]), meaning.get(f"tau_{v}", "")
            )
            for v in speeds
        ),
        "p": tuple(constants),
    }


def _describe_free_joints(mechanism: Mechanism) -> dict[str, str]:
    """Return the axes and origins of coordinates, velocities and tau of balls and free bodies."""
    meaning: dict[str, str] = {}
    for joint in mechanism.joints:
        if not joint.quaternion:
            continue
        child = f"of {joint.child!r}"
        for name, axis in zip(joint.coordinates[-4:], "xyzw", strict=True):
            meaning[name] = f"{axis} of the unit quaternion {child} in the joint's frame"
        for kind, force, names in (
            ("velocity of the origin", "force at the origin", joint.linear_velocities),
            ("angular velocity", "moment about the origin", joint.angular_velocities),
        ):
            for name, axis in zip(names, "xyz", strict=False):
                axes = f"along the {axis} axis of the body itself"
                meaning |= {
                    name: f"{kind} {child}, {axes}",
                    f"tau_{name}": f"{force} {child}, {axes}",
                }
        for name, axis in zip(joint.coordinates[:-4], "xyz", strict=False):
            meaning[name] = f"origin {child} along the {axis} axis of the joint's frame"
    return meaning


def _find_force_unit(velocity: str) -> str:
    """Return the unit of the generalized force of a velocity."""
    return {"rad/s": "N·m", "m/s": "N"}.get(velocity, "")


def _find_shape(quantity: Output, mechanism: Mechanism, size: int) -> tuple[int, ...]:
    if quantity.by:
        rows = {"rhs": mechanism.nq + mechanism.nv, "energy": 2}.get(quantity.base, mechanism.nv)
        if quantity.base == "mass_matrix":
            return mechanism.nv, mechanism.nv, size // max(mechanism.nv**2, 1)
        if quantity.base in ("poses", "closure", "multipliers", "reactions", "jacobians"):
            return (size,)
        return rows, size // max(rows, 1)
    if quantity.name == "mass_matrix":
        return mechanism.nv, mechanism.nv
    if quantity.name == "poses":
        return size // 12, 3, 4
    if quantity.name == "jacobians":
        return size // max(6 * mechanism.nv, 1), 6, mechanism.nv
    if quantity.name == "reactions":
        return size // 6, 6
    return (size,)
