"""JAX, loaded when the first batch is made; calculations are in double precision."""

from __future__ import annotations

from tautflex.compiling import user_place
from tautflex.errors import MissingExtraError

try:
    import jax
    import jax.numpy as jnp
    from threadpoolctl import threadpool_limits
except ImportError as error:
    raise MissingExtraError(
        "batch: expected the packages jax and threadpoolctl, not both installed; pip install 'tautflex[batch]'"
    ) from error

if jax.config.jax_compilation_cache_dir is None:  # type: ignore[attr-defined]
    jax.config.update("jax_compilation_cache_dir", user_place("jax"))  # type: ignore[no-untyped-call]

# Full models of stiff films lose everything in single precision; reduced ones can be computed in it, see `Batch`.
# The switch is JAX's own and holds for the whole process.
jax.config.update("jax_enable_x64", True)  # type: ignore[no-untyped-call]

__all__ = ["PRECISIONS", "jax", "jnp", "platform", "threadpool_limits"]


PRECISIONS = ("double", "single")


def platform() -> str:
    """Kind of device that computes here, such as ``"cpu"``: of `jax.default_device` where one is set."""
    chosen = jax.config.jax_default_device  # type: ignore[attr-defined]
    if chosen is None:
        return str(jax.default_backend())
    return chosen if isinstance(chosen, str) else str(chosen.platform)
