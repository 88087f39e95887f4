"""Write the URDF of every textbook system into this folder: `python urdf/regenerate.py`."""

from pathlib import Path

from mecanique.textbook import load, names
from mecanique.urdf.write import write_urdf

if __name__ == "__main__":
    here = Path(__file__).parent
    everyone = (*names(), *names(corners=True))
    for name in everyone:
        write_urdf(load(name), here / f"{name}.urdf")
    for path in here.glob("*.urdf"):
        if path.stem not in everyone:
            path.unlink()
