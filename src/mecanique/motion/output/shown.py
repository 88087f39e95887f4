"""Figures of matplotlib that a notebook shows; imported where matplotlib is needed alone."""

from __future__ import annotations

from io import BytesIO
from typing import final

from matplotlib.figure import Figure


@final
class ShownFigure(Figure):
    """A figure that notebooks show where it is the result of a cell, without pyplot."""

    def _repr_png_(self) -> bytes:
        drawn = BytesIO()
        self.savefig(drawn, format="png")
        return drawn.getvalue()
