"""The steps of the methods in words and formulas, in the order of a textbook."""
