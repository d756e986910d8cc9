"""Analysis of responses: spectrum, scalogram, proper orthogonal modes, modal assurance criterion."""

from lazy_loader import attach_stub

__getattr__, __dir__, __all__ = attach_stub(__name__, __file__)
