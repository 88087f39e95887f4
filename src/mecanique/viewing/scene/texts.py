"""The texts around a picture: derivations, verdict, parameters, freedom, the ledger."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from contextlib import suppress
from itertools import chain

import numpy as np

from mecanique.derivation import METHODS, derive
from mecanique.derivation.document import Document
from mecanique.derivation.equations import Equations
from mecanique.derivation.printing.prose import spell_greek
from mecanique.derivation.printing.writers import MathML
from mecanique.derivation.switching import (
    READABLE,
    Modes,
    derive_modes,
    list_symbols,
)
from mecanique.errors import MecaniqueError
from mecanique.figure.draw import figure_text
from mecanique.model.constraints.contacts import SPEAKING
from mecanique.model.mechanism import Mechanism
from mecanique.model.mechanism.letters import letters_of_words
from mecanique.model.mechanism_units import units
from mecanique.motion.analysis.forces import TOGETHER, Action
from mecanique.motion.linear.speeds import expand_start
from mecanique.motion.motion import Motion
from mecanique.textbook import entry
from mecanique.textbook.catalogue import is_known
from mecanique.urdf.write import write_urdf
from mecanique.verification.verdict import Verdict
from mecanique.viewing.scene.drawn import group_work
from mecanique.viewing.scene.scene import (
    DerivationStep,
    Knob,
    LedgerRow,
    SceneText,
    ShownDerivation,
    VerdictTable,
    WorkLedger,
)
from mecanique.wording import say_count, to_title

MOST_WRITTEN_OUT = 1_500
"""Terms of equations whose steps a page writes out: those of a robot with six hinges are 1.5 MB."""

MOST_LEDGER_ENTRIES = 200
"""A ledger with more entries than this is left out: nobody would read it."""


def document_of(
    motion: Motion,
    equations: Sequence[Equations],
    verdict: Verdict | None,
    actions: Sequence[Action],
    modes: Modes | None = None,
) -> SceneText:
    """Return the texts of a motion's page."""
    mechanism: Mechanism = motion.described
    refused = ""
    if mechanism.switching and modes is None:
        try:
            modes = derive_modes(mechanism, most=READABLE)
        except MecaniqueError as error:
            refused = f"They are not written out: {error}."
    symbolic = [derived.document for derived in equations if derived.symbolic]
    # the steps of other methods have reactions among their symbols, in other places of the list
    lists = sorted((derived.symbols() for derived in symbolic), key=len)
    names, about = {*mechanism.coordinates, *mechanism.values}, mechanism.about.replace("\n", " ")
    about = spell_greek(about, names, letters_of_words(mechanism))
    known = entry(mechanism.name) if is_known(mechanism.name) else None
    method = f"{motion.t[-1] - motion.t[0]:g} s by {motion.method}"
    return SceneText(
        subtitle=known.title if known else method,
        about=symbolic[0].introduction if symbolic else about,
        source=known.source if known else "",
        figure=_figure(motion),
        symbols=tuple(dict.fromkeys(chain(*lists))) or _symbols_of(mechanism, equations, modes),
        method=method,
        derivations=tuple(_derivations(mechanism, equations, modes, refused)),
        verdict=table_of(verdict) if verdict is not None else VerdictTable(),
        parameters=tuple(_parameters(mechanism)),
        initial=tuple(_initial(motion)),
        freedom=_freedom(motion),
        ledger=ledger_of(motion, actions),
        urdf=_urdf(mechanism),
        file_name=mechanism.name,
        undetermined=explain_reactions(motion),
    )


def _figure(motion: Motion) -> str:
    """The system at the start as a line figure; nothing if it cannot be drawn."""
    mechanism = motion.described
    start = dict(zip(mechanism.coordinates, motion.q[0].tolist(), strict=True))
    try:
        return figure_text(mechanism, start)
    except MecaniqueError:
        return ""


def letter(name: str, mechanism: Mechanism) -> str:
    """Return the name of a quantity as it stands in equations, in MathML."""
    return MathML(letters_of_words(mechanism)).letter(name, False, "")


def fits_page(equations: Equations) -> bool:
    """Return whether a page writes equations out with their steps, instead of listing results."""
    return equations.legible and equations.terms <= MOST_WRITTEN_OUT


def derive_all(mechanism: Mechanism) -> Iterator[Equations]:
    """Derive by each method, skipping those that do not apply: a page shows the rest."""
    shortest = derive(mechanism)
    if shortest.symbolic and not fits_page(shortest):  # the others are longer, and take minutes
        yield shortest
        return
    for method in METHODS:
        with suppress(MecaniqueError):
            yield shortest if method == shortest.method else derive(mechanism, method)


def derivation_of(equations: Equations) -> ShownDerivation:
    """Return the steps of a derivation."""
    if not fits_page(equations):
        from mecanique.generation.named_results import write_recursion

        try:
            written = write_recursion(equations)
        except MecaniqueError:
            block = DerivationStep("Equations of motion", equations.text(), final=True)
            return ShownDerivation(equations.title, (block,))
        blocks = []
        for place, (heading, said, formulas) in enumerate(written.sections()):
            for k, formula in enumerate(formulas):
                head, lead = (heading, said) if k == 0 else ("", "")
                blocks.append(DerivationStep(head, formula, final=place > 0, lead=lead))
        return ShownDerivation(equations.title, tuple(blocks), written.latex(), listed=True)
    return _write_out(equations.document, equations.latex())


def _write_out(document: Document, latex: str) -> ShownDerivation:
    """Return the steps of a document, the equations of motion last."""
    blocks = []
    for part in document.sections():
        last = part.title == "Equations of motion"
        formulas = part.formulas or ("",)
        for k, formula in enumerate(formulas):
            heading, lead = (part.title, part.explanation) if k == 0 else ("", "")
            blocks.append(DerivationStep(heading, formula, final=last, lead=lead))
    return ShownDerivation(to_title(document.title), tuple(blocks), latex)


def _derivations(
    mechanism: Mechanism, equations: Sequence[Equations], modes: Modes | None, refused: str = ""
) -> Iterator[ShownDerivation]:
    with suppress(MecaniqueError):  # of a motion that is steady for some parameters alone
        if not all(map(fits_page, equations)) and (ride := expand_start(mechanism)):
            written = ride.letters.document
            yield _write_out(written, written.latex(steps=False))
    yield from map(derivation_of, equations)
    if not mechanism.switching:
        return
    title = "Equations of motion in each mode"
    if modes is None:
        yield ShownDerivation(title, (DerivationStep("", "", refused),))
        return
    blocks = []
    for mode in modes.modes:
        heading, lead, formulas = mode.title, mode.remark, mode.write(MathML())
        for formula in formulas[:-1]:
            blocks.append(DerivationStep(heading, formula, lead=lead))
            heading = lead = ""
        # conditions stand below the last of a mode's equations
        last, held = "".join(formulas[-1:]), tuple(mode.write_conditions(MathML()))
        blocks.append(DerivationStep(heading, last, lead=lead, held=held))
    yield ShownDerivation(title, tuple(blocks))


def _symbols_of(
    mechanism: Mechanism, equations: Sequence[Equations], modes: Modes | None
) -> tuple[tuple[str, str], ...]:
    """The symbols of equations that are a list of results, by Lagrange's method if there."""
    from mecanique.generation.named_results import write_recursion

    if mechanism.switching:
        named = modes.symbols if modes is not None else list_symbols(mechanism)
        return tuple((letter(name, mechanism), meaning) for name, meaning in named)
    for equations_ in sorted(equations, key=lambda derived: derived.method != "lagrange"):
        with suppress(MecaniqueError):
            return write_recursion(equations_).symbols()
    return ()


def table_of(verdict: Verdict) -> VerdictTable:
    """Return the table of a comparison."""
    columns, *rows = verdict.table
    versions = ", ".join(f"{name} {number}" for name, number in verdict.versions.items())
    notes = (
        *verdict.remarks,
        f"Tolerance {verdict.tolerance:.0e}, seed {verdict.seed}; {versions}.",
    )
    return VerdictTable(verdict.agrees, verdict.summary, columns, tuple(rows), notes)


def _parameters(mechanism: Mechanism) -> Iterator[Knob]:
    for parameter in mechanism.parameters:
        value = parameter.value
        # a slider from nothing to three times the value keeps masses and lengths sound
        low, high = sorted((0.05 * value, 3 * value)) if value else (0.0, 0.0)
        yield _knob(parameter.symbol, value, parameter.unit, parameter.meaning, (low, high))


def _knob(name: str, value: float, unit: str, meaning: str, ends: tuple[float, float]) -> Knob:
    symbol = MathML().letter(name, False, "")
    return Knob(name, symbol, value, "" if unit == "1" else unit, meaning, *ends)


def quantities_of_inputs(mechanism: Mechanism) -> tuple[Knob, ...]:
    """Return the inputs that are constant, with the values they have."""
    quantities = []
    for signal in mechanism.inputs:
        if isinstance(signal.signal, float):
            reach = max(10.0, 2 * abs(signal.signal))
            quantities.append(
                _knob(signal.symbol, signal.signal, signal.unit, signal.meaning, (-reach, reach))
            )
    return tuple(quantities)


_START = "at the start"


def _initial(motion: Motion) -> Iterator[Knob]:
    mechanism: Mechanism = motion.mechanism
    unit = units(mechanism)
    free = [f"{name}'" in mechanism.velocities for name in mechanism.coordinates]
    for name, value, is_free in zip(mechanism.coordinates, motion.q[0], free, strict=True):
        reach = math.pi if unit[name] == "rad" else max(1.0, 2 * abs(float(value)))
        if is_free:
            ends = min(-reach, float(value)), max(reach, float(value))
            yield Knob(name, letter(name, mechanism), float(value), unit[name], _START, *ends)
    for name, value in zip(mechanism.velocities, motion.v[0], strict=True):
        reach = max(10.0, 2 * abs(float(value)))
        symbol = letter(name, mechanism)
        yield Knob(name, symbol, float(value), unit[name], _START, -reach, reach)


def _freedom(motion: Motion) -> tuple[str, ...]:
    mechanism: Mechanism = motion.mechanism
    names = ", ".join(mechanism.coordinates)
    moving = len(mechanism.bodies) - 1
    bodies = say_count(moving, "moving body", "moving bodies")
    sentences = [
        f"{bodies}, {say_count(mechanism.nv, 'degree')} of freedom in the tree; "
        f"generalized coordinates: {names or 'none'}."
    ]
    if mechanism.coordinates.driven:
        sentences.append(
            f"Joint coordinates that follow them: {', '.join(mechanism.coordinates.driven)}."
        )
    if mechanism.constrained:
        try:
            from mecanique.reference import degrees_of_freedom

            sentences.append(str(degrees_of_freedom(mechanism, motion.q[0])))
        except MecaniqueError as error:
            sentences.append(str(error))
    return tuple(sentences)


def explain_reactions(motion: Motion) -> tuple[str, ...]:
    """Return why reactions of a motion are undetermined, in sentences; none if all are known."""
    unstated = motion.mechanism.velocity_constraints
    if unstated:
        return (
            f"Undetermined reactions: velocity constraint {unstated[0].name!r} does not say by "
            f"which force it acts, and where; {SPEAKING} does.",
        )
    reasons = dict.fromkeys(motion.reference.guided.values())
    return tuple(
        f"Undetermined reactions: {reason}. What all of it does to a body is shown as one force, "
        f"{TOGETHER}."
        for reason in reasons
    )


def _urdf(mechanism: Mechanism) -> str:
    try:
        return write_urdf(mechanism)
    except MecaniqueError as error:
        return f"<!-- this mechanism cannot be written as URDF: {error} -->\n"


def ledger_of(motion: Motion, actions: Sequence[Action]) -> WorkLedger:
    """Return each force's virtual work; a force that acts on several bodies has one row."""
    mechanism: Mechanism = motion.mechanism
    unit = units(mechanism)
    groups = group_work(mechanism, actions)
    if not groups or len(groups) * mechanism.nv > MOST_LEDGER_ENTRIES:
        return WorkLedger()
    jacobians = {
        body.name: motion.reference.jacobian(body.name, motion.q, motion.t)
        for body in mechanism.bodies
        if body.name != mechanism.ground
    }
    poses = motion.poses()
    origins = {body.name: poses[:, k, :3, 3] for k, body in enumerate(mechanism.bodies)}
    rows = []
    for name, group in groups:
        work = sum(
            _virtual_work(action, jacobians[action.body], origins[action.body]) for action in group
        )
        where = " and ".join(dict.fromkeys(action.body for action in group))
        rows.append(LedgerRow(name, group[0].kind, f"of {where}", np.asarray(work)))
    largest = max(float(np.abs(row.values).max(initial=0.0)) for row in rows)
    for row in rows:
        # rounding leaves a little work even of an ideal joint's reaction
        row.values[np.abs(row.values) < 1e-12 * largest] = 0.0
    force_units = {"rad/s": "N·m", "m/s": "N"}
    generalized = tuple(force_units.get(unit[name], "") for name in mechanism.velocities)
    return WorkLedger(
        tuple(letter(name.removesuffix("'"), mechanism) for name in mechanism.velocities),
        generalized,
        tuple(rows),
    )


def _virtual_work(action: Action, jacobian: np.ndarray, origin: np.ndarray) -> np.ndarray:
    """F·δp + M·δθ for each coordinate, shape (n, nv)."""
    moment = action.moment + np.cross(action.origin - origin, action.force)
    work: np.ndarray = np.einsum("nk,nkj->nj", np.hstack([action.force, moment]), jacobian)
    return work
