"""The laws of mechanics, each stated once, on scalars of any kind."""
