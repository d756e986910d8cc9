"""Gymnasium, loaded when the first environment is made."""

from __future__ import annotations

from tautflex.errors import MissingExtraError

try:
    import gymnasium
    from gymnasium.vector import AutoresetMode, VectorEnv
except ImportError as error:
    raise MissingExtraError(
        "learning: expected the package gymnasium >= 1.1, which is not installed; pip install 'tautflex[control]'"
    ) from error

__all__ = ["AutoresetMode", "VectorEnv", "gymnasium"]
