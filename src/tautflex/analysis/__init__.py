"""Analysis of responses: spectrum, scalogram, proper orthogonal modes, modal assurance criterion."""

from tautflex.public import public_names

__getattr__, __dir__, __all__ = public_names(__name__, __file__)
