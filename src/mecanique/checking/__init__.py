"""Judge submitted formulas: whether an equation is right, and if not, why not."""
