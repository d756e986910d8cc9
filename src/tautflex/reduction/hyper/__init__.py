"""Hyper-reduced models: a few weighted elements."""
