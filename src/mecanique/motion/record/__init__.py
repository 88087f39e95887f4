"""A motion as it is recorded: states over time, rates, events and energies."""
