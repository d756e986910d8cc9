"""Pages of all public names, by topic: from the list of names in ``__init__.pyi`` and the rooms they come from."""

from __future__ import annotations

import ast
from pathlib import Path
from typing import Any, NamedTuple

import tautflex
from manual.pages import write as save

SOURCE = Path(tautflex.__file__).parent
INDEX = (
    "# Python",
    "",
    "All public names, as `import tautflex as tf` gives them.",
    "",
    "| page | about |",
    "|---|---|",
)


class Topic(NamedTuple):
    """A page: its title, what it is about, and the modules whose names stand on it."""

    title: str
    about: str
    modules: tuple[str, ...]


TOPICS = {
    "cases": Topic("Cases", "Case files, and what they become.", ("case",)),
    "structure": Topic(
        "Structures",
        "Sections, groups of elements, supports, links, bodies: what a `Model` is made of.",
        ("structure",),
    ),
    "elements": Topic("Elements and laws", "What elements of your own are made of.", ("elements",)),
    "prestress": Topic("Prestress and statics", "From a model to a state in equilibrium.", ("solvers.static",)),
    "modes": Topic(
        "Modes", "Natural frequencies, at rest and spinning; tuning; data for attitude control.", ("solvers.modal",)
    ),
    "maneuvers": Topic("Maneuvers", "How the spacecraft moves: prescribed, or free.", ("motion",)),
    "inputs": Topic("Inputs in time", "Forces, tensions, temperatures, pressures.", ("mechanics.loads",)),
    "damping": Topic("Damping", "What takes energy out.", ("mechanics.dampings",)),
    "runs": Topic("Runs", "The response in time.", ("solvers.transient", "solvers.linear")),
    "methods": Topic(
        "Methods of integration", "And what methods of your own are made of.", ("solvers.transient.methods",)
    ),
    "analysis": Topic("Measures", "What is read from a record.", ("analysis", "mechanics.membrane")),
    "reduction": Topic("Reduced models", "A dozen coordinates with exact forces.", ("reduction",)),
    "batch": Topic("Batches", "Many runs at once, and gradients.", ("batch",)),
    "loops": Topic("Plants and loops", "The linear view, and closed loops on any plant.", ("control",)),
    "actuators": Topic(
        "Actuators and sensors", "What laws command, and what they are told.", ("control.actuators", "control.sensors")
    ),
    "laws": Topic("Control laws", "From readings to commands.", ("control.law", "control.laws")),
    "tasks": Topic(
        "Tasks, policies, judging",
        "What laws are asked to do, learned ones too, and how they are judged.",
        ("control.tasks", "learning"),
    ),
    "studies": Topic("Studies and design", "A case at many values of its keys.", ("study",)),
    "files": Topic("Files", "Meshes in, results out.", ("files",)),
    "pictures": Topic(
        "Figures, films, reports", "Matplotlib figures, films, and pages for a browser.", ("plot", "pages")
    ),
    "errors": Topic("Errors and warnings", "All errors that tautflex raises on purpose.", ("errors", "_version")),
}
"""Pages by file name; a name stands on the page with the longest module that it comes from."""


def public_names(stub: Path = SOURCE / "__init__.pyi") -> dict[str, str]:
    """Public names and the modules that they come from, relative to the package."""
    names = {}
    for node in ast.parse(stub.read_text("utf-8")).body:
        if isinstance(node, ast.ImportFrom):
            names |= {alias.asname or alias.name: node.module or alias.name for alias in node.names}
    return names


def page_of(module: str) -> str | None:
    """The page on which names of a module stand; None where there is none."""
    places = {place: page for page, topic in TOPICS.items() for place in topic.modules}
    fitting = [place for place in places if f"{module}.".startswith(f"{place}.")]
    return places[max(fitting, key=len)] if fitting else None


def pages() -> dict[str, list[str]]:
    """Names of each page; a name without a page is an error."""
    found: dict[str, list[str]] = {page: [] for page in TOPICS}
    for name, module in public_names().items():
        page = page_of(module)
        if page is None:
            raise LookupError(f"{name} of tautflex.{module} stands on no page: give the module a topic in {__file__}")
        found[page].append(name)
    found["pictures"] += [
        f"plot.{name}" for name in public_names(SOURCE / "plot" / "__init__.pyi") if name != "animate"
    ]
    return found


def entry(name: str) -> str:
    """The directive that documents a name."""
    thing: Any = tautflex
    for part in name.split("."):
        thing = getattr(thing, part)
    if isinstance(thing, type):
        return f".. autoclass:: tautflex.{name}\n   :members:\n   :show-inheritance:\n"
    if callable(thing):
        return f".. autofunction:: tautflex.{name}\n"
    if isinstance(thing, str):
        return f".. py:data:: tautflex.{name}\n\n   The version, as text.\n"
    return f".. py:module:: tautflex.{name}\n\n   {thing.__doc__.splitlines()[0]}\n"


def text(page: str, names: list[str]) -> str:
    """The page: a table of its names, then each with what its docstring says."""
    topic, names = TOPICS[page], sorted(names, key=str.lower)
    listed = [name for name in names if name not in {"errors", "plot", "__version__"}]
    table = [
        "```{eval-rst}",
        ".. currentmodule:: tautflex",
        "",
        ".. autosummary::",
        "   :nosignatures:",
        "",
        *(f"   {n}" for n in listed),
        "```",
    ]
    entries = [f"```{{eval-rst}}\n{entry(name)}```\n" for name in names]
    return "\n".join([f"# {topic.title}", "", topic.about, "", *table, "", *entries])


def write(folder: Path) -> None:
    """Write the pages and the list of them."""
    texts = {page: text(page, names) for page, names in pages().items()}
    lines = [f"| [{TOPICS[page].title}]({page}.md) | {TOPICS[page].about} |" for page in texts]
    texts["index"] = "\n".join([*INDEX, *lines, "", "```{toctree}", ":hidden:", "", *texts, "```", ""])
    for page, written in texts.items():
        save(folder / f"{page}.md", written)


def setup(app: Any) -> dict[str, bool]:
    """Sphinx calls this."""
    app.connect("builder-inited", lambda app: write(Path(app.srcdir) / "generated" / "api"))
    return {"parallel_read_safe": True}
