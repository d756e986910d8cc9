"""Bases of reduced models."""
