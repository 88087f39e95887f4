"""The names of this room and where they live; `mecanique.lazy` reads this."""

from mecanique.urdf.read import read_urdf as read_urdf
from mecanique.urdf.write import write_urdf as write_urdf
