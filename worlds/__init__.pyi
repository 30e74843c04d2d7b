from .alignment import Alignment, align
from .doubts import Doubt, doubts
from .faces import Faces
from .generation.generator import generate, plan, style, styles
from .generation.plan import Plan
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
    "Alignment",
    "CellState",
    "Doubt",
    "Faces",
    "Material",
    "Plan",
    "Pose",
    "RayHits",
    "Solid",
    "TruthGrid",
    "World",
    "align",
    "doubts",
    "generate",
    "load",
    "names",
    "plan",
    "style",
    "styles",
    "truth",
]
