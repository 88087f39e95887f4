"""The derivations in numbers, for batches of states and mechanisms of any size."""
