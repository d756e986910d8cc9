"""The keys of a study file, listed from its sections."""

from __future__ import annotations

from tautflex.case.help.reference import SectionEntry, entry_of
from tautflex.case.section import Section
from tautflex.study.sections import Design, Engine, Limit, Measures, Span, Study, Variable


def study_reference() -> list[SectionEntry]:
    """Sections of a study file and their keys."""
    sections: dict[str, type[Section]] = {
        "study file": Study,
        "[axes] { from, to, count }": Span,
        "[measures]": Measures,
        "[engine]": Engine,
        "[design]": Design,
        "[design.variables] { from, to } or { choices }": Variable,
        "[design.constraints] { above, below }": Limit,
    }
    entries = [entry_of(title, section) for title, section in sections.items()]
    own = tuple(key for key in entries[0].keys if f"[{key.name}]" not in sections)
    return [entries[0]._replace(keys=own), *entries[1:]]
