"""Case files: TOML to and from frozen, validated models; the only place that knows units as text.

``load_case`` reads a file, ``Case`` is the same thing built in code, and ``M2_TEMPLATE`` is the commented
case that ``tautflex init`` writes.
"""

from tautflex.case.reading import M2_TEMPLATE, load_case, parse_case
from tautflex.case.schema import Case
from tautflex.case.sections.dynamic import Coupling, Damping, Output, Reduction, Solver
from tautflex.case.sections.inputs import Input
from tautflex.case.sections.maneuver import Maneuver
from tautflex.case.sections.structural import Cables, Frame, Membrane, Mesh, Prestress

__all__ = [
    "M2_TEMPLATE",
    "Cables",
    "Case",
    "Coupling",
    "Damping",
    "Frame",
    "Input",
    "Maneuver",
    "Membrane",
    "Mesh",
    "Output",
    "Prestress",
    "Reduction",
    "Solver",
    "load_case",
    "parse_case",
]
