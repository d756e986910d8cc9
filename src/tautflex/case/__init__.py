"""Case files: TOML to and from frozen, validated models; the only place that knows units as text.

``load_case`` reads a file, ``Case`` is the same thing built in code, and ``template`` returns the commented cases that
``tautflex init`` writes.
"""

from tautflex.case.reading import STUDY, TEMPLATES, load_case, parse_case, template, template_files
from tautflex.case.schema import Case
from tautflex.case.sections.dynamic import Coupling, Damping, Output, Reduction, Solver
from tautflex.case.sections.inputs import Input
from tautflex.case.sections.maneuver import Maneuver
from tautflex.case.sections.structural import Cables, Frame, Membrane, Mesh, Prestress

__all__ = [
    "STUDY",
    "TEMPLATES",
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
    "template",
    "template_files",
]
