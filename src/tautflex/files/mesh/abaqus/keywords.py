"""The keywords of Abaqus and CalculiX: read, without effect, refused."""

from __future__ import annotations

from tautflex.files.mesh.words import Words

_JOIN = "join the nodes by stiff beams, or merge them"
_LIST = "write nodes, elements and sets out, as the preprocessor's flat input file does"

WORDS = Words(
    "keyword",
    read={
        "nodes and sets": "NODE NSET ELSET",
        "films, cables and beams by their type": "ELEMENT",
        "parts, placed as often as there are instances": "PART END_PART ASSEMBLY END_ASSEMBLY INSTANCE END_INSTANCE",
        "sections of films; laminates and stiffnesses need theirs stated": (
            "MEMBRANE_SECTION SHELL_SECTION SHELL_GENERAL_SECTION"
        ),
        "sections of cables": "SOLID_SECTION",
        "sections of beams and their direction: RECT, CIRC, PIPE, THICK PIPE, GENERAL, BOX and I where they are "
        "symmetric; others need theirs stated": "BEAM_SECTION BEAM_GENERAL_SECTION",
        "isotropic materials; others need theirs stated; expansion where there are temperatures": (
            "MATERIAL ELASTIC DENSITY EXPANSION NO_COMPRESSION NO_TENSION"
        ),
        "point masses and principal inertias": "MASS ROTARY_INERTIA",
        "multipoint constraints BEAM, TIE and PIN, and equations": "MPC EQUATION",
        "rigid bodies, and couplings; surfaces of nodes, of films or their edges": (
            "RIGID_BODY KINEMATIC_COUPLING COUPLING KINEMATIC DISTRIBUTING SURFACE"
        ),
        "nodes that lie on film (M3D3, M3D4, M3D6) move with it, those at nodes as these": "TIE EMBEDDED_ELEMENT",
        "hinges at ends of beams": "RELEASE",
        "stiffness of SPRINGA, SPRING1 and SPRING2, damping of DASHPOTA, DASHPOT1 and DASHPOT2": "SPRING DASHPOT",
        "directions of supports": "TRANSFORM",
        "supports and elements of the chosen step, OP=NEW included": "BOUNDARY STEP END_STEP FREQUENCY MODEL_CHANGE",
        "mass per area or length, or in total, of the elements of a set": "NONSTRUCTURAL_MASS",
        "initial stress of films, cables and beams; prestress by temperatures of the chosen step": (
            "INITIAL_CONDITIONS TEMPERATURE"
        ),
        "text": "INCLUDE HEADING",
    },
    idle={
        "behaviour of materials beside elasticity and density, directions of isotropic ones, shear of shells": (
            "PLASTIC DAMPING HYPERELASTIC VISCOELASTIC CONDUCTIVITY SPECIFIC_HEAT DEPVAR USER_MATERIAL "
            "ORIENTATION HOURGLASS_STIFFNESS TRANSVERSE_SHEAR_STIFFNESS SECTION_POINTS BEAM_SECTION_GENERATE CONSTANTS "
            "FAIL_STRESS FAIL_STRAIN"
        ),
        "loads and histories are yours to state": (
            "CLOAD DLOAD DSLOAD FIELD AMPLITUDE CFLUX DFLUX FILM RADIATE PRE-TENSION_SECTION BASE_MOTION "
            "BASELINE_CORRECTION PSD-DEFINITION SPECTRUM"
        ),
        "steps and their control": (
            "STATIC BUCKLE DYNAMIC MODAL_DYNAMIC STEADY_STATE_DYNAMICS RANDOM_RESPONSE RESPONSE_SPECTRUM "
            "COMPLEX_FREQUENCY HEAT_TRANSFER COUPLED_TEMPERATURE-DISPLACEMENT UNCOUPLED_TEMPERATURE-DISPLACEMENT VISCO "
            "NO_ANALYSIS CONTROLS MODAL_DAMPING GLOBAL_DAMPING SELECT_EIGENMODES TIME_POINTS SOLUTION_TECHNIQUE SOLVER "
            "STEADY_STATE SENSITIVITY FIXED_MASS_SCALING VARIABLE_MASS_SCALING"
        ),
        "results": (
            "OUTPUT NODE_OUTPUT ELEMENT_OUTPUT ENERGY_OUTPUT CONTACT_OUTPUT MODAL_OUTPUT NODE_PRINT EL_PRINT NODE_FILE "
            "EL_FILE CONTACT_PRINT CONTACT_FILE ENERGY_PRINT ENERGY_FILE MODAL_PRINT MODAL_FILE SECTION_PRINT "
            "SECTION_FILE MONITOR PREPRINT PRINT RESTART FILE_FORMAT FILE_OUTPUT INTEGRATED_OUTPUT "
            "INTEGRATED_OUTPUT_SECTION INCREMENTATION_OUTPUT DIAGNOSTICS FILTER PHYSICAL_CONSTANTS"
        ),
        "contact properties": "SURFACE_INTERACTION SURFACE_BEHAVIOR FRICTION",
    },
    refused={
        "nodes and elements that are generated, turned or stretched": (
            "NGEN NFILL NCOPY NMAP ELGEN ELCOPY SYSTEM NORMAL IMPERFECTION PARAMETER SYMMETRIC_MODEL_GENERATION",
            _LIST,
        ),
        "links and constraints between nodes": (
            "DISTRIBUTING_COUPLING FASTENER FASTENER_PROPERTY SHELL_TO_SOLID_COUPLING "
            "DISPLAY_BODY CYCLIC_SYMMETRY_MODEL NETWORK_MPC SUBMODEL",
            _JOIN,
        ),
        "connectors, joints and gaps": (
            "CONNECTOR_SECTION CONNECTOR_BEHAVIOR CONNECTOR_ELASTICITY CONNECTOR_DAMPING "
            "CONNECTOR_MOTION CONNECTOR_STOP CONNECTOR_LOAD JOINT JOINTED_MATERIAL GAP",
            _JOIN,
        ),
        "contact": (
            "CONTACT CONTACT_PAIR CONTACT_INCLUSIONS CONTACT_PROPERTY_ASSIGNMENT CONTACT_CONTROLS "
            "CONTACT_INITIALIZATION_DATA CONTACT_INITIALIZATION_ASSIGNMENT CLEARANCE CONTACT_INTERFERENCE",
            _JOIN,
        ),
        "initial states": (
            "INITIAL_STRAIN_INCREASE",
            "state the prestress as membrane_stress, cable_tension, or in the case",
        ),
        "substructures and matrices": (
            "SUBSTRUCTURE_PROPERTY SUBSTRUCTURE_GENERATE MATRIX_INPUT MATRIX_ASSEMBLE USER_ELEMENT UEL_PROPERTY",
            "mesh the part with elements",
        ),
    },
)
