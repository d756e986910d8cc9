"""Small decks with about everything that the readers know, for tests of what gets lost and of what breaks them."""

from __future__ import annotations

NASTRAN = """SPC = 7
BEGIN BULK
GRDSET,,,,,,,456
CORD2R,3,,0.,0.,1.,0.,.5,2.
,1.,1.,1.
CORD2C,5,3,0.,0.,0.,0.,.25,1.
,1.,.5,0.
CORD1R,6,1,2,3
GRID,1,,0.,0.,0.,,0
GRID,2,,1.,0.,0.
GRID,3,,1.,1.,0.
GRID,4,5,1.,90.,.5
GRID,5,3,1.5,.5,.25
GRID,6,6,1.,2.5,.75,,3
GRID,11,,3.,0.,0.,3
GRID,12,,4.,.5,0.,5
GRID,13,,5.,.5,.5
=,*(1),=,*(1.),*(.5),=,==
=(2)
GRID,99,,3.,7.,8.
CQUAD4,1,1,1,2,3,5
CTRIA3,2,2,3,4,5
CROD,3,3,2,11
CTUBE,4,4,3,6
CONROD,5,4,6
BAROR,,9,,,.3,1.,.2
CBAR,6,,11,12
CBAR,7,8,12,13,.5,1.,2.
CBAR,8,8,13,14,99
CBEAM,9,8,14,15,1.,2.,3.,BGG
CBAR,10,8,15,16,1.,2.,3.
SPCADD,7,21,22
SPC1,21,123,1,2,3,4,5,6,+A
SPC1,22,123,11,THRU,13
+A,14,15
SPC,22,16,126,0.,15,5
CONM2,81,14,3,2.,.1,.2,.3
,.5,.01,.6,.02,.03,.7
CONM2,82,15,-1,2.5,7.,1.,1.
CONM1,83,16,3,4.,0.,4.,0.,0.
,4.,0.,-.25,.5,1.5,.25,0.,-1.
,.125,2.,-.5,1.,0.,.25,.375,2.5
CMASS1,84,86,14,1
CMASS2,85,.5,14,2
CMASS2,87,.5,14,3
CMASS2,88,.75,14,4
PMASS,86,.5
PARAM,WTMASS,.125
"""

ABAQUS = """*PART, NAME=Wing
*NODE, NSET=every
1, 0., 0., 0.
2, 1., 0., 0.
3, 1., 1., 0.1
4, 0., 1., 0.
5, 2.5, 0.2, 0.3
*ELEMENT, TYPE=M3D4, ELSET=skin
1, 1, 2, 3, 4
*ELEMENT, TYPE=T3D2, ELSET=stay
2, 3, 5
*ELEMENT, TYPE=B31, ELSET=spar
3, 2, 5
*ELEMENT, TYPE=MASS, ELSET=payload
4, 5
*ELEMENT, TYPE=ROTARYI, ELSET=wheel
5, 2
*MASS, ELSET=payload
2.5
*ROTARY INERTIA, ELSET=wheel
0.5, 0.25, 0.125
*BEAM SECTION, ELSET=spar, SECTION=RECT
0.1, 0.1
0., 1., 2.
*NSET, NSET=root
1, 4
*NSET, NSET=ends, GENERATE
2, 4, 1
*ELSET, ELSET=lines
stay, 3
*END PART
*ASSEMBLY, NAME=all
*INSTANCE, NAME=right, PART=Wing
1., 2., 3.
0., 0., 0., 1., 1., 0., 90.
*END INSTANCE
*INSTANCE, NAME=left, PART=Wing
-1., -2., -3.
*END INSTANCE
*NSET, NSET=roots, INSTANCE=right
root
*NSET, NSET=roots
left.root, left.2
*END ASSEMBLY
*BOUNDARY, AMPLITUDE=a
right.5, 1, 2
*STEP
*STATIC
*BOUNDARY, OP=NEW
roots, ENCASTRE
left.ends, 3
*END STEP
*STEP
*FREQUENCY
*BOUNDARY
right.5, YSYMM
right.3, 2, 4
*END STEP
"""
