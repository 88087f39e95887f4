"""The numbers equations are made of: Poisson series, elementary functions, jets, and how they are evaluated."""
