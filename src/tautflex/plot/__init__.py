"""Figures of results, for papers: functions on Datasets; matplotlib is imported only when one is used."""

from tautflex.public import public_names

__getattr__, __dir__, __all__ = public_names(__name__, __file__)
