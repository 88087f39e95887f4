"""Print expressions and equations as text, LaTeX and MathML."""
