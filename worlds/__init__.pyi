from .faces import Faces
from .loading import load
from .materials import MATERIALS, Material
from .rays import RayHits
from .rooms import names
from .solids import Solid
from .truthgrid import FREE, HIDDEN, OCCUPIED, CellState, TruthGrid, truth
from .world import Pose, World

__all__ = [
    "FREE",
    "HIDDEN",
    "MATERIALS",
    "OCCUPIED",
    "CellState",
    "Faces",
    "Material",
    "Pose",
    "RayHits",
    "Solid",
    "TruthGrid",
    "World",
    "load",
    "names",
    "truth",
]
