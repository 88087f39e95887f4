"""The numbers of equations: Poisson series, elementary functions, jets, and their values."""
