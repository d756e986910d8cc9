"""The cards of Nastran: read, without effect, refused."""

from __future__ import annotations

from tautflex.files.mesh.words import Words

_JOIN = "join the nodes by stiff beams, or merge them"
_FILM = "mesh film with CTRIA3, CTRIA6, CQUAD4 or CQUAD8, cables with CROD, beams with CBAR"
_POINTS = "write its points as GRID"

WORDS = Words(
    "card",
    read={
        "points, with `GRDSET` for their blank fields": "GRID GRDSET",
        "coordinate systems that points use; others are not looked at": "CORD1R CORD1C CORD1S CORD2R CORD2C CORD2S",
        "film; a property (PSHELL) with bending stiffness, or a laminate, must be asked for": (
            "CTRIA3 CTRIAR CQUAD4 CQUADR CTRIA6 CQUAD8"
        ),
        "sections of films: thickness and nonstructural mass; laminates need theirs stated": "PSHELL PCOMP PCOMPG",
        "sections of cables: area and nonstructural mass, torsion without effect": "PROD PTUBE",
        "sections of beams: area, moments, torsion, nonstructural mass; PBARL and PBEAML with ROD, TUBE, TUBE2, BAR, "
        "BOX, I, I1, H, CROSS, PBARL also with CHAN, CHAN1, CHAN2, T, T1, T2, HAT; others, tapers, I12, warping and "
        "offsets need theirs stated; shear flexibility and stress recovery without effect": (
            "PBAR PBARL PBEAM PBEAML PBRSECT PBMSECT PBCOMP"
        ),
        "isotropic materials (MAT1): E, G, nu, density, expansion; sections of others need theirs stated; damping and "
        "strength without effect": "MAT1 MAT2 MAT3 MAT8 MAT9 MAT10 MATHP MATPOR",
        "cables": "CROD CONROD CTUBE",
        "beams with orientation, offsets and pin flags, `BAROR` and `BEAMOR` for blank fields": (
            "CBAR CBEAM BAROR BEAMOR"
        ),
        "supports: the set that the case control selects": "SPC SPC1 SPCADD",
        "point masses and inertias; of the parameters only their factor WTMASS, and CM1 and CK1 are refused": (
            "CONM1 CONM2 CMASS1 CMASS2 PMASS PARAM"
        ),
        "masses per area or length (NSM, NSM1) or in total (NSML, NSML1): the set that the case control selects": (
            "NSM NSM1 NSML NSML1 NSMADD"
        ),
        "prestress by temperatures and elongations that the case control selects, for the subcase or its STATSUB; "
        "MATTi are refused where it selects a temperature": ("TEMP TEMPD TEMPP1 TEMPRB DEFORM MATT1 MATT2 MATT8 MATT9"),
        "rigid links; RBAR and RBE1 with one point that leads": "RBE1 RBE2 RBAR",
        "averages of points, whose components 123 lead": "RBE3",
        "multipoint constraints: the set that the case control selects": "MPC MPCADD",
        "springs and dampers between the same directions of two points, or of one": (
            "CELAS1 CELAS2 PELAS CBUSH PBUSH CDAMP1 CDAMP2 PDAMP CVISC PVISC"
        ),
        "text": "INCLUDE ENDDATA",
    },
    idle={
        "heat, plasticity and creep of materials, normals of shells": ("MAT4 MAT5 MATS1 CREEP SNORM"),
        "properties of elements that are refused themselves": (
            "PELAST PBUSH1D PBUSHT PGAP PDAMP5 PDAMPT PSOLID PSHEAR PBEAM3 PBEND PFAST PWELD PLSOLID PLPLANE PCOMPS"
        ),
        "loads are yours to state": (
            "FORCE FORCE1 FORCE2 MOMENT MOMENT1 MOMENT2 PLOAD PLOAD1 PLOAD2 PLOAD4 PLOADX1 GRAV ACCEL ACCEL1 RFORCE "
            "RFORCE1 LOAD DLOAD TLOAD1 TLOAD2 RLOAD1 RLOAD2 SLOAD CLOAD LSEQ DAREA DELAY DPHASE TIC QVECT QVOL QHBDY "
            "QBDY1 QBDY2 QBDY3"
        ),
        "solution, results and tables": (
            "MDLPRM EIGRL EIGR EIGB EIGC EIGP FREQ FREQ1 FREQ2 FREQ3 FREQ4 FREQ5 TSTEP TSTEP1 TSTEPNL NLPARM "
            "NLPCI NLSTEP TABDMP1 TABLED1 TABLED2 TABLED3 TABLED4 TABLEM1 TABLEM2 TABLEM3 TABLEM4 TABLES1 TABLEST "
            "TABRND1 TABRNDG RANDPS RANDT1 SET1 SET2 SET3 ECHOON ECHOOFF SUPORT SUPORT1 PLOTEL PLOTEL3 "
            "PLOTEL4 CBARAO PLOTOPT NLCNTL2 GROUP DTI DTABLE"
        ),
        "unknowns without a place; what refers to them is refused": "SPOINT",
        "unknowns kept in a reduction": "ASET ASET1 OMIT OMIT1 QSET QSET1 BSET BSET1 CSET CSET1 USET USET1",
        "optimization": (
            "DESVAR DVPREL1 DVPREL2 DVMREL1 DVMREL2 DVCREL1 DVCREL2 DVGRID DRESP1 DRESP2 DRESP3 DCONSTR DCONADD DLINK "
            "DSCREEN DOPTPRM DEQATN DDVAL TOPVAR"
        ),
        "aerodynamics": (
            "AERO AEROS CAERO1 CAERO2 CAERO3 CAERO4 CAERO5 PAERO1 PAERO2 PAERO3 PAERO4 PAERO5 SPLINE1 SPLINE2 SPLINE3 "
            "SPLINE4 SPLINE5 SPLINE6 SPLINE7 AELIST AEFACT AESURF AESURFS AESTAT AEPARM AELINK AECOMP FLFACT FLUTTER "
            "MKAERO1 MKAERO2 GUST TRIM DIVERG CSSCHD MONPNT1 MONPNT2 MONPNT3 MONDSP1"
        ),
        "heat": "CHBDYE CHBDYG CHBDYP CONV CONVM PCONV PCONVM PHBDY RADBC RADM RADSET TEMPBC VIEW VIEW3D",
    },
    refused={
        "other surfaces and lines": (
            "CQUAD CQUADX CQUADX4 CQUADX8 CTRIAX CTRIAX6 CTRAX3 CTRAX6 CSHEAR CBEAM3 CBEND CPLSTN3 CPLSTN4 CPLSTN6 "
            "CPLSTN8 CPLSTS3 CPLSTS4 CPLSTS6 CPLSTS8 CQUAD1 CQUAD2 CTRIA1 CTRIA2 CTRSHL CRAC2D CCONEAX CTRIM6",
            _FILM,
        ),
        "solids": (
            "CTETRA CHEXA CPENTA CPYRAM CHEXA1 CHEXA2 CIHEX1 CIHEX2 CRAC3D CWEDGE",
            "mesh their walls with film, their edges with beams, or leave them out",
        ),
        "rigid links, splines and couplings": (
            "RBAR1 RROD RTRPLT RTRPLT1 RSPLINE RSSCON RJOINT MPCAX",
            "write them as RBE2, RBE3 or MPC",
        ),
        "springs, gaps and fasteners": (
            "CELAS3 CELAS4 CBUSH1D CBUSH2D CGAP CFAST CWELD CSEAM CINTC",
            "join the points by CBUSH, or merge them",
        ),
        "dampers": (
            "CDAMP3 CDAMP4 CDAMP5",
            "write them as CDAMP1 or CDAMP2",
        ),
        "masses of other kinds": (
            "CMASS3 CMASS4",
            "write them as CONM2",
        ),
        "matrices and superelements": (
            "DMIG DMI DMIJ DMIJI DMIK DMIAX GENEL TF CSUPER CSUPEXT BEGIN EXTRN SEBULK SECONCT SEELT SEQGP SESET "
            "RELEASE",
            "mesh the part with elements",
        ),
        "moved supports": ("SPCD SPCAX SPCOFF SPCOFF1", "hold the points by SPC1, and state their motion in the case"),
        "points other than GRID": ("EPOINT GRIDB GRIDF POINT POINTAX RINGAX RINGFL CYAX CYJOIN", _POINTS),
        "contact and bolts": (
            "BCBODY BCONP BCTADD BCTSET BSURF BSURFS BGADD BGSET BLSEG BFRIC BOLT BOLTFOR BOLTLD BCTPARA BCTPARM",
            _JOIN,
        ),
    },
)
