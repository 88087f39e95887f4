"""What a live view shows of a mechanism across restarts, changes and new forces."""

from __future__ import annotations

from dataclasses import replace
from typing import final

from mecanique.model.mechanism import Mechanism
from mecanique.viewing.live.checking import Checking
from mecanique.viewing.live.live import LiveView
from mecanique.viewing.live.stretches import fit, names_of
from mecanique.viewing.scene.scene import Scene


@final
class Presenter:
    """Keep open pages up to date across restarts; derive in the background.

    Args:
        mechanism: what moves at first.
        complete: its complete scene.
    """

    def __init__(self, mechanism: Mechanism, complete: Scene) -> None:
        self._mechanism = mechanism
        self._names = names_of(complete)
        self._parameters = _values(mechanism)
        self._checking: Checking | None = None
        self.first = fit(complete, self._names)

    def check(self, live: LiveView) -> None:
        """Derive and compare what moves, unless this has already begun.

        Args:
            live: the view that shows what is found.
        """
        if self._checking is None:
            self._checking = Checking(self._mechanism, live.annotate)

    def begin(self, live: LiveView, mechanism: Mechanism, complete: Scene) -> Scene:
        """Return the start of a motion as the view shows it.

        Args:
            live: the view.
            mechanism: what moves, with the parameters as they are now.
            complete: the complete scene of the start.
        """
        parameters = _values(mechanism)
        if parameters != self._parameters:
            self._mechanism, self._parameters, self._names = (
                mechanism,
                parameters,
                names_of(complete),
            )
            if self._checking:
                self._checking.cancel()
            self._checking = None
            shown = fit(complete, self._names)
            live.show(shown)
        else:
            shown = self.go_on(live, complete)
        self.check(live)
        return shown

    def go_on(self, live: LiveView, complete: Scene) -> Scene:
        """Return a later stretch as the view shows it.

        Args:
            live: the view.
            complete: the complete scene of the stretch.
        """
        names = self._names | names_of(complete)
        shown = fit(complete, names)
        if names != self._names:
            # a force that acts for the first time is not yet part of the scene
            self._names, before = names, live.scene
            document = replace(before.document, ledger=shown.document.ledger)
            planar = shown.planar and before.planar
            live.show(
                replace(shown, document=document, bounds=before.bounds, planar=planar), keep=True
            )
        return shown

    def close(self) -> None:
        """Cancel the derivation in progress."""
        if self._checking:
            self._checking.finish(2.0)


def _values(mechanism: Mechanism) -> dict[str, float]:
    return {parameter.symbol: parameter.value for parameter in mechanism.parameters}
