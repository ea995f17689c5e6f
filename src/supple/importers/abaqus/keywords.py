"""Keywords of Abaqus and CalculiX by their treatment; names without blanks."""

from __future__ import annotations

PASSED_OVER = frozenset((
    "ACOUSTICFLOWVELOCITY", "ADAPTIVEMESH", "AMPLITUDE", "ASSEMBLY", "BASELINECORRECTION",
    "BULKVISCOSITY", "CAPCREEP", "CAPHARDENING", "CAPPLASTICITY", "CFLUX", "CHANGECONTACTTYPE",
    "CHANGEFRICTION", "CHANGEMATERIAL", "CHANGESOLIDSECTION", "CHANGESURFACEBEHAVIOR", "CLEARANCE",
    "CLOAD", "CONCRETE", "CONDUCTIVITY", "CONSTRAINT", "CONTACT", "CONTACTCLEARANCE", "CONTACTCONTROLS",
    "CONTACTCONTROLSASSIGNMENT", "CONTACTDAMPING", "CONTACTEXCLUSIONS", "CONTACTFILE",
    "CONTACTFORMULATION", "CONTACTINCLUSIONS", "CONTACTINITIALIZATIONASSIGNMENT",
    "CONTACTINITIALIZATIONDATA", "CONTACTINTERFERENCE", "CONTACTOUTPUT", "CONTACTPAIR", "CONTACTPRINT",
    "CONTACTPROPERTYASSIGNMENT", "CONTROLS", "CORRELATION", "CREEP", "CYCLIC", "CYCLICHARDENING",
    "DAMAGEEVOLUTION", "DAMAGEINITIATION", "DAMAGESTABILIZATION", "DAMPING", "DATUM", "DEFLECTION",
    "DEPVAR", "DESIGNRESPONSE", "DESIGNVARIABLES", "DFLUX", "DISTRIBUTIONTABLE", "DLOAD", "DRUCKERPRAGER",
    "DRUCKERPRAGERHARDENING", "DSLOAD", "ELECTRICALCONDUCTIVITY", "ELEMENTMATRIXOUTPUT", "ELEMENTOUTPUT",
    "ELFILE", "ELOUTPUT", "ELPRINT", "ENDASSEMBLY", "ENDINSTANCE", "ENDPART", "ENDSTEP", "ENERGYFILE",
    "ENERGYOUTPUT", "ENERGYPRINT", "EOSCOMPACTION", "EXPANSION", "FAILURERATIOS", "FIELD", "FILEFORMAT",
    "FILEOUTPUT", "FILM", "FILMPROPERTY", "FILTER", "FLUIDCONSTANTS", "FRICTION", "GAPCONDUCTANCE",
    "GAPHEATGENERATION", "GAPRADIATION", "GASKETCONTACTAREA", "GLOBALDAMPING", "HEADING", "HEATCAP",
    "INELASTICHEATFRACTION", "INITIALCONDITIONS", "INITIALSTRAININCREASE", "INSTANCE", "LATENTHEAT",
    "LOADCASE", "MAGNETICPERMEABILITY", "MATERIAL", "MODALDAMPING", "MOHRCOULOMB", "MOHRCOULOMBHARDENING",
    "MONITOR", "NETWORKMPC", "NODEFILE", "NODEOUTPUT", "NODEPRINT", "OUTPUT", "PARAMETER", "PART",
    "PHYSICALCONSTANTS", "PLASTIC", "POTENTIAL", "PRE-TENSIONSECTION", "PREPRINT", "PRESSURESTRESS",
    "PRINT", "PSDDEFINITION", "RADIATE", "RATEDEPENDENT", "RESTART", "SECTIONCONTROLS", "SECTIONFILE",
    "SECTIONPRINT", "SOLUTIONTECHNIQUE", "SPECIFICGASCONSTANT", "SPECIFICHEAT", "SPECTRUM", "STATIC",
    "STEP", "SUBMODEL", "SURFACEBEHAVIOR", "SURFACEINTERACTION", "SURFACEPROPERTY",
    "SURFACEPROPERTYASSIGNMENT", "SURFACESECTION", "SWELLING", "SYSTEMUNITS", "TEMPERATURE",
    "TENSILEFAILURE", "TIMEPOINTS", "UNITS", "USEROUTPUTVARIABLES", "VALUESATINFINITY", "VIEWFACTOR",
    "VISCO", "VISCOELASTIC", "VISCOUS",
))  # fmt: skip
"""Keywords without effect on mass, stiffness and connections of an elastic body."""

LEFT_OUT = {
    "BEAMADDEDINERTIA": "mass of beams is missing",
    "BEAMSECTIONOFFSET": "beams have no offset from their nodes",
    "CONNECTORSECTION": "parts joined by a connector are free",
    "CYCLICSYMMETRYMODEL": "the body is one sector, and its two cuts are free",
    "COHESIVESECTION": "parts joined by the cohesive layer are free",
    "DISTRIBUTION": "values of single elements or nodes are not read",
    "ELASTICFOUNDATION": "stiffness to the ground is missing; make it forces of the machine",
    "EMBEDDEDELEMENT": "embedded elements are not tied to their host",
    "FASTENER": "parts joined by it are free",
    "FOUNDATION": "stiffness to the ground is missing; make it forces of the machine",
    "GAP": "a closed gap does not connect parts",
    "GASKETSECTION": "parts joined by the gasket are free",
    "HOURGLASSSTIFFNESS": "elements have full integration instead",
    "IMPERFECTION": "nodes are at the positions of the mesh",
    "JOINT": "parts joined by it are free",
    "MATRIXASSEMBLE": "import the matrices instead",
    "MATRIXINPUT": "import the matrices instead",
    "MODELCHANGE": "elements that it removes are present",
    "NODALENERGYRATE": "a value of the material is missing",
    "NODALTHICKNESS": "beams and plane elements have the section of their elements",
    "NONSTRUCTURALMASS": "mass is missing",
    "NORMAL": "normals of shells and beams are those of their elements",
    "REBAR": "stiffness and mass of the bars are missing",
    "REBARLAYER": "stiffness and mass of the bars are missing",
    "SHELLTOSOLIDCOUPLING": "shells and solids are not joined there",
    "SUBSTRUCTUREPROPERTY": "the substructure is missing; import its matrices",
    "TRANSVERSESHEARSTIFFNESS": "the transverse shear stiffness is that of the material",
    "USERELEMENT": "its elements are missing; import their matrices",
    "USERSECTION": "its elements are missing; import their matrices",
}
"""Keywords that would change the body, and the consequence of omitting them."""

LEFT_OUT_OPTIONS = {
    ("RIGIDBODY", "DENSITY"): "mass of its rigid elements is missing",
    ("SHELLGENERALSECTION", "BENDINGONLY"): "the wall has membrane stiffness as well",
    ("SHELLGENERALSECTION", "MEMBRANEONLY"): "the wall has bending stiffness as well",
    ("SHELLGENERALSECTION", "SMEARALLLAYERS"): "the plies have the order of the file",
}
"""Options of keywords that are read which would change the body, and the consequence of omitting them."""
