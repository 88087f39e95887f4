"""Derive and verify a mechanism while it is already shown."""

from __future__ import annotations

import threading
from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from typing import final

from mecanique.derivation import derive, readable
from mecanique.errors import MecaniqueError
from mecanique.model.mechanism import Mechanism
from mecanique.verification import verify
from mecanique.viewing.scene.scene import Derivation, SceneText, VerdictTable
from mecanique.viewing.scene.texts import derivation_of, fits_page, table_of

MOST_DERIVED = 8
"""Above this number of velocities the equations are compared, but not written out."""

Found = Callable[[tuple[Derivation, ...], VerdictTable], None]

Proof = Callable[[VerdictTable], VerdictTable]

WAITING = VerdictTable(headline="checking …")


def pending(mechanism: Mechanism, document: SceneText) -> SceneText:
    """Return a document that says that equations and verdict are on their way."""
    waiting = Derivation("Being derived …", ())
    derivations = (waiting,) if mechanism.nv <= MOST_DERIVED else ()
    return replace(document, derivations=derivations, verdict=WAITING)


@final
class Checking:
    """Derives a mechanism's equations and compares them, in a thread of its own."""

    def __init__(
        self, mechanism: Mechanism, found: Found, prove: Proof = lambda table: table
    ) -> None:
        self._mechanism = mechanism
        self._found = found
        self._prove = prove
        self._lock = threading.Lock()
        self._cancelled = False
        self._thread = threading.Thread(target=self._run, name="mecanique check", daemon=True)
        self._thread.start()

    def cancel(self) -> None:
        """Report nothing more; the computation ends at its next step."""
        with self._lock:
            self._cancelled = True

    def finish(self, seconds: float) -> None:
        """Cancel, and wait for the thread."""
        self.cancel()
        self._thread.join(seconds)

    def _run(self) -> None:
        derivations: tuple[Derivation, ...] = ()
        try:
            written_out = self._mechanism.nv <= MOST_DERIVED
            for method in readable(self._mechanism) if written_out else ():
                if self._cancelled:
                    return
                with suppress(MecaniqueError):
                    equations = derive(self._mechanism, method)
                    derivations += (derivation_of(equations),)
                    if not fits_page(equations):
                        break  # the other methods cannot be written out either
            if derivations:
                self._tell(derivations, WAITING)
            if not self._cancelled:
                verdict = table_of(verify(self._mechanism))
                self._tell(derivations, verdict)
                if verdict.agrees and not self._cancelled:
                    self._tell(derivations, self._prove(verdict))
        except Exception as error:  # a page must not wait forever: it says why there is no verdict
            kind = "" if isinstance(error, MecaniqueError) else f"{type(error).__name__}: "
            self._tell(derivations, VerdictTable(headline=f"not checked: {kind}{error}"))

    def _tell(self, derivations: tuple[Derivation, ...], verdict: VerdictTable) -> None:
        # under the lock, so that nothing arrives once `cancel` has returned
        with self._lock:
            if not self._cancelled:
                self._found(derivations, verdict)
