"""The catalogue of textbook systems, one short file each.

Example:
    >>> mq.textbook.names()[:2]
    ('acrobot', 'atwood_machine')
    >>> print(mq.textbook.entry("crane").source)
    Sakawa & Shindo, Automatica 18 (1982) 257; Abdel-Rahman, Nayfeh & Masoud, J. Vib.
    Control 9 (2003) 863
    >>> mq.textbook.load("crane", m=2.0).values["m"]
    2.0
"""

from mecanique.textbook.catalogue import entry, load, names
from mecanique.textbook.system import System

__all__ = ["System", "entry", "load", "names"]
