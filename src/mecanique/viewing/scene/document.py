"""The texts that go with a scene: equations, verdict, parameters, the ledger of virtual work."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import final

import numpy as np
from numpy.typing import NDArray


@final
@dataclass(frozen=True)
class Block:
    """A step of a derivation.

    Args:
        heading: plain text; may be empty.
        body: MathML, or plain text.
        note: a sentence below it; may be empty.
        final: whether it is the final result.
        lead: a sentence above it; may be empty.
    """

    heading: str
    body: str
    note: str = ""
    final: bool = False
    lead: str = ""


@final
@dataclass(frozen=True)
class Derivation:
    """The derivation of the equations of motion by one method.

    Args:
        method: e.g. "Lagrange".
        blocks: its steps, in order.
        latex: the equations of motion in LaTeX, to be copied; empty if there are none.
        listed: whether they are a list of named results, because a closed form is too long.
    """

    method: str
    blocks: tuple[Block, ...]
    latex: str = ""
    listed: bool = False


@final
@dataclass(frozen=True)
class VerdictTable:
    """The outcome of comparing the derivation with the reference.

    Args:
        agrees: whether all quantities agree; None if nothing was compared.
        headline: one sentence.
        columns: the heads of the table.
        rows: its cells, as text.
        notes: sentences below it: likely causes, versions, the seed.
        own: what the program of the page itself differs by: quantities and numbers.
        own_note: how it was compared.
    """

    agrees: bool | None = None
    headline: str = ""
    columns: tuple[str, ...] = ()
    rows: tuple[tuple[str, ...], ...] = ()
    notes: tuple[str, ...] = ()
    own: tuple[tuple[str, str], ...] = ()
    own_note: str = ""


@final
@dataclass(frozen=True)
class Quantity:
    """A parameter, or an initial value.

    Args:
        name: unique among its kind.
        symbol: MathML or plain text.
        value: in units of `unit`.
        unit: empty if it has none.
        meaning: a few words.
        low: least value a live view offers; equal to `high` if it cannot be changed.
        high: greatest value.
    """

    name: str
    symbol: str
    value: float
    unit: str = ""
    meaning: str = ""
    low: float = 0.0
    high: float = 0.0


@final
@dataclass(frozen=True, eq=False)
class LedgerRow:
    """A force's virtual work, coordinate by coordinate, over time.

    Args:
        name: the force.
        kind: as in `Arrow.kind`.
        displacement: the virtual displacement it works along: MathML or plain text.
        values: shape (n, nc), its contribution to the generalized force of each coordinate.
    """

    name: str
    kind: str
    displacement: str
    values: NDArray[np.float64]


@final
@dataclass(frozen=True, eq=False)
class Ledger:
    """The principle of virtual work, row by row; each column sums to zero.

    Args:
        coordinates: nc symbols, MathML or plain text.
        units: nc units of the generalized forces.
        rows: the forces, d'Alembert's included.
    """

    coordinates: tuple[str, ...] = ()
    units: tuple[str, ...] = ()
    rows: tuple[LedgerRow, ...] = ()


@final
@dataclass(frozen=True, eq=False)
class Document:
    """The texts of a page.

    Args:
        subtitle: one line below the title: what the system is.
        about: what the system is, in sentences; empty if nothing is known.
        source: author, work, page; empty if there is none.
        figure: the system as a line figure, SVG text; empty if there is none.
        symbols: each symbol of the equations, MathML, and what it means.
        derivations: method by method.
        verdict: what the comparison found.
        parameters: with their values and units.
        initial: initial values, with sliders in a live view.
        freedom: sentences on the count of degrees of freedom.
        ledger: the virtual work of each force.
        urdf: the mechanism as URDF text.
        file_name: stem of the files that can be saved from the page.
        undetermined: sentences on the forces that are not determined, and why.
        method: how the motion was computed.
        recorded: why the page shows a recorded motion and cannot compute another; empty if it can.
    """

    subtitle: str = ""
    about: str = ""
    source: str = ""
    figure: str = ""
    symbols: tuple[tuple[str, str], ...] = ()
    derivations: tuple[Derivation, ...] = ()
    verdict: VerdictTable = field(default_factory=VerdictTable)
    parameters: tuple[Quantity, ...] = ()
    initial: tuple[Quantity, ...] = ()
    freedom: tuple[str, ...] = ()
    ledger: Ledger = field(default_factory=Ledger)
    urdf: str = ""
    file_name: str = "mechanism"
    undetermined: tuple[str, ...] = ()
    method: str = ""
    recorded: str = ""
