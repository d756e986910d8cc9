"""Figures of results, for papers: functions on Datasets; matplotlib is imported only when one is used."""

from lazy_loader import attach_stub

__getattr__, __dir__, __all__ = attach_stub(__name__, __file__)
