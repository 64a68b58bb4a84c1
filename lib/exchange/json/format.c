#include "exchange/json/format.h"

#include <string.h>

/* Abbreviations for the rows below: the shape, then what it measures. */
#define NUMBER     .shape = KM_SHAPE_NUMBER
#define STRING     .shape = KM_SHAPE_STRING
#define BOOLEAN    .shape = KM_SHAPE_BOOLEAN
#define VECTOR     .shape = KM_SHAPE_VECTOR
#define POINT      .shape = KM_SHAPE_POINT
#define OBJECT(f)  .shape = KM_SHAPE_OBJECT, .object = &(f)
#define OBJECTS(f) .shape = KM_SHAPE_OBJECTS, .object = &(f)
#define SHAPE(s)   .shape = KM_SHAPE_##s
#define UNIT(...)  .dimension = {__VA_ARGS__}
#define BY(m)      .measure = KM_MEASURE_##m
#define REQUIRED   .required = true

static const km_field units_fields[] = {{"angle", STRING}, {"length", STRING}, {"mass", STRING},
                                        {"time", STRING},  {"force", STRING},  {0}};
static const km_object_format units_format = {"units", units_fields};

static const km_field simulation_fields[] = {{"integration_type", STRING},
                                             {"time_span", NUMBER, UNIT(.time = 1)},
                                             {"time_step", NUMBER, UNIT(.time = 1)},
                                             {"relative_error", NUMBER},
                                             {"absolute_error", NUMBER},
                                             {0}};
static const km_object_format simulation_format = {"simulation", simulation_fields};

static const km_field parameters_fields[] = {{"version", STRING},
                                             {"units", OBJECT(units_format)},
                                             {"gravity", POINT, UNIT(.length = 1, .time = -2)},
                                             {"include_dir", SHAPE(STRINGS)},
                                             {"closure_tolerance", NUMBER},
                                             {"simulation", OBJECT(simulation_format)},
                                             {"characteristic_length", NUMBER, UNIT(.length = 1)},
                                             {0}};
static const km_object_format parameters_format = {"model_parameters", parameters_fields};

static const km_field frame_fields[] = {
    {"name", STRING, REQUIRED}, {"T", POINT, UNIT(.length = 1)}, {"R", SHAPE(MATRIX)}, {"active", BOOLEAN}, {0}};
static const km_object_format frame_format = {"frame", frame_fields};

static const km_field light_fields[] = {{"name", STRING}, {"type", STRING}, {"parent", SHAPE(PATH)}, {"Ka", VECTOR},
                                        {"Kd", VECTOR},   {"Ks", VECTOR},   {"active", BOOLEAN},     {0}};
static const km_object_format light_format = {"light", light_fields};

static const km_field fixed_fields[] = {{"frames", OBJECTS(frame_format)}, {"lights", OBJECTS(light_format)}, {0}};
const km_object_format km_format_fixed = {"fixed", fixed_fields};

#define INERTIA NUMBER, UNIT(.mass = 1, .length = 2)
static const km_field inertia_fields[] = {
    {"Ixx", INERTIA}, {"Iyy", INERTIA}, {"Izz", INERTIA}, {"Ixy", INERTIA}, {"Iyz", INERTIA}, {"Izx", INERTIA}, {0}};
static const km_object_format inertia_format = {"moment_of_inertia", inertia_fields};

static const km_field body_fields[] = {{"name", STRING, REQUIRED},
                                       {"mass", NUMBER, UNIT(.mass = 1)},
                                       {"center_of_mass", POINT, UNIT(.length = 1)},
                                       {"moment_of_inertia", OBJECT(inertia_format)},
                                       {"definition", SHAPE(STRINGS)},
                                       {"density", NUMBER, UNIT(.mass = 1, .length = -3)},
                                       {"frames", OBJECTS(frame_format)},
                                       {"active", BOOLEAN},
                                       {0}};
const km_object_format km_format_body = {"body", body_fields};

static const km_field friction_fields[] = {{"coefficient", NUMBER},
                                           {"radius", NUMBER, UNIT(.length = 1)},
                                           {"stiction_velocity", NUMBER, UNIT(.length = 1, .time = -1)},
                                           {0}};
static const km_object_format friction_format = {"friction", friction_fields};

static const km_field stop_fields[] = {
    {"stiffness", NUMBER, BY(STIFFNESS)}, {"damping", NUMBER, BY(STIFFNESS), UNIT(.time = 1)}, {0}};
static const km_object_format stop_format = {"stop", stop_fields};

static const km_field sine_fields[] = {{"offset", NUMBER, BY(COORDINATE)},
                                       {"amplitude", NUMBER, BY(COORDINATE)},
                                       {"frequency", NUMBER, UNIT(.time = -1)},
                                       {"phase", NUMBER, UNIT(.angle = 1)},
                                       {0}};
static const km_object_format sine_format = {"sine", sine_fields};

static const km_field prescribed_fields[] = {{"table", SHAPE(ROWS), BY(TABLE)},
                                             {"polynomial", SHAPE(NUMBERS), BY(POLYNOMIAL)},
                                             {"sine", OBJECT(sine_format)},
                                             {0}};
static const km_object_format prescribed_format = {"prescribed", prescribed_fields};

static const km_field joint_fields[] = {{"name", STRING, REQUIRED},
                                        {"type", STRING, REQUIRED},
                                        {"body_frame_pairs", SHAPE(PATH_PAIR)},
                                        {"bodies", SHAPE(PATHS)},
                                        {"at", POINT, UNIT(.length = 1)},
                                        {"axis", POINT},
                                        {"initial_displacement", SHAPE(COORDINATES), BY(COORDINATE)},
                                        {"initial_velocity", SHAPE(COORDINATES), BY(COORDINATE), UNIT(.time = -1)},
                                        {"damping", SHAPE(COORDINATES), BY(STIFFNESS), UNIT(.time = 1)},
                                        {"friction", OBJECT(friction_format)},
                                        {"limits", SHAPE(RANGES), BY(COORDINATE)},
                                        {"stop", OBJECT(stop_format)},
                                        {"prescribed", OBJECT(prescribed_format)},
                                        {"pitch", NUMBER, UNIT(.length = 1)},
                                        {"active", BOOLEAN},
                                        {0}};
const km_object_format km_format_joint = {"joint", joint_fields};

static const km_field coupling_fields[] = {{"name", STRING, REQUIRED},
                                           {"joints", SHAPE(PATHS), REQUIRED},
                                           {"ratios", SHAPE(NUMBERS), REQUIRED, BY(RATIO)},
                                           {"active", BOOLEAN},
                                           {0}};
const km_object_format km_format_coupling = {"coupling", coupling_fields};

static const km_field port_fields[] = {
    {"type", STRING, REQUIRED}, {"joint", SHAPE(PATH)}, {"body_frame_pair", SHAPE(PATH_PAIR)}, {0}};
static const km_object_format port_format = {"force_module_port", port_fields};

static const km_field tire_fields[] = {{"unloaded_radius", NUMBER, UNIT(.length = 1)},
                                       {"vertical_stiffness", NUMBER, UNIT(.force = 1, .length = -1)},
                                       {"vertical_damping", NUMBER, UNIT(.force = 1, .time = 1, .length = -1)},
                                       {"rolling_resistance", NUMBER, UNIT(.length = 1)},
                                       {"width", NUMBER, UNIT(.length = 1)},
                                       {"longitudinal_stiffness", NUMBER, UNIT(.force = 1)},
                                       {"lateral_stiffness", NUMBER, UNIT(.force = 1)},
                                       {"friction_peak", NUMBER},
                                       {"friction_sliding", NUMBER},
                                       {"relaxation_length_x", NUMBER, UNIT(.length = 1)},
                                       {"relaxation_length_y", NUMBER, UNIT(.length = 1)},
                                       {0}};
static const km_object_format tire_format = {"tire", tire_fields};

static const km_field module_fields[] = {{"name", STRING, REQUIRED},
                                         {"type", STRING, REQUIRED},
                                         {"input", OBJECT(port_format)},
                                         {"output", OBJECT(port_format)},
                                         {"distance_type", STRING},
                                         {"knot_points", SHAPE(NUMBERS), BY(KNOTS)},
                                         {"coefficients", SHAPE(ROWS), BY(PIECES)},
                                         {"table", SHAPE(ROWS), BY(LAW_TABLE)},
                                         {"polynomial", SHAPE(NUMBERS), BY(LAW_POLYNOMIAL)},
                                         {"reference", NUMBER, BY(REFERENCE)},
                                         {"kp", NUMBER, BY(GAIN)},
                                         {"ki", NUMBER, BY(GAIN), UNIT(.time = -1)},
                                         {"kd", NUMBER, BY(GAIN), UNIT(.time = 1)},
                                         {"tire", OBJECT(tire_format)},
                                         {"active", BOOLEAN},
                                         {0}};
const km_object_format km_format_module = {"force_module", module_fields};

static const km_field spring_fields[] = {{"stiffness", NUMBER, REQUIRED, UNIT(.force = 1, .length = -1)},
                                         {"free_length", NUMBER, REQUIRED, UNIT(.length = 1)},
                                         {0}};
static const km_object_format spring_format = {"spring", spring_fields};

static const km_field gas_spring_fields[] = {{"force", NUMBER, REQUIRED, UNIT(.force = 1)},
                                             {"rate", NUMBER, UNIT(.force = 1, .length = -1)},
                                             {"length", NUMBER, UNIT(.length = 1)},
                                             {0}};
static const km_object_format gas_spring_format = {"gas_spring", gas_spring_fields};

static const km_field strut_fields[] = {{"name", STRING, REQUIRED},
                                        {"from", SHAPE(PATH), REQUIRED},
                                        {"to", SHAPE(PATH), REQUIRED},
                                        {"planar", BOOLEAN},
                                        {"spring", OBJECT(spring_format)},
                                        {"gas_spring", OBJECT(gas_spring_format)},
                                        {"cylinder", BOOLEAN},
                                        {"limits", SHAPE(RANGE), UNIT(.length = 1)},
                                        {"damping", NUMBER, UNIT(.force = 1, .time = 1, .length = -1)},
                                        {"active", BOOLEAN},
                                        {0}};
const km_object_format km_format_strut = {"strut", strut_fields};

static const km_object_format assembly_format;
static const km_field assembly_fields[] = {{"name", STRING, REQUIRED},
                                           {"active", BOOLEAN},
                                           {"drawn", STRING},
                                           {"bodies", OBJECTS(km_format_body)},
                                           {"joints", OBJECTS(km_format_joint)},
                                           {"struts", OBJECTS(km_format_strut)},
                                           {"couplings", OBJECTS(km_format_coupling)},
                                           {"force_modules", OBJECTS(km_format_module)},
                                           {"lights", OBJECTS(light_format)},
                                           {"assemblies", OBJECTS(assembly_format)},
                                           {0}};
static const km_object_format assembly_format = {"assembly", assembly_fields};

static const km_field direction_fields[] = {{"joint", SHAPE(PATH), REQUIRED}, {"sign", NUMBER, REQUIRED}, {0}};
static const km_object_format direction_format = {"sweep_direction", direction_fields};

static const km_field sweep_fields[] = {
    {"joint", SHAPE(PATH)}, {"range", SHAPE(RANGE), BY(SWEEP)},      {"steps", NUMBER},
    {"arclength", NUMBER},  {"direction", OBJECT(direction_format)}, {0}};
static const km_object_format sweep_format = {"sweep", sweep_fields};

static const km_field end_fields[] = {{"frame", SHAPE(PATH), REQUIRED}, {"direction", POINT, REQUIRED}, {0}};
static const km_object_format end_format = {"point_along_direction", end_fields};

static const km_field advantage_fields[] = {
    {"input", SHAPE(END), .object = &end_format}, {"output", SHAPE(END), .object = &end_format}, {0}};
static const km_object_format advantage_format = {"mechanical_advantage", advantage_fields};

static const km_field load_fields[] = {{"name", STRING, REQUIRED},
                                       {"frame", SHAPE(PATH), REQUIRED},
                                       {"force", POINT, UNIT(.force = 1)},
                                       {"torque", VECTOR, UNIT(.force = 1, .length = 1)},
                                       {"axes", STRING},
                                       {0}};
static const km_object_format load_format = {"load", load_fields};

static const km_field analysis_fields[] = {
    {"sweep", OBJECT(sweep_format)}, {"mechanical_advantage", OBJECT(advantage_format)},
    {"actuators", SHAPE(PATHS)},     {"loads", OBJECTS(load_format)},
    {"hold", SHAPE(COORDINATE_MAP)}, {0}};
static const km_object_format analysis_format = {"analysis", analysis_fields};

static const km_field parameter_fields[] = {
    {"value", NUMBER, REQUIRED}, {"low", NUMBER}, {"high", NUMBER}, {"note", STRING}, {0}};
static const km_object_format parameter_format = {"parameter", parameter_fields};

static const km_field model_fields[] = {{"model_parameters", OBJECT(parameters_format)},
                                        {"parameters", SHAPE(PARAMETERS), .object = &parameter_format},
                                        {"fixed", OBJECT(km_format_fixed)},
                                        {"assemblies", OBJECTS(assembly_format)},
                                        {"analysis", OBJECT(analysis_format)},
                                        {"source", SHAPE(ANY)},
                                        {"known", SHAPE(ANY)},
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
  case KM_SHAPE_COORDINATE_MAP:
    return true;
  default:
    return false;
  }
}
