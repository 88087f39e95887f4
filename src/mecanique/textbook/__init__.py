"""The catalogue of textbook systems, one short file each."""

from mecanique.textbook.catalogue import entry, load, names
from mecanique.textbook.system import System

__all__ = ["System", "entry", "load", "names"]
