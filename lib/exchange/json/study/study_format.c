/* Format table of path studies. */
#include "exchange/json/study/study_reader.h"

#include "exchange/json/format/format_rows.h"

#define ANGLE  UNIT(.angle = 1)
#define LENGTH UNIT(.length = 1)

static const km_field pose_fields[] = {
    {"T", "Place of the effector in the inertial frame.", VECTOR, LENGTH, UNSTATED("that of the effector at q0")},
    {"R", "Its rotation.", SHAPE(MATRIX), UNSTATED("that of the effector at q0")},
    {0}};
static const km_object_format pose_format = {"pose", pose_fields};

static const km_field point_fields[] = {
    {"T", "Place of the effector in the inertial frame.", VECTOR, REQUIRED, LENGTH},
    {"R", "Its rotation.", SHAPE(MATRIX), UNSTATED("that of the point before")},
    {"time", "When it is there, counted from the segment's begin. All points have one, or none.", NUMBER,
     UNIT(.time = 1), UNSTATED("by the speeds")},
    {0}};
static const km_object_format point_format = {"point", point_fields};

static const km_field segment_fields[] = {
    {"type", "\"line\", \"arc\", \"circle\", \"helix\", \"weave\" or \"spline\".", STRING, REQUIRED},
    {"steps", "Number of intervals.", NUMBER, UNSTATED("100")},
    {"to", "Where a line or a weave leads, in the inertial frame.", VECTOR, LENGTH, UNSTATED("a line stays in place")},
    {"R_to", "Rotation of the effector at the end, towards which it turns about one axis at a constant rate.",
     SHAPE(MATRIX), UNSTATED("it doesn't turn")},
    {"center", "A point of the axis of an arc, a circle or a helix.", VECTOR, LENGTH},
    {"axis", "Direction of that axis.", VECTOR},
    {"angle", "How far an arc or a helix goes round, right-handed.", NUMBER, ANGLE, UNSTATED("of a circle a turn")},
    {"pitch", "Travel of a helix along its axis in a turn.", NUMBER, LENGTH},
    {"turn", "Whether the effector turns with the arc.", BOOLEAN, UNSTATED("false")},
    {"points", "The poses that a spline goes through, from where the path stands.", OBJECTS(point_format)},
    {"amplitude", "How far a weave swings to either side.", NUMBER, LENGTH},
    {"waves", "How many swings there and back a weave makes.", NUMBER},
    {"sideways", "Direction of the swings.", VECTOR},
    {0}};
static const km_object_format segment_format = {"segment", segment_fields};

static const km_field path_fields[] = {
    {"start", "Where the path begins.", OBJECT(pose_format), UNSTATED("at the effector's pose")},
    {"segments", "The pieces of the path, one after the other.", OBJECTS(segment_format)},
    {"csv",
     "A file of poses instead, seen from the study's folder: x, y, z and a quaternion w, x, y, z or a rotation "
     "vector rx, ry, rz, and if it likes times t; a header may name the columns.",
     STRING},
    {"speed", "Speed of the effector's origin.", NUMBER, UNIT(.length = 1, .time = -1),
     UNSTATED("a characteristic length a second")},
    {"turn_speed", "Speed at which the effector turns.", NUMBER, UNIT(.angle = 1, .time = -1),
     UNSTATED("turns take no time but where the origin stands still")},
    {0}};
const km_object_format km_format_path = {"study_path", path_fields};

static const km_field method_fields[] = {
    {"method", "The method's word.", STRING, REQUIRED},
    {"branches", "lookahead: ways to go on at each level, an odd number.", NUMBER, UNSTATED("3")},
    {"levels", "lookahead: how many levels it looks ahead.", NUMBER, UNSTATED("3")},
    {"angle", "lookahead: between branches, in degrees; gradient, dp, global: the largest turn away from greedy.",
     NUMBER, UNSTATED("30")},
    {"stride", "lookahead: samples of a level; dp: of a stage.", NUMBER, UNSTATED("1/12 of the path; of dp 1/24")},
    {"value", "lookahead: what a leaf counts, the \"min\" or the \"sum\" of the objective over its samples.", STRING,
     UNSTATED("min")},
    {"joints", "fixed: labels of the joints that are held.", SHAPE(STRINGS),
     UNSTATED("those that pivoting leaves free")},
    {"joint", "fixed: the same of one joint.", STRING},
    {"damping", "dls: damping at singular poses.", NUMBER, UNSTATED("0.05")},
    {"below", "dls: smallest singular value below which it is damped.", NUMBER, UNSTATED("0.1")},
    {"gain", "gradient: turn for each unit of the objective's slope.", NUMBER, UNSTATED("2")},
    {"spacing", "dp: of the poses along a self-motion, in radians.", NUMBER, UNSTATED("by what the turns can reach")},
    {"knots", "global: turns along the path.", NUMBER, UNSTATED("12")},
    {"evaluations", "global: most tracks that are tried.", NUMBER, UNSTATED("400")},
    {0}};
const km_object_format km_format_method = {"method", method_fields};

static const km_field study_fields[] = {
    {"model", "The arm's model file, seen from the study's folder.", STRING},
    {"effector", "The frame that follows the path, \"body/frame\" or its path.", SHAPE(PATH)},
    {"coordinates", "Labels of the joints in the order of `q0` and `rates`.", SHAPE(STRINGS),
     UNSTATED("from the base out")},
    {"q0", "The pose to start from.", SHAPE(NUMBERS), BY(COORDINATE),
     UNSTATED("the model's, or one by inverse kinematics")},
    {"path", "What the effector follows.", OBJECT(km_format_path)},
    {"task", "\"pose\", \"position\", or \"axis\": position and direction of the z axis.", STRING, UNSTATED("pose")},
    {"methods",
     "How it follows: \"greedy\" (or \"pinv\"), \"lookahead\", \"fixed\", \"dls\", \"gradient\", \"dp\", "
     "\"global\", or these with settings.",
     SHAPE(METHODS), .object = &km_format_method, UNSTATED("greedy")},
    {"objective",
     "What is made large: \"path-control\", \"manipulability\", \"singular-value\", \"limit-distance\", "
     "\"joint-travel\", \"rate-margin\" or \"clearance\" of bodies; or least, from inverse dynamics: \"effort\" (squared joint forces), "
     "\"relative-effort\" (over max_force), \"energy\" (|power| of the joints) or \"positive-work\"; or weights {\"limit-distance\": 1, …}.",
     SHAPE(ANY), UNSTATED("path-control")},
    {"rates", "Largest rate of each joint.", SHAPE(NUMBERS), BY(COORDINATE), UNIT(.time = -1),
     UNSTATED("the model's max_rate, where the path has a speed")},
    {"source", "What the study is about, for people.", SHAPE(ANY)},
    {0}};
const km_object_format km_format_study = {"study", study_fields};
