"""Mechanisms as URDF text."""

from mecanique.urdf.read import read_urdf
from mecanique.urdf.write import write_urdf

__all__ = ["read_urdf", "write_urdf"]
