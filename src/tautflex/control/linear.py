r"""Linear view of a plant: four matrices with labels, and what each input does to the stiffness [control.md 3]."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from scipy.linalg import expm

from tautflex import checks
from tautflex.control.sampled import Carried, Lateness, Sampled
from tautflex.errors import InputError, MissingExtraError
from tautflex.numeric import Array, Indices
from tautflex.text import card, count

# Columns below this part of what they were are round-off of what went.
_ROUND_OFF = 1e-11


@dataclass(frozen=True, eq=False)
class LinearPlant:
    """Small motion about a steady state: ``dx/dt = A x + B u``, ``y = C x + D u``, or ``x <- A x + B u``.

    ``x = (theta, eta, omega, deta/dt)``: rotation of the hub about its axes, coordinates of the structure (mass-
    normalised), and their rates. All are deviations from the state. What modes that are left out add at once
    stands in C and D.

    Parameters
    ----------
    A, B, C, D
        Shapes (state, state), (state, input), (output, state), (output, input).
    states, inputs, outputs
        Labels.
    input_units, output_units
        Units of one number each.
    axes
        Number of the hub's axes among the states.
    stiffness
        Stiffness of the coordinates, shape (coordinate, coordinate).
    bilinear
        Change of that stiffness per unit of each input, shape (input, coordinate, coordinate): an input u adds the
        force ``-u bilinear eta``, which the matrices do not have.
    level
        Outputs in the steady state, from which y is counted, shape (output,).
    remarks
        What the matrices do not tell, in words: label of an input -> why it has no column, or a partial one; what of
        its drive is left out.
    interval
        Time of one step [s]; None is continuous time.
    late
        Lags and delays of drives, ages of readings: `discretize` makes states of them, which come last; the matrices of
        continuous time have none of it. None is none.
    carried
        What these further states hold.
    """

    A: Array
    B: Array
    C: Array
    D: Array
    states: tuple[str, ...]
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    input_units: tuple[str, ...]
    output_units: tuple[str, ...]
    axes: int
    stiffness: Array
    bilinear: Array
    level: Array
    remarks: dict[str, str] = field(default_factory=dict)
    interval: float | None = None
    late: Lateness | None = None
    carried: tuple[Carried, ...] = ()

    def __repr__(self) -> str:
        time = "continuous" if self.interval is None else f"{self.interval:g} s"
        lines = {
            "states": f"{len(self.states)}: {count(self.axes, 'angle')} of the hub, "
            f"{count(self.coordinates, 'coordinate')}, and their rates"
            + (f", {len(self.carried)} of drives and sensors" if self.carried else ""),
            "inputs": ", ".join(self.inputs),
            "outputs": ", ".join(self.outputs),
            "time": time,
            **self.remarks,
        }
        return card(self, lines)

    @property
    def coordinates(self) -> int:
        """Number of coordinates of the structure."""
        return len(self.stiffness)

    @property
    def positions(self) -> Indices:
        """Places of the coordinates among the states; their rates are ``axes + coordinates`` further on."""
        return np.arange(self.axes, self.axes + self.coordinates)

    @property
    def half(self) -> int:
        """Number of positions, hub and coordinates; as many rates follow them."""
        return self.axes + self.coordinates

    @property
    def columns(self) -> tuple[str, ...]:
        """Labels of the inputs that have a linear column."""
        moved = np.any(self.B != 0.0, axis=0)
        return tuple(label for label, one in zip(self.inputs, moved, strict=True) if one)

    @property
    def poles(self) -> Any:
        """Eigenvalues of A, complex [1/s] or [-], shape (state,)."""
        return np.linalg.eigvals(self.A)

    def selected(self, inputs: Sequence[str], outputs: Sequence[str]) -> LinearPlant:
        """The same with these inputs and outputs in this order.

        Raises
        ------
        InputError
            If it has not one of them.
        """
        m, p = _places("inputs", inputs, self.inputs), _places("outputs", outputs, self.outputs)
        return replace(
            self,
            B=self.B[:, m],
            C=self.C[p],
            D=self.D[np.ix_(p, m)],
            inputs=tuple(inputs),
            outputs=tuple(outputs),
            input_units=tuple(self.input_units[k] for k in m),
            output_units=tuple(self.output_units[k] for k in p),
            bilinear=self.bilinear[m],
            level=self.level[p],
            late=None if self.late is None else self.late.selected(m, p),
            remarks={label: text for label, text in self.remarks.items() if label in inputs},
        )

    def truncated(self, coordinates: int) -> LinearPlant:
        """The same with the first coordinates alone; the others are in equilibrium at every instant.

        With ``x2`` what goes, ``0 = A21 x1 + A22 x2 + B2 u`` [Kokotovic, Khalil & O'Reilly 1986].

        Raises
        ------
        InputError
            If it has fewer, or is one in discrete time.
        """
        if self.interval is not None:
            raise InputError(f"plant: expected one in continuous time, got one of {self.interval:g} s; truncate first")
        most = self.coordinates
        if not 1 <= checks.whole("coordinates", coordinates, 1) <= most:
            raise InputError(f"coordinates: expected at most {most}, got {coordinates}; linearize with more modes")
        gone = self.positions[coordinates:]
        gone = np.concatenate([gone, gone + self.axes + most])
        kept = np.setdiff1d(np.arange(len(self.states)), gone)
        follow = -np.linalg.solve(
            self.A[np.ix_(gone, gone)], np.concatenate([self.A[np.ix_(gone, kept)], self.B[gone]], axis=1)
        )
        state, given = follow[:, : len(kept)], follow[:, len(kept) :]
        forward, seen = self.A[np.ix_(kept, gone)], self.C[:, gone]
        b = self.B[kept] + forward @ given
        b[:, np.abs(b).max(axis=0, initial=0.0) <= _ROUND_OFF * np.abs(self.B).max(axis=0, initial=0.0)] = 0.0
        return replace(
            self,
            A=self.A[np.ix_(kept, kept)] + forward @ state,
            B=b,
            C=self.C[:, kept] + seen @ state,
            D=self.D + seen @ given,
            states=tuple(self.states[k] for k in kept),
            stiffness=self.stiffness[:coordinates, :coordinates],
            bilinear=self.bilinear[:, :coordinates, :coordinates],
        )

    def discretize(self, interval: float) -> LinearPlant:
        """Exact motion over one interval with the inputs held, by one matrix exponential [Van Loan 1978].

        What drives and sensors delay is part of it; of inputs that have such states what acts is one, so that
        ``y = C x`` is measured before the next command.

        Raises
        ------
        InputError
            If the interval is not positive, the plant is discrete already, or the delay of an input is no multiple of
            the interval.
        """
        step = checks.positive("interval", interval)
        if self.interval is not None:
            raise InputError(f"plant: expected one in continuous time, got one of {self.interval:g} s; linearize anew")
        n, m = self.B.shape
        whole = np.zeros((n + m, n + m))
        whole[:n, :n], whole[:n, n:] = self.A * step, self.B * step
        motion = expm(whole)
        sampled = Sampled(motion[:n, :n], motion[:n, n:], self.C, self.D)
        if self.late:
            sampled.take_in(self.late, step, self.inputs, self.outputs)
        return replace(
            self,
            A=sampled.A,
            B=sampled.B,
            C=sampled.C,
            D=sampled.D,
            states=(*self.states, *sampled.labels),
            interval=step,
            late=None,
            carried=tuple(sampled.carried),
        )

    def to_control(self) -> Any:
        """State space of python-control with the labels (extra ``control``).

        Raises
        ------
        MissingExtraError
            If python-control is not installed.
        """
        try:
            import control
        except ImportError as error:
            raise MissingExtraError(
                "to_control: expected the package control, which is not installed; pip install 'tautflex[control]'"
            ) from error
        labels = {"states": list(self.states), "inputs": list(self.inputs), "outputs": list(self.outputs)}
        return control.ss(self.A, self.B, self.C, self.D, 0 if self.interval is None else self.interval, **labels)

    def to_mat(self, path: str | Path) -> Path:
        """Write a MATLAB file: A, B, C, D, the labels, ``stiffness``, ``bilinear``, ``level``, ``interval`` (or 0).

        Returns
        -------
        pathlib.Path
            Where it is.

        Raises
        ------
        InputError
            If it cannot be written there.
        """
        place = checks.path("path", path)
        names = ("states", "inputs", "outputs", "input_units", "output_units")
        values: dict[str, Any] = {name: np.array(getattr(self, name), dtype=object) for name in names}
        for name in ("A", "B", "C", "D", "stiffness", "bilinear", "level"):
            values[name] = getattr(self, name)
        try:
            from scipy.io import savemat  # here, because the command line does without

            savemat(place, values | {"interval": self.interval or 0.0}, appendmat=False)
        except OSError as error:
            raise InputError(
                f"path: expected a file that can be written, got {place} ({error}); give another"
            ) from None
        return place


def _places(key: str, wanted: Sequence[str], known: tuple[str, ...]) -> Indices:
    missing = [label for label in wanted if label not in known]
    if missing:
        text = f"{key}: expected some of {', '.join(map(repr, known)) or 'none'}, got {missing[0]!r}"
        raise InputError(f"{text}; linearize a plant that has it")
    return np.array([known.index(label) for label in wanted], dtype=np.int64)
