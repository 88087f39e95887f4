"""One module per textbook system; each states its problem in the docstring and gives a `SYSTEM`."""
