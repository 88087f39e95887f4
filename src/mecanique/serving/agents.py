"""The server that agents talk to, by the Model Context Protocol over standard input and output."""

from __future__ import annotations

import functools
import inspect
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, Literal

from mecanique.checking.check import check as check_formula
from mecanique.derivation import derive as derive_equations
from mecanique.errors import InputError, MecaniqueError, UnknownNameError
from mecanique.model.mechanism_units import units
from mecanique.motion import equilibria as find_equilibria
from mecanique.motion import linearize as linearize_motion
from mecanique.motion import simulate as simulate_motion
from mecanique.teaching import make_exercise
from mecanique.teaching.marks import RULE, Submission, grade_submissions, make_sheet
from mecanique.textbook.catalogue import entry, load, names
from mecanique.urdf import read_urdf
from mecanique.urdf.lint import lint
from mecanique.verification import verify

if TYPE_CHECKING:
    from mcp.server import MCPServer


_LONGEST_URDF = 500_000
_MOST_BODIES = 60
_LONGEST_MOTION = 60.0
_MOST_INSTANTS = 500
_MOST_SAMPLES = 100
_MOST_RESTING = 12
_MOST_ANSWERS = 200
_MOST_SECONDS = 20.0
_WIDEST = 60_000
"""Longest text that is answered, in characters."""


def list_systems(tag: str = "") -> dict[str, str]:
    """List the textbook systems: the title of each, by its name.

    Args:
        tag: only systems with this tag, e.g. "pendulum"; all by default.
    """
    known = sorted({word for name in names() for word in entry(name).tags})
    if tag and tag not in known:
        raise UnknownNameError("tag", tag, known)
    return {name: entry(name).title for name in names() if not tag or tag in entry(name).tags}


def describe(system: str) -> dict[str, Any]:
    """Describe a textbook system: its statement, coordinates, parameters and known facts.

    Args:
        system: its name, one of those that list_systems gives.
    """
    card = entry(system)
    mechanism = card.mechanism()
    return {
        "name": system,
        "title": card.title,
        "statement": entry(system).statement.partition("\n")[2].strip(),
        "source": card.source,
        "coordinates": {name: units(mechanism)[name] for name in mechanism.coordinates},
        "velocities": list(mechanism.velocities),
        "parameters": [
            {"symbol": p.symbol, "value": p.value, "unit": p.unit, "meaning": p.meaning}
            for p in card.parameters
        ],
        "inputs": [signal.symbol for signal in mechanism.inputs],
        "facts": [fact.statement for fact in card.facts],
    }


def derive(
    system: str,
    method: str = "lagrange",
    form: Literal["text", "latex"] = "text",
    steps: bool = False,
    parameters: dict[str, float] | None = None,
) -> str:
    """Derive the equations of motion of a textbook system.

    Args:
        system: its name.
        method: of derivation: lagrange, newton_euler or virtual_work.
        form: text or LaTeX.
        steps: whether to show how they came about.
        parameters: values that differ from the catalogue's, in SI units; of a chain its number n
            of links.
    """
    equations = derive_equations(load(system, **(parameters or {})), method)
    text = equations.latex(steps) if form == "latex" else equations.text(steps)
    if len(text) > _WIDEST:
        raise InputError(f"the equations have {len(text):,} characters; ask without steps")
    return text


def equilibria(
    system: str, parameters: dict[str, float] | None = None, seed: int = 0
) -> list[dict[str, Any]]:
    """Find the positions in which a textbook system can rest, the lowest first.

    Args:
        system: its name.
        parameters: values that differ from the catalogue's, in SI units.
        seed: of the random positions from which they are looked for.
    """
    mechanism = load(system, **(parameters or {}))
    _refuse_above("bodies", len(mechanism.bodies), 1, _MOST_RESTING)
    return [
        {
            "q": dict(zip(mechanism.coordinates, equilibrium.q.tolist(), strict=True)),
            "stable": equilibrium.stable,
            "family": list(equilibrium.family),
            "states": dict(equilibrium.states),
            "frequencies": equilibrium.linearization.frequencies.tolist(),
        }
        for equilibrium in find_equilibria(mechanism, seed=seed)
    ]


def linearize(
    system: str,
    at: dict[str, float] | None = None,
    parameters: dict[str, float] | None = None,
) -> dict[str, Any]:
    """Linearize a textbook system: M x'' + C x' + K x = 0 about an equilibrium or a position.

    Args:
        system: its name.
        at: coordinates, in rad or m; by default a stable equilibrium, which is looked for.
        parameters: values that differ from the catalogue's, in SI units.
    """
    mechanism = load(system, **(parameters or {}))
    linearization = linearize_motion(mechanism, at)
    eigenvalues = linearization.eigenvalues
    return {
        "q": dict(zip(mechanism.coordinates, linearization.q.tolist(), strict=True)),
        "M": linearization.M.tolist(),
        "C": linearization.C.tolist(),
        "K": linearization.K.tolist(),
        "frequencies": linearization.frequencies.tolist(),
        "eigenvalues": [[x.real, x.imag] for x in eigenvalues.tolist()],
        "stable": linearization.stable,
        "note": linearization.chosen,
    }


def grade(
    questions: list[dict[str, Any]], answers: dict[str, dict[str, str]], step: float = 0.0
) -> dict[str, Any]:
    """Grade the answers of several students to several questions, with reasons.

    Args:
        questions: each with id and system, and if need be ask, points, form (part of the points
            for an answer that is right except for form), let and parameters.
        answers: texts by student, then by the question's id.
        step: to which points are rounded, e.g. 0.25.
    """
    _refuse_above("answers", len(questions) * len(answers), 1, _MOST_ANSWERS)
    sheet = make_sheet({"question": questions, "step": step}, "questions")
    stop = _stop_after(_MOST_SECONDS, "grading", "send fewer answers")
    submissions = [Submission(student, texts) for student, texts in answers.items()]
    grades = grade_submissions(sheet, submissions, progress=stop)
    return {
        "totals": grades.totals,
        "of": sheet.points,
        "marks": [
            {"student": m.student, "question": m.question, "points": m.points}
            | {"outcome": m.outcome, "reason": m.reason}
            for m in grades.marks
        ],
        "rule": RULE,
    }


def check(
    system: str,
    formula: str,
    ask: str = "equation of motion",
    let: list[str] | None = None,
    parameters: dict[str, float] | None = None,
    seed: int = 0,
) -> dict[str, Any]:
    """Check whether a formula is right, and if not, say what is wrong with it.

    Args:
        system: name of a textbook system.
        formula: equations in plain text or LaTeX, one per line; they are never executed.
        ask: what it is meant to be: equation of motion, kinetic energy, potential energy,
            Lagrangian, energy, mass matrix, momentum of q, conserved quantity, frequency (also
            "frequency at q = pi", "frequency at steady motion"), damped frequency, period, period
            from rest (released at q0), equilibrium, equilibrium of BODY (cut free, in its
            reactions), equilibrium force, steady motion, reaction, state space, Hamiltonian,
            Hamilton's equations or transfer function of x from F.
        let: definitions of further letters, e.g. ["J = m l^2/3"].
        parameters: values that differ from the catalogue's, in SI units.
        seed: of the random states.
    """
    mechanism = load(system, **(parameters or {}))
    whole = check_formula(mechanism, formula, ask, let or (), seed, parameters or ()).to_dict()
    # what is empty says nothing
    return {name: value for name, value in whole.items() if value not in (None, [], {})}


def exercise(system: str, ask: str = "equation of motion", seed: int = 0) -> dict[str, str]:
    """Make an exercise about a textbook system, with its answer and verified solution.

    Args:
        system: its name.
        ask: equation of motion, kinetic energy, potential energy, Lagrangian, energy, conserved
            quantity, mass matrix, momentum, Hamiltonian, Hamilton's equations, state space,
            equilibrium, equilibrium force, frequency, period, period from rest, undamped
            frequency, damped frequency or transfer function.
        seed: of the variant; the same seed gives the same numbers.
    """
    made = make_exercise(system, ask, seed)
    return {"problem": made.problem, "answer": made.answer, "solution": made.solution}


def verify_urdf(urdf: str, samples: int = 20) -> dict[str, Any]:
    """Lint a URDF text, and compare its derived equations of motion with Pinocchio's.

    Args:
        urdf: the whole text; paths are not read.
        samples: number of random states, at most 100.
    """
    if not urdf.lstrip().startswith("<"):
        raise InputError("expected the text of a URDF file, which begins with <")
    if len(urdf) > _LONGEST_URDF:
        raise InputError(f"expected at most {_LONGEST_URDF:,} characters, got {len(urdf):,}")
    _refuse_above("samples", samples, 1, _MOST_SAMPLES)
    findings = [
        {"code": finding.code, "severity": finding.severity, "text": str(finding)}
        for finding in lint(urdf)
    ]
    if any(finding["code"].startswith("M0") for finding in findings):
        return {"findings": findings, "verdict": None}
    mechanism = read_urdf(urdf)
    if len(mechanism.bodies) > _MOST_BODIES:
        raise InputError(f"expected at most {_MOST_BODIES} bodies, got {len(mechanism.bodies)}")
    stop = _stop_after(_MOST_SECONDS, "the comparison", "ask for fewer samples")
    verdict = verify(mechanism, samples, progress=lambda _, done: stop(done))
    return {"findings": findings, "verdict": verdict.to_dict()}


def simulate(
    system: str,
    q: dict[str, float] | None = None,
    v: dict[str, float] | None = None,
    parameters: dict[str, float] | None = None,
    duration: float = 10.0,
    instants: int = 101,
) -> dict[str, Any]:
    """Simulate a textbook system; returns times, coordinates and velocities by name.

    Args:
        system: its name.
        q: coordinates at the start, in rad or m; the catalogue's start by default.
        v: velocities at the start, by coordinate; zero by default.
        parameters: values that differ from the catalogue's, in SI units.
        duration: at most 60 [s].
        instants: number of times returned, at most 500.
    """
    if not 0 < duration <= _LONGEST_MOTION:
        raise InputError(f"expected a duration up to {_LONGEST_MOTION:g} s, got {duration!r}")
    _refuse_above("instants", instants, 2, _MOST_INSTANTS)
    card = entry(system)
    mechanism = load(system, **(parameters or {}))
    start = card.start if q is None else q
    velocities = v
    if q is None and v is None:
        velocities = {n.removesuffix("'"): value for n, value in card.start_velocity.items()}
    motion = simulate_motion(
        mechanism,
        q=start,
        v=velocities,
        duration=duration,
        samples=instants,
        progress=_stop_after(_MOST_SECONDS, "the motion", "shorten it"),
    )
    return {
        "t": motion.t.tolist(),
        "q": {name: motion.q[:, k].tolist() for k, name in enumerate(mechanism.coordinates)},
        "v": {name: motion.v[:, k].tolist() for k, name in enumerate(mechanism.velocities)},
    }


def _refuse_above(name: str, value: int, least: int, most: int) -> None:
    if not least <= value <= most:
        raise InputError(f"expected {name} from {least} to {most}, got {value}")


def _stop_after(seconds: float, what: str, remedy: str) -> Callable[[float], None]:
    """Return a progress that stops work which takes too long."""
    end = time.monotonic() + seconds

    def stop(_: float) -> None:
        if time.monotonic() > end:
            raise InputError(f"{what} takes more than {seconds:g} s to compute; {remedy}")

    return stop


TOOLS: tuple[Callable[..., Any], ...] = (
    list_systems,
    describe,
    derive,
    equilibria,
    linearize,
    check,
    grade,
    exercise,
    verify_urdf,
    simulate,
)
"""The tools of the server, each a function with its schema in its signature."""


_INSTRUCTIONS = (
    "Analytical mechanics: textbook systems, their equations of motion derived and checked. "
    "Formulas are plain text or LaTeX in the letters that `describe` gives; derivatives are q' "
    "and q''. Call `check` before you hand out an equation of motion."
)


def make_server() -> MCPServer:
    """Return the server with its tools."""
    try:
        from mcp.server import MCPServer
    except ImportError:
        raise InputError(
            "the server for agents needs the package mcp; install mecanique[mcp]"
        ) from None
    from mcp.types import ToolAnnotations

    # no tool changes anything, and each gives the same answer again
    kind = ToolAnnotations(read_only_hint=True, idempotent_hint=True, open_world_hint=False)
    server = MCPServer("mecanique", instructions=_INSTRUCTIONS, log_level="ERROR")
    with _refuse_other_arguments():
        for tool in TOOLS:
            text = inspect.getdoc(tool) or ""
            server.tool(description=text, annotations=kind)(_say_errors(tool))
    return server


@contextmanager
def _refuse_other_arguments() -> Iterator[None]:
    """Let tools refuse arguments that they do not have; the protocol's package drops them."""
    from mcp.server.mcpserver.utilities.func_metadata import ArgModelBase

    # the models of arguments take over what their base says when they are made
    settings = ArgModelBase.model_config
    before = settings.get("extra")
    settings["extra"] = "forbid"
    try:
        yield
    finally:
        settings["extra"] = before


def serve() -> None:
    """Serve over standard input and output until the client leaves."""
    make_server().run("stdio")


def _say_errors(tool: Callable[..., Any]) -> Callable[..., Any]:
    """Return a tool whose errors are phrased in the client's terms: what is wrong, what to do."""
    from mcp.server.mcpserver.exceptions import ToolError

    @functools.wraps(tool)
    def call(*args: Any, **kwargs: Any) -> Any:
        try:
            return tool(*args, **kwargs)
        except MecaniqueError as error:
            raise ToolError(str(error)) from None

    return call
