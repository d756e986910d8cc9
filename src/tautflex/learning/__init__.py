"""Learning to hold an antenna still: environments, training, judging [control.md 5].

Importing it registers ``tautflex/Slew-v0``, ``tautflex/Stop-v0`` and ``tautflex/Hold-v0`` where gymnasium is installed.
"""

from importlib.util import find_spec

from tautflex.learning.cases import TASKS

if find_spec("gymnasium") is not None:
    import gymnasium

    for _task in TASKS:
        gymnasium.register(
            f"tautflex/{_task.capitalize()}-v0",
            entry_point="tautflex.learning.environments.env:AntennaEnv",
            vector_entry_point="tautflex.learning.environments.vector:VectorAntennaEnv",
            kwargs={"task": _task},
        )
