"""Compiled time stepping of reduced models."""
