/* The format of a model file as a whole: its parameters, assemblies and analysis. */
#include "exchange/json/format/format_rows.h"

#include <string.h>

static const km_field units_fields[] = {
    {"angle", "radians (rad) or degrees (deg).", STRING, UNSTATED("radians")},
    {"length", "meters (m), millimeters (mm), centimeters (cm) or inches (in).", STRING, UNSTATED("meters")},
    {"mass", "kilograms (kg), grams (g) or pounds (lb).", STRING, UNSTATED("kilograms")},
    {"time", "seconds (s) or milliseconds (ms).", STRING, UNSTATED("seconds")},
    {"force", "newtons (N) or pounds-force (lbf).", STRING, UNSTATED("newtons")},
    {0}};
static const km_object_format units_format = {"units", units_fields};

static const km_field simulation_fields[] = {
    {"integration_type",
     "Integration method: adams (also ode113) or bdf (also ode15s), unless ksim run --integrator says another. Other names are kept, with a note.",
     STRING},
    {"time_span", "Duration.", NUMBER, UNIT(.time = 1)},
    {"time_step", "Time between two rows of results.", NUMBER, UNIT(.time = 1)},
    {"relative_error", "Relative error allowed in a step.", NUMBER},
    {"absolute_error", "Absolute error allowed in a step.", NUMBER},
    {0}};
static const km_object_format simulation_format = {"simulation", simulation_fields};

static const km_field parameters_fields[] = {
    {"version", "Version of the format: \"0.2\", \"1.0\", \"1.1\" or \"1.2\".", STRING, UNSTATED("the newest")},
    {"units", "Units of the file.", OBJECT(units_format), UNSTATED("rad, m, kg, s, N")},
    {"gravity", "Acceleration of gravity, in the inertial frame.", POINT, UNIT(.length = 1, .time = -2),
     UNSTATED("[0, 0, 0]")},
    {"include_dir", "Folder, or list of folders, in which meshes are looked for. They count from the file's folder.",
     SHAPE(STRINGS), UNSTATED("the file's folder")},
    {"closure_tolerance",
     "Largest error that closed loops may keep, relative to the size of the loop. Rounded data (CAD) may need more than "
     "the default.",
     NUMBER, UNSTATED("1e-9")},
    {"simulation", "Settings of ksim, which its options override.", OBJECT(simulation_format)},
    {"characteristic_length", "Length by which lengths are divided where they are compared with angles.", NUMBER,
     UNIT(.length = 1), UNSTATED("the longest link")},
    {0}};
const km_object_format km_format_parameters = {"model_parameters", parameters_fields};

static const km_field direction_fields[] = {
    {"joint", "Joint whose motion tells the direction.", SHAPE(PATH), REQUIRED},
    {"sign", "1 where the joint's value grows at first, -1 where it falls.", NUMBER, REQUIRED},
    {0}};
static const km_object_format direction_format = {"sweep_direction", direction_fields};

static const km_field sweep_fields[] = {
    {"joint", "The driver.", SHAPE(PATH)},
    {"range", "First and last value of the driver.", SHAPE(RANGE), BY(SWEEP)},
    {"steps", "Number of intervals: there is one row more.", NUMBER, UNSTATED("100")},
    {"arclength",
     "Instead of a driver: the length of a step along the motion, over all coordinates of loops, in radians and lengths "
     "over the characteristic length.",
     NUMBER},
    {"direction", "Which way to set out, of a sweep by arc length.", OBJECT(direction_format)},
    {0}};
static const km_object_format sweep_format = {"sweep", sweep_fields};

static const km_field end_fields[] = {
    {"frame", "Frame whose origin is the point.", SHAPE(PATH), REQUIRED},
    {"direction", "Direction in the inertial frame along which the point's velocity counts.", POINT, REQUIRED},
    {0}};
static const km_object_format end_format = {"point_along_direction", end_fields};

static const km_field advantage_fields[] = {
    {"input", "The driving joint, or a point along a direction.", SHAPE(END), .object = &end_format},
    {"output", "The driven joint, or a point along a direction.", SHAPE(END), .object = &end_format},
    {0}};
static const km_object_format advantage_format = {"mechanical_advantage", advantage_fields};

static const km_field load_fields[] = {
    {"name", "Name of the load, for kstatic --load.", STRING, REQUIRED},
    {"frame", "Frame at whose origin it acts, by its path from the root.", SHAPE(PATH), REQUIRED},
    {"force", "Force.", POINT, UNIT(.force = 1), UNSTATED("[0, 0, 0]")},
    {"torque", "Torque.", VECTOR, UNIT(.force = 1, .length = 1), UNSTATED("[0, 0, 0]")},
    {"axes", "\"fixed\": along the inertial axes. \"frame\": along the frame's axes, turning with it.", STRING,
     UNSTATED("fixed")},
    {"scale", "Factor of the force and the torque over a joint's value or the time.", OBJECT(km_format_scale),
     UNSTATED("1")},
    {0}};
static const km_object_format load_format = {"load", load_fields};

static const km_field analysis_fields[] = {
    {"sweep", "The motion that the sweeps follow.", OBJECT(sweep_format)},
    {"mechanical_advantage", "The two ends of the leverage.", OBJECT(advantage_format)},
    {"actuators", "Joints that hold the mechanism in kstatic.", SHAPE(PATHS),
     UNSTATED("the cylinders, or else every joint")},
    {"loads", "Forces and torques that act on bodies at frames.", OBJECTS(load_format)},
    {"hold", "Joints that every tool keeps at a value.", SHAPE(COORDINATE_MAP)},
    {0}};
const km_object_format km_format_analysis = {"analysis", analysis_fields};

static const km_field parameter_fields[] = {{"value", "The number, or an expression.", NUMBER, REQUIRED},
                                            {"low", "Least value. A study of designs keeps to it.", NUMBER},
                                            {"high", "Greatest value. A study of designs keeps to it.", NUMBER},
                                            {"note", "What it is, for people.", STRING},
                                            {0}};
const km_object_format km_format_parameter = {"parameter", parameter_fields};

static const km_field model_fields[] = {
    {"model_parameters", "Version, units and gravity.", OBJECT(km_format_parameters)},
    {"parameters",
     "Numbers by name. Wherever a number is expected, a text is an expression over them, with pi, deg, sqrt, sin, cos, "
     "tan, atan2, abs, min and max.",
     SHAPE(PARAMETERS), .object = &km_format_parameter},
    {"fixed", "The inertial frame.", OBJECT(km_format_fixed)},
    {"assemblies", "Bodies and joints.", OBJECTS(km_format_assembly)},
    {"poses",
     "Poses by name, for --pose: values of joints, in the units of their coordinates. The joints that a pose doesn't name "
     "follow.",
     SHAPE(POSES)},
    {"analysis", "What the tools ask by default.", OBJECT(km_format_analysis)},
    {"source", "Where the model is from.", SHAPE(ANY)},
    {"title", "Title of reports.", STRING},
    {"author", "Author, in reports.", STRING},
    {"date", "Date, in reports.", STRING},
    {"notes", "A paragraph behind the answer of reports.", STRING},
    {"logo", "PNG file that stands beside the title of reports, seen from the model's file.", STRING},
    {"known", "Facts known about it. Kept.", SHAPE(ANY)},
    {0}};
const km_object_format km_format_model = {"model", model_fields};

const km_field *km_format_field(const km_object_format *format, const char *key) {
  for (const km_field *field = format->fields; field->key; ++field)
    if (strcmp(field->key, key) == 0)
      return field;
  return NULL;
}

bool km_shape_is_numeric(km_shape shape) {
  switch (shape) {
  case KM_SHAPE_NUMBER:
  case KM_SHAPE_VECTOR:
  case KM_SHAPE_POINT:
  case KM_SHAPE_MATRIX:
  case KM_SHAPE_NUMBERS:
  case KM_SHAPE_COORDINATES:
  case KM_SHAPE_RANGE:
  case KM_SHAPE_RANGES:
  case KM_SHAPE_ROWS:
  case KM_SHAPE_TIME_LAW:
  case KM_SHAPE_COORDINATE_MAP:
  case KM_SHAPE_VALUE_MAPS:
  case KM_SHAPE_POSES:
    return true;
  default:
    return false;
  }
}
