"""A small reduced film for studies, and scripts that run them in processes of their own."""

from __future__ import annotations

from tautflex import Study
from tautflex.case import parse_case


def film(rate: float, solver: str) -> str:
    """Case of a film that stops."""
    return f"""schema = 1
[membrane]
length = 2.0
width = 1.0
thickness = 1e-4
youngs_modulus = 3.5e9
poisson_ratio = 0.34
density = 1530.0
edges = "fixed"
stress_x = 4000.0
stress_y = 4000.0
[mesh]
divisions = [6, 4]
[maneuver]
kind = "stop"
rate = {rate}
duration = 0.05
[solver]
{solver}
[output]
probes = {{ A = [0.3, 0.2] }}
"""


SOLVER = 'method = "central-difference"\ntime_step = 5e-3\nend_time = 0.4'
FILM = f"""{film(0.1, SOLVER)}
[reduction]
count = 4
directions = ["rx"]
"""
PROBE = ("probes.A.amplitude", "probes.A.dominant_frequency")


def film_study(rates=(0.05, 0.1, 0.2), *, names=PROBE, kind="serial", workers=1, **more) -> Study:
    axes = {"maneuver.rate": list(rates), "damping.beta": [0.0, 2e-3]}
    engine = {"kind": kind, "workers": workers}
    return Study(**{"base": parse_case(FILM), "axes": axes, "measures": {"names": names}, "engine": engine} | more)
