"""Materials of an Abaqus file: isotropic elasticity, density and expansion by name."""

from __future__ import annotations

from dataclasses import dataclass, field

from tautflex.errors import MeshError
from tautflex.files.mesh.abaqus.text import Block, fields
from tautflex.files.mesh.numerals import vector
from tautflex.files.mesh.raw import shorten
from tautflex.numeric import Array

_SIZES = {"ELASTIC": 2, "DENSITY": 1}
ONE_SIDED = ("NO COMPRESSION", "NO TENSION")
MATERIALS = ("MATERIAL", "EXPANSION", *_SIZES, *ONE_SIDED)


@dataclass
class Materials:
    """What MATERIAL blocks and those that belong to them have brought, by name in lower case."""

    values: dict[str, dict[str, float]] = field(default_factory=dict)
    doubts: dict[str, str] = field(default_factory=dict)
    expansions: dict[str, list[Block]] = field(default_factory=dict)
    current: str | None = None

    def read(self, block: Block) -> None:
        """Read a block; MeshError if it belongs to no material, or a name is taken."""
        if block.keyword == "MATERIAL":
            name = block.option("NAME").casefold()
            if not name or name in self.values:
                raise MeshError(f"{block.where}: expected a material of a new name, got {shorten(name)}; rename it")
            self.values[name], self.current = {}, name
            return
        if self.current is None:
            raise MeshError(f"{block.where}: expected it below a *MATERIAL, got none; move it there")
        found = self.values[self.current]
        if block.keyword == "EXPANSION":
            self.expansions.setdefault(self.current, []).append(block)
        elif block.keyword in ONE_SIDED:
            self._doubt(f"{block.keyword} of a material is a law: state law = 'slack' or 'tension-field'")
        elif block.option("TYPE").upper() not in ("", "ISOTROPIC", "ISO"):
            self._doubt(f"its material has TYPE={shorten(block.option('TYPE'))}, expected ISOTROPIC")
        elif len(block.lines) != 1 or "DEPENDENCIES" in block.options:
            self._doubt(f"{block.keyword} of its material is a table")
        else:
            values = self._numbers(block)
            if block.keyword == "DENSITY":
                found["density"] = float(values[0])
            else:
                found["youngs_modulus"], found["poisson_ratio"] = (float(value) for value in values)

    def expansion(self, section: Block) -> float:
        """Coefficient of expansion of a section's material, 0 if it has none; MeshError unless it is one number."""
        name = section.option("MATERIAL").casefold()
        if name not in self.values:
            raise MeshError(
                f"{section.where}: expected a MATERIAL beside *TEMPERATURE, got none; state the prestress in the case"
            )
        found = self.expansions.get(name, [])
        for block in found:
            block.require_options("TYPE", "ZERO")  # strains count from the initial temperature
            if (
                block.option("TYPE").upper() not in ("", "ISO", "ISOTROPIC")
                or len(block.lines) != 1
                or not fields(block.lines[0][1])
                or len(found) > 1
            ):
                raise MeshError(
                    f"{block.where}: expected one number for all directions and temperatures beside *TEMPERATURE, got "
                    "others; write one, or state the prestress in the case"
                )
        return float(vector(fields(found[0].lines[0][1])[:1], found[0].where)[0]) if found else 0.0

    def _numbers(self, block: Block) -> Array:
        """Numbers without the temperature behind them; moduli may be larger than lengths."""
        texts = fields(block.lines[0][1])
        size = _SIZES[block.keyword]
        if not 1 <= len(texts) <= size + 1:
            raise MeshError(f"{block.where}: expected {size} number(s), got {len(texts)}; correct the line")
        return vector([*texts, ""][:size], block.where, largest=1e300)

    def _doubt(self, text: str) -> None:
        assert self.current is not None
        self.doubts.setdefault(self.current, text)
