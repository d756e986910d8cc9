"""A trained policy as a law of a case file."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

from tautflex.control.law import ControlLaw
from tautflex.control.signals import LoopSpec, Reference
from tautflex.control.tasks.policy import Policy, PolicyMemory
from tautflex.numeric import Array


@dataclass(frozen=True)
class PolicyLaw(ControlLaw):
    """A policy that was trained (`tautflex train`), from its file; no network library is needed.

    Parameters
    ----------
    file
        File of arrays (.npz), or the name of a policy that comes with the package, ``"tautflex/Slew-v0"``.

    Raises
    ------
    InputError
        If the file is missing, damaged, or no policy; and when it starts, if the loop has another shape.

    Examples
    --------
    >>> import tautflex as tf
    >>> tf.PolicyLaw("tautflex/Slew-v0").policy.commanded
    ('torque', 'tension_x', 'tension_y')
    """

    file: str
    kind: ClassVar[str] = "policy"

    def __post_init__(self) -> None:
        assert self.policy

    @cached_property
    def policy(self) -> Policy:
        """What the file holds."""
        return Policy.load(self.file)

    def start(self, spec: LoopSpec) -> PolicyMemory:
        """Memory without a past; InputError unless the loop is of the policy's shape."""
        return self.policy.start(spec)

    def act(self, memory: PolicyMemory, measurement: Array, reference: Reference) -> tuple[PolicyMemory, Array]:
        """One pass through the network."""
        return self.policy.act(memory, measurement, reference)
