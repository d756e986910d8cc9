r"""Constitutive laws: stress and tangent from the elastic trial stress, one law a file [theory.md 2].

A law sees the trial stress ``s = sigma_0 + D strain`` of one integration point and replaces it. The laws here are
gradients of a convex stored energy (Pipkin's relaxed energy), so that statics stay well posed.
"""

from tautflex.elements.laws.elastic import Elastic
from tautflex.elements.laws.law import LAWS, Law, LawFunction, TensionOnly, law_of, register_law
from tautflex.elements.laws.slack import Slack
from tautflex.elements.laws.tension_field import TensionField

__all__ = [
    "LAWS",
    "Elastic",
    "Law",
    "LawFunction",
    "Slack",
    "TensionField",
    "TensionOnly",
    "law_of",
    "register_law",
]
