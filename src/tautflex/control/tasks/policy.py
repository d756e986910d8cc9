"""Learned policies: a small network behind a linear law, in a file of arrays."""

from __future__ import annotations

import hashlib
import json
import os
import zipfile
from collections.abc import Mapping
from dataclasses import dataclass, field
from importlib.resources import files
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from tautflex import checks
from tautflex.control.law import ControlLaw, own_memory
from tautflex.control.signals import LoopSpec, Reference
from tautflex.control.tasks.observation import Observation
from tautflex.errors import InputError
from tautflex.numeric import Array
from tautflex.writing import written

_FORMAT = 1
# Trained policies that come with the package: name -> file in data/policies.
SHIPPED = {"tautflex/Slew-v0": "slew-v0.npz"} | {
    f"tautflex/Slew-v0-seed{n}": f"slew-v0-seed{n}.npz" for n in (1, 2, 3, 4)
}
_LARGEST_FILE = 100_000_000


def network(layers: Any, gain: Any, z: Any, seen: Any, held: Any, keep: float, xp: Any = np) -> tuple[Any, Any]:
    """Action ``clip(gain z + h)`` in [-1, 1], and the network's part h of it.

    There is a lag behind the network:
    ``h = keep h_before + (1 - keep) tanh(W_n tanh(... tanh(W_1 o + b_1) ...) + b_n)``.

    Parameters
    ----------
    layers
        Pairs W, b of every layer, shapes (out, in) and (out,).
    gain
        Linear law in parts of the limits, shape (commands, z).
    z, seen
        See `Observation`.
    held
        The network's part of the action before, shape (commands,).
    keep
        Part of it that stays, in [0, 1): of a lag of T seconds ``exp(-interval/T)``.
    xp
        Array module.
    """
    value = seen
    for weights, bias in layers:
        value = xp.tanh(weights @ value + bias)
    held = keep * held + (1.0 - keep) * value
    return xp.clip(gain @ z + held, -1.0, 1.0), held


class PolicyMemory(NamedTuple):
    """Measurement (None before the first), action and the network's part of it in the interval before."""

    measurement: Array | None
    action: Array
    held: Array


@dataclass(frozen=True, eq=False)
class Policy(ControlLaw):
    """Small network that commands, for loops of one shape.

    Parameters
    ----------
    observation
        What it sees.
    layers
        Pairs W, b of every layer.
    gain
        Linear law beside the network, in parts of the limits, shape (commands, z).
    limits
        Command that counts one, shape (commands,).
    measured, commanded
        Labels of the loop that it is for.
    interval
        Time between two commands [s].
    keep
        Of the lag behind the network, see `network`.
    told
        What is known about its making: seed, command line, costs.
    """

    observation: Observation
    layers: tuple[tuple[Array, Array], ...]
    gain: Array
    limits: Array
    measured: tuple[str, ...]
    commanded: tuple[str, ...]
    interval: float
    keep: float = 0.0
    told: Mapping[str, Any] = field(default_factory=dict)

    def start(self, spec: LoopSpec) -> PolicyMemory:
        """Memory without a past; InputError unless the loop is of the policy's shape."""
        for what, have, want in (
            ("measurements", spec.measured, self.measured),
            ("commands", spec.commanded, self.commanded),
            ("interval", (f"{spec.interval:g} s",), (f"{self.interval:g} s",)),
        ):
            if have != want:
                raise InputError(
                    f"policy: expected a loop with {what} {', '.join(want) or 'none'}, got {', '.join(have) or 'none'};"
                    " train one for this loop"
                )
        return PolicyMemory(None, *np.zeros((2, len(self.limits))))

    def act(self, memory: PolicyMemory, measurement: Array, reference: Reference) -> tuple[PolicyMemory, Array]:
        """One pass through the network."""
        memory = own_memory(memory, PolicyMemory)
        before = measurement if memory.measurement is None else memory.measurement
        goal = reference.attitude if reference.goal is None else reference.goal
        z = np.concatenate([measurement, before, reference.numbers, goal])
        if len(z) != self.gain.shape[1]:
            raise InputError(
                f"measurement: expected {self.gain.shape[1]} numbers with reference and those before, got {len(z)}; "
                "give what the loop tells that the policy was started for"
            )
        seen = self.observation(z, memory.action, np.float64(reference.time))
        action, held = network(self.layers, self.gain, z, seen, memory.held, self.keep)
        return PolicyMemory(measurement.copy(), action, held), self.limits * action

    @property
    def digest(self) -> str:
        """Fingerprint of its numbers, of 16 digits."""
        found = hashlib.sha256()
        for array in self._arrays().values():
            found.update(np.ascontiguousarray(array, dtype="<f8").tobytes())
        return found.hexdigest()[:16]

    def _arrays(self) -> dict[str, Array]:
        seen = self.observation
        arrays = {"matrix": seen.matrix, "knee": seen.knee, "largest": seen.largest}
        arrays |= {"gain": self.gain, "limits": self.limits}
        for number, (weights, bias) in enumerate(self.layers):
            arrays |= {f"weights_{number}": weights, f"bias_{number}": bias}
        return arrays

    def save(self, path: str | os.PathLike[str]) -> Path:
        """Write a file of arrays (.npz); an older one is replaced at once or not at all.

        Returns
        -------
        pathlib.Path
            The file.
        """
        target = checks.path("path", path)
        words = {
            "format": _FORMAT,
            "labels": self.observation.labels,
            "duration": self.observation.duration,
            "measured": self.measured,
            "commanded": self.commanded,
            "interval": self.interval,
            "keep": self.keep,
            "told": dict(self.told),
        }
        with written(target) as place, place.open("wb") as file:
            np.savez(file, words=np.array(json.dumps(words)), **self._arrays())  # type: ignore[arg-type]
        return target

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Policy:
        """Read what `save` wrote, or a policy that comes with the package by its name, ``"tautflex/Slew-v0"``.

        Raises
        ------
        InputError
            If the file is missing, damaged, or no policy.
        """
        source = checks.path("file", path)
        # Case files put their folder before it.
        shipped = SHIPPED.get("/".join(source.parts[-2:]))
        if shipped is not None and not source.exists():
            source = Path(str(files("tautflex").joinpath("data", "policies", shipped)))
        expected = "a policy, a file of arrays (.npz) as `tautflex train` writes it"
        if not source.is_file():
            raise InputError(
                f"{source}: expected {expected}, got no such file; train one, or take {next(iter(SHIPPED))}"
            )
        if source.stat().st_size > _LARGEST_FILE:
            raise InputError(f"{source}: expected {expected}, got a file of more than 100 MB; choose another one")
        try:
            if not zipfile.is_zipfile(source):  # numpy would take it for a pickle, and say how to trust it
                raise zipfile.BadZipFile("no archive of arrays")
            with source.open("rb") as raw, np.load(raw, allow_pickle=False) as file:
                words = json.loads(str(file["words"]))
                arrays = {name: np.asarray(file[name], dtype=float) for name in file.files if name != "words"}
            if words["format"] != _FORMAT:
                text = f"{source}: expected a policy of format {_FORMAT}, got {words['format']}"
                raise InputError(f"{text}; train it anew, or take a newer tautflex")
            return cls._of(arrays, words)
        except (OSError, ValueError, KeyError, TypeError, EOFError, zipfile.BadZipFile) as error:
            if isinstance(error, InputError):
                raise
            reason = " ".join(f"{type(error).__name__}: {error}".split())[:120]
            raise InputError(
                f"{source}: expected {expected}, got a damaged file or another one ({reason}); train it anew"
            ) from None

    @classmethod
    def _of(cls, arrays: dict[str, Array], words: dict[str, Any]) -> Policy:
        count = sum(name.startswith("weights_") for name in arrays)
        layers = tuple((arrays[f"weights_{number}"], arrays[f"bias_{number}"]) for number in range(count))
        labels, commands = tuple(words["labels"]), len(words["commanded"])
        rows, sizes = len(labels) - commands - 1, [len(labels), *(len(bias) for _, bias in layers)]
        z = arrays["matrix"].shape[1]
        shapes = {
            "matrix": (rows, z),
            "knee": (rows,),
            "largest": (rows,),
            "gain": (commands, z),
            "limits": (commands,),
        }
        for number, (inner, outer) in enumerate(pairwise(sizes)):
            shapes |= {f"weights_{number}": (outer, inner), f"bias_{number}": (outer,)}
        for name, shape in shapes.items():
            if arrays[name].shape != shape or not np.isfinite(arrays[name]).all():
                raise ValueError(f"{name} is not of shape {shape} and finite")
        if not count or sizes[-1] != commands:
            raise ValueError(f"its last layer gives {sizes[-1]} commands of {commands}")
        seen = Observation(arrays["matrix"], arrays["knee"], arrays["largest"], labels, float(words["duration"]))
        names = tuple(words["measured"]), tuple(words["commanded"])
        interval, keep = float(words["interval"]), float(words.get("keep", 0.0))
        if not 0.0 <= keep < 1.0:
            raise ValueError(f"keep is {keep}")
        return cls(seen, layers, arrays["gain"], arrays["limits"], *names, interval, keep, words["told"])

    def __repr__(self) -> str:
        sizes = " x ".join(str(len(bias)) for _, bias in self.layers)
        return f"Policy({self.observation.size} x {sizes}, {self.digest})"
