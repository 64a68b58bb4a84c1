/* The format of what a mechanism is made of: bodies and their frames, joints, couplings, assemblies. */
#include "exchange/json/format/format_rows.h"

static const km_field euler_fields[] = {
    {"order",
     "Axes of the turns in their order, as \"xyz\" or \"zxz\". Each is an axis of the frame that the turns before it gave.",
     STRING, REQUIRED},
    {"angles", "The three angles.", VECTOR, REQUIRED, UNIT(.angle = 1)},
    {0}};
const km_object_format km_format_euler = {"euler", euler_fields};

static const km_field frame_fields[] = {
    {"name", "Name of the frame, unique on its body. \"origin\" is every body's own frame.", STRING, REQUIRED},
    {"T", "Origin of the frame, from the body's frame; in a drawn assembly, in the drawing.", POINT, UNIT(.length = 1),
     UNSTATED("[0, 0, 0]")},
    {"R",
     "Axes of the frame as the columns of a rotation matrix, written by rows. The nearest rotation is taken of one that is "
     "rounded.",
     SHAPE(MATRIX), UNSTATED("no rotation")},
    ORIENTATION,
    ACTIVE,
    {0}};
static const km_object_format frame_format = {"frame", frame_fields};

static const km_field light_fields[] = {{"name", "Name of the light.", STRING},
                                        {"type", "Kind of the light.", STRING},
                                        {"parent", "Frame that carries the light.", SHAPE(PATH)},
                                        {"Ka", "Ambient colour: red, green, blue.", VECTOR},
                                        {"Kd", "Diffuse colour: red, green, blue.", VECTOR},
                                        {"Ks", "Specular colour: red, green, blue.", VECTOR},
                                        ACTIVE,
                                        {0}};
static const km_object_format light_format = {"light", light_fields};

static const km_field fixed_fields[] = {
    {"frames", "Frames of the inertial frame. It always has \"origin\".", OBJECTS(frame_format)},
    {"lights", "Lights that don't move: kept for other programs, no drawing uses them.", OBJECTS(light_format)},
    {0}};
const km_object_format km_format_fixed = {"fixed", fixed_fields};

#define INERTIA NUMBER, UNIT(.mass = 1, .length = 2), UNSTATED("0")
static const km_field inertia_fields[] = {{"Ixx", "Moment about the x axis.", INERTIA},
                                          {"Iyy", "Moment about the y axis.", INERTIA},
                                          {"Izz", "Moment about the z axis.", INERTIA},
                                          {"Ixy", "Entry xy of the inertia matrix: minus the integral of xy.", INERTIA},
                                          {"Iyz", "Entry yz of the inertia matrix: minus the integral of yz.", INERTIA},
                                          {"Izx", "Entry zx of the inertia matrix: minus the integral of zx.", INERTIA},
                                          {0}};
static const km_object_format inertia_format = {"moment_of_inertia", inertia_fields};

static const km_field shape_fields[] = {
    {"mesh", "Mesh file, of a format that `definition` of a body names.", STRING},
    {"scale", "Model's length of a unit of the mesh file: one number, or one for each axis.", SHAPE(COORDINATES),
     UNIT(.length = 1), UNSTATED("1")},
    {"box", "Sides along x, y and z.", VECTOR, UNIT(.length = 1)},
    {"sphere", "Radius.", NUMBER, UNIT(.length = 1)},
    {"cylinder", "[radius, length], along z.", SHAPE(NUMBERS), UNIT(.length = 1)},
    {"capsule", "[radius, length], along z, the length without the caps.", SHAPE(NUMBERS), UNIT(.length = 1)},
    {"T", "Middle of the shape, or origin of the mesh, in the body's frame.", POINT, UNIT(.length = 1),
     UNSTATED("[0, 0, 0]")},
    {"R", "Its axes as the columns of a rotation matrix, written by rows.", SHAPE(MATRIX), UNSTATED("no rotation")},
    ORIENTATION,
    {"color", "Red, green, blue and perhaps opacity, from 0 to 1. Kept.", SHAPE(NUMBERS)},
    {"density", "Density. What has one is weighed, and gives the body its mass.", NUMBER,
     UNIT(.mass = 1, .length = -3)},
    {0}};
static const km_object_format shape_format = {"shape", shape_fields};

static const km_field body_fields[] = {
    {"name", "Name of the body, unique in its assembly. \"fixed\" is the inertial frame.", STRING, REQUIRED},
    {"mass", "Mass of the body.", NUMBER, UNIT(.mass = 1), UNSTATED("0")},
    {"center_of_mass", "Centre of mass, in the body's frame; in a drawn assembly, in the drawing.", POINT,
     UNIT(.length = 1), UNSTATED("[0, 0, 0]")},
    {"moment_of_inertia", "Inertia matrix about the centre of mass, along the body's axes.", OBJECT(inertia_format),
     UNSTATED("0")},
    {"definition",
     "Mesh file, in the body's frame and the model's length unit, and a material file, which is kept and used by no drawing. "
     "A mesh is an OBJ, STL, PLY, OFF, COLLADA (.dae), glTF (.gltf, .glb) or 3DS file, or MuJoCo's .msh, of at most 256 MB "
     "and 2000000 triangles.",
     SHAPE(STRINGS)},
    {"density", "Density of the mesh. Mass, centre of mass and inertia then come from the mesh.", NUMBER,
     UNIT(.mass = 1, .length = -3)},
    {"shapes",
     "What the body looks like, instead of or beside the definition; each is a mesh, box, sphere, cylinder or "
     "capsule.",
     OBJECTS(shape_format)},
    {"frames", "Places on the body: for joints, loads and points to follow.", OBJECTS(frame_format)},
    ACTIVE,
    {0}};
const km_object_format km_format_body = {"body", body_fields};

static const km_field friction_fields[] = {
    {"coefficient", "Coefficient of friction.", NUMBER, UNSTATED("0")},
    {"radius",
     "Radius at which a hinge's journal and collar slide; mean radius of a screw's thread. Without it nothing rubs in a turn.",
     NUMBER, UNIT(.length = 1), UNSTATED("0")},
    {"torque", "Constant friction: a torque of joints that turn, a force of slides. Counts in a simulation.",
     SHAPE(COORDINATES), BY(FORCE), UNSTATED("0")},
    {"stiction_velocity", "Sliding speed below which a simulation counts the joint as sticking.", NUMBER,
     UNIT(.length = 1, .time = -1), UNSTATED("0")},
    {0}};
static const km_object_format friction_format = {"friction", friction_fields};

static const km_field stop_fields[] = {
    {"stiffness", "Stiffness of the stop at a limit.", NUMBER, BY(STIFFNESS), UNSTATED("0")},
    {"damping", "Damping of the stop at a limit.", NUMBER, BY(STIFFNESS), UNIT(.time = 1), UNSTATED("0")},
    {0}};
static const km_object_format stop_format = {"stop", stop_fields};

static const km_field tolerance_fields[] = {
    {"position", "How far the joint's place on each of its bodies may be off, in any direction.", NUMBER,
     UNIT(.length = 1), UNSTATED("0")},
    {"direction", "By which angle its axes on each of its bodies may be off, about any axis.", NUMBER, UNIT(.angle = 1),
     UNSTATED("0")},
    {0}};
static const km_object_format tolerance_format = {"tolerance", tolerance_fields};

static const km_field clearance_fields[] = {
    {"radial", "Play across the axis, from the middle.", NUMBER, UNIT(.length = 1), UNSTATED("0")},
    {"axial", "Play along the axis, from the middle.", NUMBER, UNIT(.length = 1), UNSTATED("0")},
    {"angular", "Angle by which its axes can turn out of the middle, in directions that it constrains.", NUMBER,
     UNIT(.angle = 1), UNSTATED("0")},
    {0}};
static const km_object_format clearance_format = {"clearance", clearance_fields};

static const km_field stiffness_fields[] = {{"force",
                                             "Force per displacement in the directions that the joint constrains.",
                                             NUMBER, UNIT(.force = 1, .length = -1), UNSTATED("rigid")},
                                            {"moment", "Moment per radian about the axes that it constrains.", NUMBER,
                                             UNIT(.force = 1, .length = 1), UNSTATED("rigid")},
                                            {0}};
static const km_object_format stiffness_format = {"stiffness", stiffness_fields};

static const km_field sine_fields[] = {
    {"offset", "Mean value.", NUMBER, BY(COORDINATE), UNSTATED("0")},
    {"amplitude", "Amplitude.", NUMBER, BY(COORDINATE), UNSTATED("0")},
    {"frequency", "Cycles per unit of time.", NUMBER, UNIT(.time = -1), UNSTATED("0")},
    {"phase", "Phase at time 0.", NUMBER, UNIT(.angle = 1), UNSTATED("0")},
    {0}};
static const km_object_format sine_format = {"sine", sine_fields};

static const km_field segment_fields[] = {
    {"duration", "Time that the segment takes.", NUMBER, REQUIRED, UNIT(.time = 1)},
    {"rise", "Change of the value, from rest to rest; negative for a return.", NUMBER, BY(COORDINATE)},
    {"rate", "Rate at the end: the start or the stop of a steady motion.", NUMBER, BY(COORDINATE), UNIT(.time = -1)},
    {"law", "Law of the rise or of the rate: cycloidal, 3-4-5 or modified-trapezoid.", STRING, UNSTATED("cycloidal")},
    {0}};
static const km_object_format segment_format = {"segment", segment_fields};

static const km_field prescribed_fields[] = {
    {"table",
     "Rows [time, value] with increasing times, joined by a cubic spline; before and behind them the motion goes on with the "
     "slope that it has there.",
     SHAPE(ROWS), BY(TABLE)},
    {"polynomial", "Coefficients of a polynomial in time, the constant one first.", SHAPE(NUMBERS), BY(POLYNOMIAL)},
    {"sine", "offset + amplitude sin(2 pi frequency t + phase).", OBJECT(sine_format)},
    {"cosine", "offset + amplitude cos(2 pi t/period + phase), with the `period` beside it.", OBJECT(km_format_cosine)},
    {"segments",
     "Rises, dwells, starts and stops one after another, from rest at time 0. A segment with neither `rise` nor `rate` "
     "goes on as it is: a dwell, or a steady motion.",
     OBJECTS(segment_format)},
    LAW_EXPRESSION,
    {"start", "Value at which the segments begin.", NUMBER, BY(COORDINATE), UNSTATED("the initial displacement")},
    {"period",
     "The table, cosine or segments repeat after this time. Segments that end at another value go on from there.",
     NUMBER, UNIT(.time = 1), UNSTATED("none")},
    {0}};
static const km_object_format prescribed_format = {"prescribed", prescribed_fields};

static const km_field joint_fields[] = {
    {"name", "Name of the joint, unique in its assembly.", STRING, REQUIRED},
    {"type",
     "Rx, Ry, Rz turn about that axis of the parent frame, Tx, Ty, Tz slide along it. revolute is Rz and prismatic is "
     "Tx; the others are rigid, spherical, float, cylindrical, universal, planar and screw.",
     STRING, REQUIRED},
    {"body_frame_pairs", "The frame on the parent and the frame on the child that the joint connects.",
     SHAPE(PATH_PAIR)},
    {"bodies", "Drawn assemblies: the two bodies, parent first.", SHAPE(PATHS)},
    {"at", "Drawn assemblies: the joint's point in the drawing.", POINT, UNIT(.length = 1)},
    {"axis", "Drawn assemblies: the axis of a hinge, the direction of a slide, the normal of a planar joint.", POINT,
     UNSTATED("[0, 0, 1]")},
    {"initial_displacement",
     "Where the assembly starts from, one value for each coordinate. The loops close with the least change of these "
     "values. In a drawn assembly it is the value that the drawn pose has.",
     SHAPE(COORDINATES), BY(COORDINATE), UNSTATED("0")},
    {"initial_velocity",
     "Rate at the start of a simulation. A stated rate is kept; joints without one follow, with the least rates that keep the loops.",
     SHAPE(COORDINATES), BY(COORDINATE), UNIT(.time = -1), UNSTATED("0")},
    {"damping", "Viscous damping in a simulation.", SHAPE(COORDINATES), BY(STIFFNESS), UNIT(.time = 1), UNSTATED("0")},
    {"friction", "Friction in the joint. kma and ksim count the coefficient; mobility and statics leave friction out.",
     OBJECT(friction_format), UNSTATED("none")},
    {"limits",
     "Least and greatest value, for each coordinate. One range [0, angle] on a spherical joint limits the angle by which "
     "it turns. A sweep ends where a joint meets one.",
     SHAPE(RANGES), BY(COORDINATE), UNSTATED("none")},
    {"max_rate", "Largest rate that the joint's drive can give. kredund keeps to it where the path has a speed.",
     SHAPE(COORDINATES), BY(COORDINATE), UNIT(.time = -1), UNSTATED("none")},
    {"max_force", "Largest force or torque that the joint's drive can give. kstatic tells where it takes more.",
     SHAPE(COORDINATES), BY(FORCE), UNSTATED("none")},
    {"armature", "Inertia of the drive's rotor, reflected to the joint's coordinate. Counts in a simulation.",
     SHAPE(COORDINATES), BY(INERTIA), UNSTATED("0")},
    {"stop", "What the limits do in simulations and statics. A sweep ends at a limit in any case.", OBJECT(stop_format)},
    {"tolerance", "Errors of the joint's place on its bodies, for kmob allowance.", OBJECT(tolerance_format),
     UNSTATED("the option --tolerance")},
    {"clearance", "Play of the joint, for kmob allowance; other analyses take it as 0.", OBJECT(clearance_format),
     UNSTATED("the option --clearance")},
    {"stiffness", "Stiffness of the joint with its bodies against what it constrains, for kmob allowance.",
     OBJECT(stiffness_format), UNSTATED("rigid")},
    {"prescribed", "The joint's motion over time in a simulation, by one law.", OBJECT(prescribed_format)},
    {"pitch", "Travel of a screw in one turn. A screw needs it, no other joint may have it.", NUMBER,
     UNIT(.length = 1)},
    ACTIVE,
    {0}};
const km_object_format km_format_joint = {"joint", joint_fields};

static const km_field coupling_fields[] = {
    {"name", "Name of the coupling.", STRING, REQUIRED},
    {"joints", "The coupled coordinates, by their joints.", SHAPE(PATHS), REQUIRED},
    {"ratios", "One number r for each joint: the sum of r times the coordinate is constant, angles in radians.",
     SHAPE(NUMBERS), BY(RATIO)},
    {"constant", "Value of that sum.", NUMBER, UNSTATED("that of the initial displacements")},
    {"polynomial",
     "Instead of ratios, of two joints: the first coordinate as a polynomial in the second one, the constant coefficient "
     "first; angles in radians.",
     SHAPE(NUMBERS), BY(FOLLOWING)},
    ACTIVE,
    {0}};
const km_object_format km_format_coupling = {"coupling", coupling_fields};

static const km_field assembly_fields[] = {
    {"name", "Name of the assembly.", STRING, REQUIRED},
    ACTIVE,
    {"drawn",
     "\"assembled\": all bodies stand in one common pose, and joints, frames and centres of mass are given by their "
     "points in that drawing.",
     STRING, UNSTATED("frames on bodies")},
    {"bodies", "The parts.", OBJECTS(km_format_body)},
    {"joints", "What connects them, to each other and to \"fixed\".", OBJECTS(km_format_joint)},
    {"struts", "Springs, gas springs and cylinders between two points.", OBJECTS(km_format_strut)},
    {"couplings", "Gears, belts and other constraints between coordinates.", OBJECTS(km_format_coupling)},
    {"force_modules", "Force laws between frames or in joints.", OBJECTS(km_format_module)},
    {"lights", "Lights for other programs: kept, no drawing uses them.", OBJECTS(light_format)},
    {"assemblies", "Assemblies inside this one.", OBJECTS(km_format_assembly)},
    {0}};
const km_object_format km_format_assembly = {"assembly", assembly_fields};
