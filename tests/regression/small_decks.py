"""Small decks of what the rich ones leave out: every card and keyword that is read stands in one of both."""

from __future__ import annotations

from dataclasses import dataclass, field


@dataclass(frozen=True)
class Deck:
    """Text of a deck, what its groups are taken for, and lines that may be missing or others without effect."""

    suffix: str
    text: str
    names: dict[str, str] = field(default_factory=dict)
    idle: frozenset[str] = frozenset()


PART = "GRID,90,,0.,.5,.5\nCROD,90,3,1,90\nPROD,3,1,.75\n"  # what INCLUDE reads

SYSTEMS = """BEGIN BULK
CORD2S,2,,1.,0.,0.,1.25,0.,2.
,2.,.5,0.
CORD1C,3,1,2,3
CORD1S,4,1,2,3
GRID,1,,0.,0.,0.
GRID,2,,0.,0.,1.
GRID,3,,1.,.25,0.
GRID,4,2,1.,40.,30.
GRID,5,3,1.,50.,.5,4
GRID,6,4,1.5,60.,20.
CROD,1,1,1,4
CROD,2,1,2,5
CROD,3,2,3,6
PROD,1,1,.25
PROD,2,2,.5
MAT1,1,7.5,,.25,.5
MAT8,2,7.5,7.5,.25
SPC1,1,1,5
"""

CURVED = """BEGIN BULK
GRID,1,,0.,0.,0.
GRID,2,,1.,0.,0.
GRID,3,,1.,1.25,0.
GRID,4,,0.,1.,0.
GRID,5,,.5,.125,0.
GRID,6,,1.,.5,0.
GRID,7,,.5,1.,0.
GRID,8,,0.,.5,0.
GRID,9,,2.,0.,0.
GRID,10,,1.5,0.,0.
GRID,11,,1.5,.5,0.
CQUAD8,1,1,1,2,3,4,5,6
,7,8
CTRIA6,2,2,2,9,3,10,11,6
PCOMP,1,,,,,,,SYM
,1,.125,0.
PCOMPG,2
,1,1,.125,0.
"""

FLAT = """BEGIN BULK
GRID,1,,0.,0.,0.
GRID,2,,1.,0.,0.
GRID,3,,1.,1.25,0.
GRID,4,,0.,1.,0.
GRID,5,,2.,0.,0.
CQUADR,3,3,1,2,3,4
CTRIAR,4,4,2,5,3
PSHELL,3,1,.25,,,,,.5
PSHELL,4,2,.5
MAT1,1,7.5,,.25,.5
MAT2,2,7.5
"""

BEAMS = """BEGIN BULK
GRID,1,,0.,0.,0.
GRID,2,,1.,.5,0.
GRID,3,,2.,0.,.5
GRID,4,,3.,.5,.5
GRID,5,,4.,0.,0.
GRID,6,,5.,.5,0.
GRID,7,,6.,0.,.5
GRID,8,,7.,.5,.5
GRID,9,,8.,0.,0.
BEAMOR,,1,,,.5,1.,.25
CBEAM,1,,1,2
CBEAM,2,2,2,3,1.,2.,3.
CBAR,3,3,3,4,1.,2.,3.
CBAR,4,4,4,5,1.,2.,3.
CBAR,5,5,5,6,1.,2.,3.
CBAR,6,6,6,7,1.,2.,3.
CBAR,7,7,7,8,1.,2.,3.
CBAR,8,8,8,9,1.,2.,3.
PBEAM,1,1,.25,.5,.75,,1.25,.125
PBEAML,2,1,,BOX
,.5,.75,.125,.0625,.375
PBAR,3,1,.25,.5,.75,1.25,.125
PBARL,4,1,,CHAN
,.5,.75,.125,.0625,.375
PBARL,5,2,,HAT
,.75,.125,.5,.25
PBRSECT,6,1,GS
,OUTP=1
PBMSECT,7,1,OP
,OUTP=1
PBCOMP,8,1,.25
MAT1,1,7.5,2.5,,.5
MAT9,2,7.5
"""

LINKS = """BEGIN BULK
GRID,1,,0.,0.,0.
GRID,2,,1.,.5,0.
GRID,3,,2.,0.,.5
GRID,4,,3.,.5,.5
GRID,5,,4.,0.,0.
GRID,6,,5.,.5,0.
CBAR,1,1,1,2,1.,2.,3.
CBAR,2,1,3,4,1.,2.,3.
CBAR,3,1,5,6,1.,2.,3.
RBAR,11,2,3,123456,,,1236
RBE1,12,4,123456
,UM,5,12346
PBAR,1,1,.25,.5,.75,1.25,.125
MAT1,1,7.5,,.25,.5
SPC,1,1,123456
ENDDATA
GRID,97,,1.,2.,3.
CROD,98,1,1,97
"""

RODS = """BEGIN BULK
GRID,1,,0.,0.,0.
GRID,2,,1.,.5,0.
GRID,3,,2.,0.,.5
GRID,4,,2.,2.,.5
INCLUDE 'part.bdf'
CROD,1,1,1,2
CROD,2,2,2,3
CROD,4,4,1,3
CONROD,5,2,4,7,.5
CONROD,6,3,4,8,.25
PROD,1,1,.25
PROD,2,2,.25
PROD,4,6,.25
MAT1,1,7.5,,.25,.5
MAT3,2,7.5
MAT10,6,7.5
MATHP,7,7.5
MATPOR,8,7.5
"""

BOWED = """*NODE
1, 0., 0., 0.
2, 1., 0., 0.
3, 1., 1.25, 0.
4, 0., 1., 0.
5, 0.5, 0.125, 0.
6, 1., 0.5, 0.
7, 0.5, 1., 0.
8, 0., 0.5, 0.
9, 0.5, 0.5, 0.
10, 2., 0., 0.
11, 1.5, 0., 0.
12, 1.5, 0.5, 0.
*ELEMENT, TYPE=M3D9, ELSET=skin
1, 1, 2, 3, 4, 5, 6, 7, 8, 9
*ELEMENT, TYPE=M3D6, ELSET=skin
2, 2, 10, 3, 11, 12, 6
*MEMBRANE SECTION, ELSET=skin, MATERIAL=one
0.25
*MATERIAL, NAME=one
*ELASTIC
7.5, 0.25
"""

SHELLS = """*HEADING
A panel
*NODE
1, 0., 0., 0.
2, 1., 0., 0.
3, 1., 1.25, 0.
4, 0., 1., 0.
5, 2., 0., 0.
*ELEMENT, TYPE=S4R, ELSET=panel
3, 1, 2, 3, 4
*ELEMENT, TYPE=S3, ELSET=gusset
4, 2, 5, 3
*SHELL SECTION, ELSET=panel, MATERIAL=one
0.5
*SHELL GENERAL SECTION, ELSET=gusset, MATERIAL=two
0.125
*MATERIAL, NAME=one
*ELASTIC
7.5, 0.25
*DENSITY
0.5
*MATERIAL, NAME=two
*ELASTIC
2.5, 0.125
*DENSITY
0.25
*NO TENSION
"""

FRAME = """*INCLUDE, INPUT=part.inp
*NODE
1, 0., 0., 0.
2, 1., 0.5, 0.
3, 2., 0., 0.5
4, 3., 0.5, 0.5
5, 4., 0., 0.
6, 5., 0.5, 0.
7, 6., 0., 0.5
8, 7., 0.5, 0.5
9, 8., 0., 0.
*ELEMENT, TYPE=B33, ELSET=general
1, 1, 2
*ELEMENT, TYPE=B31, ELSET=pipes
2, 2, 3
*ELEMENT, TYPE=B31, ELSET=tees
3, 3, 4
*ELEMENT, TYPE=T3D2, ELSET=ropes
4, 4, 5
*ELEMENT, TYPE=B31, ELSET=boxes
5, 5, 6
*ELEMENT, TYPE=B31, ELSET=rods
6, 7, 8
*ELEMENT, TYPE=DASHPOTA, ELSET=pots
7, 8, 9
*ELEMENT, TYPE=DASHPOT1, ELSET=ground
8, 2
*DASHPOT, ELSET=pots

1.25
*DASHPOT, ELSET=ground
2
2.25
*BEAM GENERAL SECTION, ELSET=general, SECTION=GENERAL, DENSITY=0.75
0.25, 0.5, 0., 0.75, 1.25
0.5, 1., 0.25
7.5, 2.5
*BEAM SECTION, ELSET=pipes, SECTION=PIPE, MATERIAL=one
0.5, 0.125
0.5, 1., 0.25
*BEAM SECTION, ELSET=tees, SECTION=I, MATERIAL=one
0.5, 1., 0.75, 0.75, 0.125, 0.125, 0.0625
0.5, 1., 0.25
*BEAM SECTION, ELSET=boxes, SECTION=BOX, MATERIAL=one
0.5, 0.75, 0.125, 0.125, 0.125, 0.125
0.5, 1., 0.25
*BEAM SECTION, ELSET=rods, SECTION=CIRC, MATERIAL=one
0.5
0.5, 1., 0.25
*SOLID SECTION, ELSET=ropes, MATERIAL=two
0.125
*MATERIAL, NAME=one
*ELASTIC
7.5, 0.25
*DENSITY
0.5
*MATERIAL, NAME=two
*ELASTIC
2.5, 0.125
*NO COMPRESSION
*NSET, NSET=tips
9
*SURFACE, TYPE=NODE, NAME=ends
8
7
*COUPLING, CONSTRAINT NAME=c, REF NODE=9, SURFACE=ends
*DISTRIBUTING
1, 3
*KINEMATIC COUPLING, REF NODE=6
7, 1, 2
*RIGID BODY, REF NODE=2, ELSET=tees
*TRANSFORM, NSET=root, TYPE=C
0., 1., 0., 0.5, 1., 0.25
*NSET, NSET=root
1
*BOUNDARY
root, 1, 2
1, 6
"""
INCLUDED = "*NSET, NSET=held\n1\n*ELSET, ELSET=all\n1, 2\n"

DECKS = {
    "systems": Deck(".bdf", SYSTEMS),
    "curved films": Deck(".bdf", CURVED, {"pid1": "membrane", "pid2": "membrane"}),
    "flat films": Deck(".bdf", FLAT),
    "beams": Deck(".bdf", BEAMS),
    "links": Deck(".bdf", LINKS, idle=frozenset(LINKS.splitlines()[-2:])),
    "rods": Deck(".bdf", RODS),
    "bowed films": Deck(".inp", BOWED),
    "shells": Deck(".inp", SHELLS, {"panel": "membrane", "gusset": "membrane"}, frozenset(("*HEADING", "A panel"))),
    "frame": Deck(".inp", FRAME),
}
