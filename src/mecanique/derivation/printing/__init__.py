"""Expressions and equations as text, LaTeX and MathML."""
