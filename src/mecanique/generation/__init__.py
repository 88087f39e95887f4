"""Equations as code: one straight-line program, written in many languages, run and compared."""

from __future__ import annotations

from mecanique.generation.code import Code
from mecanique.generation.languages import generate

__all__ = ["Code", "generate"]
