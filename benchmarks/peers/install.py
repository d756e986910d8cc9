"""Install the peers that come as Python packages, each into its own environment under ``.peers/``.

Run ``python benchmarks/peers/install.py``. The project's own environment is never touched. DOLFINx comes as a Debian
package and is installed by ``make dolfinx`` only.
"""

from __future__ import annotations

import subprocess
import sys
import venv

from programs import ENVIRONMENTS

PACKAGES = {
    "kratos": (
        "KratosMultiphysics==10.4.*",
        "KratosStructuralMechanicsApplication==10.4.*",
        "KratosLinearSolversApplication==10.4.*",
    ),
    "exudyn": ("exudyn>=1.13,<2",),
    "scikit-fem": ("scikit-fem>=11,<13", "scipy>=1.11"),
}


def install(name: str) -> str | None:
    """Make the environment of one peer, unless it is there.

    Parameters
    ----------
    name
        Key of `PACKAGES`.

    Returns
    -------
    str or None
        Why it failed, in one line.
    """
    folder = ENVIRONMENTS / name
    done = folder / "installed"
    if done.exists():
        return None
    print(f"Installing {', '.join(PACKAGES[name])} into .peers/{name} ...", file=sys.stderr)
    venv.create(folder, with_pip=True, clear=True)
    pip = [str(folder / "bin/python"), "-m", "pip", "--quiet", "--disable-pip-version-check"]
    tried = subprocess.run([*pip, "install", *PACKAGES[name]], capture_output=True, text=True, check=False)
    if tried.returncode:
        lines = tried.stderr.strip().splitlines() or ["no message"]
        return f"{name}: pip failed: {lines[-1]}"
    done.touch()
    return None


def main() -> None:
    """Install every peer; say in one line what could not be."""
    for name in PACKAGES:
        failure = install(name)
        if failure:
            print(failure, file=sys.stderr)


if __name__ == "__main__":
    main()
