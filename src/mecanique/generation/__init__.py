"""Equations as code: one straight-line program, written in many languages, run and compared."""

from __future__ import annotations

from mecanique.generation.code import Code
from mecanique.generation.languages import generate
from mecanique.generation.writing.recursion import write_recursion

__all__ = ["Code", "generate", "write_recursion"]
