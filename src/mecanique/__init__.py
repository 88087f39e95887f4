"""Equations of motion: derived independently, checked against an engine, then set in motion."""

from typing import Any

from mecanique import viewing  # noqa: F401 lets motions show themselves; imports no numpy
from mecanique.lazy import attach


def _explain(member: Any) -> Any:
    from mecanique.doors import explain

    return explain(member, __name__)


__getattr__, __dir__, __all__ = attach(__name__, __file__, _explain)
