"""Equations as code: one straight-line program, written in many languages, run and compared."""
