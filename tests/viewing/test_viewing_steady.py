"""The page of what is too long in closed form shows its equations about a steady motion."""

from __future__ import annotations

import pytest

import mecanique as mq
from mecanique.viewing.page.panels import write_equations
from mecanique.viewing.scene import texts
from mecanique.viewing.scene.scene import SceneText, ShownDerivation


def test_the_bicycle_has_its_linear_equations_above_the_exact_ones(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """M q'' + v C1 q' + (g K0 + v² K2) q = 0, as the document has them (Meijaard et al., 2007)."""
    monkeypatch.setattr(texts, "derivation_of", lambda _: ShownDerivation("exact", ()))
    bicycle = mq.textbook.load("whipple_bicycle")
    shown = [*texts._derivations(bicycle, [mq.derive(bicycle)], None)]
    assert [derivation.method for derivation in shown] == [
        "Small deviations from a steady motion",
        "exact",
    ]
    assert not shown[0].listed
    assert "M_{11} \\ddot{\\phi}" in shown[0].latex
    assert "v C_{1,12} \\dot{\\delta}" in shown[0].latex
    page = write_equations(SceneText(derivations=tuple(shown)))
    assert "would be too long" not in page
    assert page.index("Equations of motion") < page.index("Small deviations")
