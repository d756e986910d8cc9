"""Cross-sections of PBARL and PBEAML against rasters of their figures: area, moments, and Saint-Venant's torsion."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.sparse import diags_array, eye_array, kron
from scipy.sparse.linalg import spsolve

from verification import decks

UNIT = 1e-3  # [m], of dimensions and rectangles
# Dimensions, and the rectangles of the figure in the manual: lowest and highest y, lowest and highest z.
FIGURES = {
    "I": ((60, 48, 24, 2, 3, 2), [(0, 3, -24, 24), (3, 58, -1, 1), (58, 60, -12, 12)]),
    "I1": ((34, 2, 36, 40), [(0, 2, -18, 18), (2, 38, -1, 1), (38, 40, -18, 18)]),
    "CHAN": ((24, 40, 2, 3), [(0, 40, 0, 2), (0, 3, 2, 24), (37, 40, 2, 24)]),
    "CHAN1": ((22, 2, 34, 40), [(0, 40, 0, 2), (0, 3, 2, 24), (37, 40, 2, 24)]),
    "CHAN2": ((2, 3, 24, 40), [(0, 3, 0, 40), (3, 24, 0, 2), (3, 24, 38, 40)]),
    "T": ((30, 36, 2, 3), [(34, 36, 0, 30), (0, 34, 13.5, 16.5)]),
    "T1": ((36, 30, 2, 3), [(0, 36, 0, 2), (16.5, 19.5, 2, 32)]),
    "T2": ((30, 36, 2, 3), [(0, 2, 0, 30), (2, 36, 13.5, 16.5)]),
    "CROSS": ((30, 3, 40, 2), [(0, 40, 15, 18), (19, 21, 0, 15), (19, 21, 18, 33)]),
    "H": ((30, 6, 40, 2), [(0, 40, 0, 3), (0, 40, 33, 36), (19, 21, 3, 33)]),
    "HAT": ((30, 2, 26, 12), [(28, 30, 12, 38), (2, 28, 12, 14), (2, 28, 36, 38), (0, 2, 0, 14), (0, 2, 36, 50)]),
}


def raster(rectangles, cell):
    """Which cells of a grid with a margin of one cell are filled, rows along y."""
    high, wide = (int(max(one[k] for one in rectangles) / cell) for k in (1, 3))
    shift = int(-min(one[2] for one in rectangles) / cell)
    filled = np.zeros((high + 2, wide + shift + 2), dtype=bool)
    for y0, y1, z0, z1 in rectangles:
        y, z = (slice(int(a / cell) + 1, int(b / cell) + 1) for a, b in ((y0, y1), (z0, z1)))
        filled[y, slice(z.start + shift, z.stop + shift)] = True
    return filled


def torsion(filled):
    """Torsion constant 2 times the integral of Prandtl's stress function, whose Laplacian is -2 [cells^4]."""
    # Nodes at the corners of cells; those with four filled cells around them are inside.
    inside = (filled[:-1, :-1] & filled[1:, :-1] & filled[:-1, 1:] & filled[1:, 1:]).ravel()
    rows, columns = filled.shape[0] - 1, filled.shape[1] - 1

    def second(n):
        return diags_array([np.full(n - 1, -1.0), np.full(n, 2.0), np.full(n - 1, -1.0)], offsets=[-1, 0, 1])

    laplacian = kron(second(rows), eye_array(columns)) + kron(eye_array(rows), second(columns))
    return 2.0 * spsolve(laplacian.tocsc()[inside][:, inside], np.full(inside.sum(), 2.0)).sum()


def converged(coarse, fine):
    """Torsion constant of two rasters [cells of the finer^4]: errors go with the square of the cell."""
    return (4.0 * torsion(fine) - 16.0 * torsion(coarse)) / 3.0


def section(card, shape, dimensions, read):
    sizes = [repr(one * UNIT) for one in dimensions]
    text = f"{card},1,1,,{shape}\n,{','.join(sizes)}\nMAT1,1,7.+10,,.33,2700.\n"
    return read(".bdf", decks.nastran(properties=text)).sections["pid1"]


@pytest.mark.parametrize("shape", FIGURES)
def test_open_profiles(shape, read, verification_row):
    dimensions, rectangles = FIGURES[shape]
    coarse, fine = (raster(rectangles, cell) for cell in (0.5, 0.25))
    y, z = np.nonzero(fine)
    size = 0.25 * UNIT
    wanted = {
        "area": len(y) * size**2,
        "inertia_z": len(y) * (y.var() + 1.0 / 12.0) * size**4,
        "inertia_y": len(y) * (z.var() + 1.0 / 12.0) * size**4,
    }
    found = section("PBARL", shape, dimensions, read)
    assert found.doubt == ""
    for name, value in wanted.items():
        assert found.values[name] == pytest.approx(value, rel=1e-9)
    exact = converged(coarse, fine) * size**4
    verification_row(f"PBARL {shape}: torsion constant [m^4]", exact, found.values["torsion_constant"], "raster")
    assert found.values["torsion_constant"] == pytest.approx(exact, rel=0.05)


def test_profiles_of_beams_keep_shear_centre_and_centroid_apart(read):
    """A CBEAM of a profile with one axis of symmetry is not that of a CBAR: the deck must say which is meant."""
    for shape, (dimensions, rectangles) in FIGURES.items():
        filled = raster(rectangles, 0.5)
        twofold = (filled == filled[::-1]).all() and (filled == filled[:, ::-1]).all()
        found = section("PBEAML", shape, dimensions, read)
        assert (found.doubt == "") == twofold
        if twofold:
            assert found.values == section("PBARL", shape, dimensions, read).values
        else:
            assert "beside its shear centre" in found.doubt


def test_torsion_of_rasters():
    """A square of side a: 0.140577 a^4."""
    square = [(0, 2, 0, 2)]
    found = converged(raster(square, 0.25), raster(square, 0.125))
    assert found == pytest.approx(0.1405770 * 16**4, rel=5e-4)
