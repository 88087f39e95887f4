"""The scalars of the equations: Poisson series, elementary functions, jets, and their values."""
