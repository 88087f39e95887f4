"""How far rounding alone may drive two sound sources apart."""
