"""Read formulas in plain text, LaTeX, SymPy's text or MathML, without executing them."""
