"""Derivations in numbers, batched over states, for mechanisms of any size."""
