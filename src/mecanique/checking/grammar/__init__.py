"""Formulas as people write them: plain text, LaTeX, SymPy's text and MathML; never executed."""
