"""Arrays that are lent to compiled code for a while: nobody counts who refers to them.

Compiled functions count the references to every array that they are handed, also inside tuples: an atomic operation at
the start of each function and one at its end. With a hundred arrays and small meshes this takes longer than the
arithmetic.
"""

from __future__ import annotations

from typing import Any

from numba.core import cgutils, types
from numba.extending import intrinsic
from numba.np.arrayobj import make_array


def _forget(context: Any, builder: Any, kind: Any, value: Any) -> Any:
    """The value without the owners of the arrays in it."""
    if isinstance(kind, types.Array):
        array = make_array(kind)(context, builder, value)
        for owner in ("meminfo", "parent"):
            setattr(array, owner, cgutils.get_null_value(getattr(array, owner).type))
        return array._getvalue()
    if isinstance(kind, types.BaseTuple):
        members: Any = kind
        for place, part in enumerate(members.types):
            own = _forget(context, builder, part, builder.extract_value(value, place))
            value = builder.insert_value(value, own, place)
    return value


def _lent(typing_context: Any, value: Any) -> Any:
    """An array, or a tuple of tuples and arrays, whose memory others hold as long as it is used.

    It must not be returned to Python, nor outlive what it was made of.
    """

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return _forget(context, builder, signature.args[0], arguments[0])

    return value(value), code


lent: Any = intrinsic(_lent)  # mypy counts the typing context among the arguments
