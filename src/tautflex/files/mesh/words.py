"""Which words of a mesh format (cards, keywords) are read, concern no structure, or are refused; no fourth kind."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from tautflex.errors import MeshError
from tautflex.files.mesh.raw import shorten


@dataclass(frozen=True)
class Words:
    """The words of one format; what stands in none of the three tables is refused as unknown.

    Parameters
    ----------
    what
        What the format calls them, ``"card"``.
    read
        What becomes of the words that are read: words by meaning, separated by blanks.
    idle
        Words that leave the structure as it is, by the reason.
    refused
        Words that would change the structure and are not read: words, and what to try, by what they are.
    """

    what: str
    read: Mapping[str, str]
    idle: Mapping[str, str]
    refused: Mapping[str, tuple[str, str]]
    _known: dict[str, str] = field(init=False, repr=False, default_factory=dict)
    _remedies: dict[str, tuple[str, str]] = field(init=False, repr=False, default_factory=dict)

    def __post_init__(self) -> None:
        for known, table in (("read", self.read), ("idle", self.idle)):
            self._known.update((word, known) for words in table.values() for word in _split(words))
        for kind, (words, remedy) in self.refused.items():
            self._remedies.update((word, (kind, remedy)) for word in _split(words))

    def is_read(self, word: str, where: str) -> bool:
        """Whether a word is read, or else concerns no structure; MeshError if it is refused or unknown."""
        known = self._known.get(word)
        if known is not None:
            return known == "read"
        found = self._remedies.get(word)
        if found is not None:
            kind, remedy = found
            raise MeshError(f"{where}: not read here ({kind}), and without it the structure is another; {remedy}")
        raise MeshError(
            f"{where}: expected a {self.what} of the tables in docs/meshes.md, got {shorten(word)}; remove it if the "
            "structure is the same without it"
        )

    def markdown(self) -> str:
        """All three tables as one of Markdown, for the documentation."""
        rows = [f"| {self.what}s | what becomes of them |", "|---|---|"]
        rows += [f"| {_quoted(words)} | read: {meaning} |" for meaning, words in self.read.items()]
        rows += [f"| {_quoted(words)} | without effect: {reason} |" for reason, words in self.idle.items()]
        rows += [f"| {_quoted(words)} | refused: {kind}; {remedy} |" for kind, (words, remedy) in self.refused.items()]
        return "\n".join([*rows, f"| every other {self.what} | refused as unknown |"])


def _split(words: str) -> list[str]:
    """Words of a table; those of several words have underscores between them."""
    return [word.replace("_", " ") for word in words.split()]


def _quoted(words: str) -> str:
    return ", ".join(f"`{word}`" for word in _split(words))
