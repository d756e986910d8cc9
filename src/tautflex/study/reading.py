"""Study files: TOML to a validated study, and the case that it starts from."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

from tautflex import checks
from tautflex.case.messages import one_line
from tautflex.case.reading import case_values, load_case, study_values
from tautflex.case.schema import Case
from tautflex.errors import CaseError
from tautflex.study.sections import Study


def load_study(path: str | os.PathLike[str]) -> Study:
    """Read and validate a study file; its case is read too.

    Parameters
    ----------
    path
        TOML file, UTF-8.

    Returns
    -------
    Study
        Frozen, validated; ``base`` is relative to where the program runs.

    Raises
    ------
    CaseError
        One line with file, key, value, expectation and remedy.

    Examples
    --------
    >>> import tautflex as tf
    >>> list(tf.load_study("study.toml").axes)                  # tautflex init study.toml --template study
    ['maneuver.duration', 'damping.beta']
    """
    source = checks.path("path", path)
    name = one_line(str(source))
    values = study_values(source)
    base = values.get("base")
    if isinstance(base, str):
        values["base"] = source.parent / base
    try:
        study = Study(**values)
        base_values(study)
    except CaseError as error:
        raise error.behind(f"{name}: ") from None
    return study


def base_values(study: Study) -> dict[str, Any]:
    """Keys of the case that a study starts from, valid, as `Case` takes them.

    Raises
    ------
    CaseError
        If the case is wrong, or its file cannot be read.
    """
    if isinstance(study.base, Case):
        return study.base.model_dump(by_alias=True, exclude_none=True)
    try:
        load_case(study.base)
        return case_values(Path(study.base))
    except CaseError as error:
        raise error.behind("base: ") from None
