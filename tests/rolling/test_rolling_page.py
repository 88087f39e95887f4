"""The page of a motion that a velocity constraint holds shows no force that is not known."""

from __future__ import annotations

from pathlib import Path

from rolling_samples import sleigh

from mecanique import export, simulate


def test_reactions_are_undetermined_and_said_to_be(tmp_path: Path) -> None:
    mechanism = sleigh(by_element=False)
    motion = simulate(mechanism, v={"x": 1.0, "theta": 1.0}, duration=0.5)
    page = export(motion, tmp_path / "page.html").read_text(encoding="utf-8")
    assert "does not say by which force it acts" in page
