/* The format of what pushes: force modules and struts. */
#include "exchange/json/format/format_rows.h"

static const km_field port_fields[] = {
    {"type", "\"joint\" or \"frame\".", STRING, UNSTATED("by the other keys")},
    {"joint", "The joint, of a port of type joint.", SHAPE(PATH)},
    {"body_frame_pair", "The two frames, of a port of type frame: parent and child.", SHAPE(PATH_PAIR)},
    {"distance_type", "How the way between two frames is measured, instead of the module's own key.", STRING,
     UNSTATED("the module's")},
    {"frame", "Instead of two frames, of an input: the one frame whose motion is measured.", SHAPE(PATH)},
    {"component",
     "Part of the frame's motion: x, y or z of its origin, or wx, wy or wz of its angular velocity or acceleration.",
     STRING},
    {"axes", "Axes of the component: fixed (inertial) or body (the frame's own).", STRING, UNSTATED("fixed")},
    {"weight", "Factor of this input in the sum of all inputs.", NUMBER, UNSTATED("1")},
    {0}};
static const km_object_format port_format = {"force_module_port", port_fields};

static const km_field tire_fields[] = {
    {"unloaded_radius", "Radius of the tyre without load.", NUMBER, UNIT(.length = 1)},
    {"vertical_stiffness", "Vertical stiffness.", NUMBER, UNIT(.force = 1, .length = -1)},
    {"vertical_damping", "Vertical damping.", NUMBER, UNIT(.force = 1, .time = 1, .length = -1)},
    {"rolling_resistance", "Distance by which the vertical force acts ahead of the centre.", NUMBER, UNIT(.length = 1)},
    {"width", "Width of the tyre.", NUMBER, UNIT(.length = 1)},
    {"longitudinal_stiffness", "Longitudinal force for each unit of slip.", NUMBER, UNIT(.force = 1)},
    {"lateral_stiffness", "Lateral force for each unit of the tangent of the slip angle.", NUMBER, UNIT(.force = 1)},
    {"friction_peak", "Greatest coefficient of friction.", NUMBER},
    {"friction_sliding", "Coefficient of friction where the tyre slides.", NUMBER},
    {"relaxation_length_x", "Length over which the longitudinal slip builds up.", NUMBER, UNIT(.length = 1)},
    {"relaxation_length_y", "Length over which the lateral slip builds up.", NUMBER, UNIT(.length = 1)},
    {0}};
static const km_object_format tire_format = {"tire", tire_fields};

static const km_field contact_fields[] = {
    {"shape",
     "What touches: \"point-plane\" (the child's origin, or a ball about it, on the parent's plane z = 0), "
     "\"circle-line\" (a circle about the child's origin on the parent's line y = 0), \"circle-circle\" (about the "
     "origins of both frames, normal to the parent's z axis) or \"circle-in-circle\" (the child's circle inside the parent's).",
     STRING, REQUIRED},
    {"radius", "Radius of the child's circle or ball.", NUMBER, UNIT(.length = 1), UNSTATED("0")},
    {"parent_radius", "Radius of the parent's circle, of circle-circle and circle-in-circle.", NUMBER,
     UNIT(.length = 1)},
    {"stiffness", "Normal force over the penetration; with an exponent, at the reference depth.", NUMBER, REQUIRED,
     UNIT(.force = 1, .length = -1)},
    {"exponent", "Power of the penetration in the normal force: 1, or 1.5 of round bodies (Hertz).", NUMBER,
     UNSTATED("1")},
    {"reference_depth", "Penetration at which the stiffness is stated, needed beside an exponent.", NUMBER,
     UNIT(.length = 1)},
    {"dissipation", "Part of the normal force for each unit of the penetration's rate.", NUMBER,
     UNIT(.time = 1, .length = -1), UNSTATED("0")},
    {"friction", "Coefficient of friction.", NUMBER, UNSTATED("0")},
    {"slip_speed", "Speed below which the friction decreases to 0.", NUMBER, UNIT(.length = 1, .time = -1),
     UNSTATED("a thousandth of the characteristic length per second")},
    {0}};
static const km_object_format contact_format = {"contact", contact_fields};

static const km_field cosine_fields[] = {{"offset", "Mean value.", NUMBER, BY(LAW_VALUE), UNSTATED("0")},
                                         {"amplitude", "Amplitude.", NUMBER, BY(LAW_VALUE), UNSTATED("0")},
                                         {"phase", "Phase at x = 0.", NUMBER, UNIT(.angle = 1), UNSTATED("0")},
                                         {0}};
const km_object_format km_format_cosine = {"cosine", cosine_fields};

static const km_field step_fields[] = {
    {"at", "x at which the step begins.", NUMBER, BY(LAW_X), UNSTATED("0")},
    {"width", "Change of x over which the value changes, by the 3-4-5 polynomial; 0 for a jump.", NUMBER, BY(LAW_X),
     UNSTATED("0")},
    {"from", "Value before.", NUMBER, BY(LAW_VALUE), UNSTATED("0")},
    {"to", "Value after.", NUMBER, BY(LAW_VALUE), UNSTATED("0")},
    {0}};
const km_object_format km_format_step = {"step", step_fields};

static const km_field scale_fields[] = {
    LAW_OVER("t"),
    LAW_PERIOD,
    {"table", "Rows [x, factor]; before and behind them the factor stays, if there is no period.", SHAPE(ROWS),
     BY(LAW_ROWS)},
    LAW_INTERPOLATION,
    LAW_COSINE,
    LAW_STEP,
    {"polynomial", "The factor as a polynomial in x, the constant coefficient first.", SHAPE(NUMBERS), BY(LAW_SERIES)},
    LAW_EXPRESSION,
    {0}};
const km_object_format km_format_scale = {"scale", scale_fields};

static const km_field module_fields[] = {
    {"name", "Name of the force module.", STRING, REQUIRED},
    {"type",
     "stiffness is a force from a displacement, damping and friction from a rate, motor from time, pid a controller, "
     "fiala_tire a tyre, contact a contact with friction; `variable` states another variable. Statics counts a stiffness of displacement; the others "
     "count in a simulation.",
     STRING, REQUIRED},
    {"input", "Where the variable is measured.", OBJECT(port_format), UNSTATED("the output")},
    {"inputs", "Several inputs instead of one: the variable is the sum of them, each times its weight.",
     OBJECTS(port_format)},
    {"output", "Where the force acts.", OBJECT(port_format), UNSTATED("the input")},
    {"variable",
     "What the law or the controller reads of the input: its displacement, velocity or acceleration; of a motor, time.",
     STRING, UNSTATED("by the type")},
    {"saturation",
     "Least and greatest force. A controller doesn't integrate an error that only pushes further beyond a bound.",
     SHAPE(RANGE), BY(MODULE_FORCE), UNSTATED("none")},
    {"distance_type",
     "How the way between two frames is measured: euclid is the distance; Tx, Ty or Tz the part along that axis of the "
     "parent frame; Rx, Ry or Rz the child's angle about it, from -pi to pi.",
     STRING, UNSTATED("euclid")},
    {"knot_points", "Increasing values of the variable at which one polynomial ends and the next begins.",
     SHAPE(NUMBERS), BY(KNOTS), UNSTATED("[]")},
    {"coefficients",
     "One polynomial in the variable more than there are knots, the constant coefficient first. The value is the force "
     "along the joint or the way, positive where it pushes it to grow; angles inside are in radians.",
     SHAPE(ROWS), BY(PIECES)},
    LAW_OVER("the input"),
    LAW_PERIOD,
    {"table",
     "The force as rows [x, force]; before and behind them it stays, if there is no period. x is what `over` names; "
     "without it the variable, of a motor the time.",
     SHAPE(ROWS), BY(LAW_TABLE)},
    LAW_INTERPOLATION,
    LAW_COSINE,
    LAW_STEP,
    {"polynomial", "The force as a polynomial in time, or in what `over` names, the constant coefficient first.",
     SHAPE(NUMBERS), BY(LAW_POLYNOMIAL)},
    LAW_EXPRESSION,
    {"reference",
     "Value that a pid holds the variable at: a number, a polynomial over time (the constant coefficient first), rows "
     "[time, value] that are joined by lines, or an expression of t.",
     SHAPE(TIME_LAW), BY(REFERENCE), UNSTATED("0")},
    {"kp", "Force of a pid for each unit of the error, which is reference minus variable.", NUMBER, BY(GAIN),
     UNSTATED("0")},
    {"ki", "Force of a pid for each unit of the error's integral over time.", NUMBER, BY(GAIN), UNIT(.time = -1),
     UNSTATED("0")},
    {"kd", "Force of a pid for each unit of the error's rate.", NUMBER, BY(GAIN), UNIT(.time = 1), UNSTATED("0")},
    {"tire",
     "Numbers of a fiala_tire, whose parent frame is the road (its z axis the normal) and whose child frame is the wheel's (its y axis the axle).",
     OBJECT(tire_format)},
    {"contact", "Numbers of a contact, which acts between the two frames of the output.", OBJECT(contact_format)},
    ACTIVE,
    {0}};
const km_object_format km_format_module = {"force_module", module_fields};

static const km_field spring_fields[] = {
    {"stiffness", "Force for each unit of length.", NUMBER, REQUIRED, UNIT(.force = 1, .length = -1)},
    {"free_length", "Length at which the spring has no force.", NUMBER, REQUIRED, UNIT(.length = 1)},
    {0}};
static const km_object_format spring_format = {"spring", spring_fields};

static const km_field gas_spring_fields[] = {
    {"force", "Force that pushes the ends apart, at the length `length`.", NUMBER, REQUIRED, UNIT(.force = 1)},
    {"rate", "Stiffness: force more for each unit of length that it is shorter.", NUMBER,
     UNIT(.force = 1, .length = -1), UNSTATED("0")},
    {"length", "Length at which `force` is stated. Needed beside `rate`.", NUMBER, UNIT(.length = 1)},
    {0}};
static const km_object_format gas_spring_format = {"gas_spring", gas_spring_fields};

static const km_field strut_fields[] = {
    {"name", "Name of the strut, and of the joint that is its length.", STRING, REQUIRED},
    {"from", "Frame at one end.", SHAPE(PATH), REQUIRED},
    {"to", "Frame at the other end.", SHAPE(PATH), REQUIRED},
    {"planar", "True: a hinge at either end. False: a ball at `from` and a universal joint at `to`.", BOOLEAN,
     UNSTATED("false")},
    {"spring", "A coil spring: it pushes the ends apart with stiffness (free_length - length).", OBJECT(spring_format)},
    {"gas_spring", "A gas spring: with its own `length` l it pushes the ends apart with force + rate (l - length).",
     OBJECT(gas_spring_format)},
    {"cylinder", "Whether it is an actuator.", BOOLEAN, UNSTATED("false")},
    {"limits", "Least and greatest length.", SHAPE(RANGE), UNIT(.length = 1), UNSTATED("none")},
    {"damping", "Viscous damping in a simulation.", NUMBER, UNIT(.force = 1, .time = 1, .length = -1), UNSTATED("0")},
    ACTIVE,
    {0}};
const km_object_format km_format_strut = {"strut", strut_fields};
