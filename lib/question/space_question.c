/* Requests of kinds "modes", "map", "turning" and "volume": whole configuration spaces, without a motion (docs/theory.md
 * 4.15, 4.19, 4.20, 4.23).
 *
 *   modes : a row for each assembly mode with some joints locked; "max mode" and "max circuit" are their numbers
 *   map   : a row for each grid point over two drivers, on the sheet of the state. reached = 1, or 0 where the sheet
 *           doesn't come; sigma.input, sigma.output and manipulability are then 0, as at a singularity, and NaN where
 *           limits or a least clearance leave out the point. "mean reached" is the share of the range that is free of
 *           singularities of the drivers and allowed
 *   turning : one row, of the driver on the circuit of the state: turns = 1 if it goes fully round, else 0; range
 *           between its dead points, a full turn if it turns, infinite if a motion without end has none
 *   volume: one row, of a point's workspace: its volume, or its area in a plane, with the ends of the 95 % interval */
#include "kmech/inspect.h"
#include "kmech/space.h"
#include "kmech/volume.h"
#include "question/question.h"
#include "space/driver_circuit.h"

#include <math.h>
#include <string.h>

enum {
  SEED = 1,
  MAP_STEPS = 40,
  FIRST = 3 /* columns of a map before those of the cells */
};

static const double axis_rounding = 1e-12; /* rounding error of an axis' values, part of its range */

enum { MODES_JOINTS, MODES_LIMITS, MODES_OPTIONS };

static const km_option modes_options[MODES_OPTIONS] = {
    {"joints", KM_OPTION_COORDINATES, "JOINT", "", "the driver of the model's analysis.sweep, if it is in a loop",
     "Joints that keep their values", 0, 0, NULL, false},
    {"limits", KM_OPTION_FLAG, NULL, "", NULL, "Modes within the joint limits only", 0, 0, NULL, false},
};

enum {
  MAP_JOINTS,
  MAP_FIRST_RANGE,
  MAP_SECOND_RANGE,
  MAP_GRID,
  MAP_SECOND_GRID,
  MAP_POINT,
  MAP_ASK,
  MAP_LIMITS,
  MAP_CLEARANCE,
  MAP_OPTIONS
};

static const km_option map_options[MAP_OPTIONS] = {
    {"joints", KM_OPTION_COORDINATES, "JOINT", "", "the two joints of the model's analysis.actuators", "Both drivers",
     0, 0, NULL, false},
    {"first-range", KM_OPTION_RANGE, "FROM:TO", "driver's", "the joint's limits, or a full turn",
     "Range of the first driver in the model's unit", 0, 0, NULL, false},
    {"second-range", KM_OPTION_RANGE, "FROM:TO", "driver's", "the joint's limits, or a full turn",
     "Range of the second driver", 0, 0, NULL, false},
    {"steps", KM_OPTION_WHOLE, "N", "", "40", "Intervals of both ranges", 1, KM_MAX_MAP_STEPS, NULL, false},
    {"second-steps", KM_OPTION_WHOLE, "N", "", "those of `steps`", "Intervals of the second range", 1, KM_MAX_MAP_STEPS,
     NULL, false},
    {"point", KM_OPTION_POINTS, "BODY/FRAME", "", NULL,
     "Add the place of a point that moves on a plane or a sphere and its "
     "Jacobian's figures",
     0, 0, NULL, false},
    {"ask", KM_OPTION_WORD, "QUESTION", "", NULL,
     "Add the leverage (advantage), the forces of the actuators (forces) or the least clearance of bodies (clearance) to "
     "each grid point; mobility (default) adds nothing",
     0, KM_MAP_QUANTITY_CLEARANCE, KM_MAP_QUANTITY_WORDS, false},
    {"limits", KM_OPTION_FLAG, NULL, "", NULL, "Leave out grid points beyond the joint limits", 0, 0, NULL, false},
    {"clearance", KM_OPTION_NUMBER, "X", "length", NULL, "Leave out grid points in which bodies are nearer than X",
     -HUGE_VAL, HUGE_VAL, NULL, false},
};

enum { TURNING_JOINT, TURNING_OPTIONS };

static const km_option turning_options[TURNING_OPTIONS] = {
    {"joint", KM_OPTION_COORDINATE, "JOINT", "", "the driver of the model's analysis.sweep", "The driver, in a loop", 0,
     0, NULL, false},
};

enum { VOLUME_POINT, VOLUME_SAMPLES, VOLUME_OWN, VOLUME_LIMITS, VOLUME_CLEARANCE, VOLUME_OPTIONS };

static const km_option volume_options[VOLUME_OPTIONS] = {
    {"point", KM_OPTION_POINTS, "BODY/FRAME", "", NULL, "The point", 0, 0, NULL, false},
    {"samples", KM_OPTION_WHOLE, "N", "", "10000", "Most points of the box that are decided", KM_MIN_VOLUME_SAMPLES,
     KM_MAX_VOLUME_SAMPLES, NULL, false},
    {"own", KM_OPTION_FLAG, NULL, "", NULL, "Only configurations that a motion from the pose leads to", 0, 0, NULL,
     false},
    {"limits", KM_OPTION_FLAG, NULL, "", NULL, "Configurations beyond the joint limits don't count", 0, 0, NULL, false},
    {"clearance", KM_OPTION_NUMBER, "X", "length", NULL, "Configurations in which bodies are nearer than X don't count",
     -HUGE_VAL, HUGE_VAL, NULL, false},
};

typedef struct kind_data {
  km_table *table;
  km_mode_gap gap;      /* gap of a list of modes */
  bool is_lost;         /* circuits may be connected */
  km_space_map_def def; /* definition of a map */
} kind_data;

static km_status no_memory(km_error *error) {
  return km_fail(error, KM_MEMORY, "out of memory for a configuration space");
}

/* ---- Assembly modes. */

/* Joints that keep their values: those of the option, else the sweep's driver. */
static int count_locked(const km_question *q, const int **locked, int *driver) {
  const km_option_value *joints = km_question_own_value(q, MODES_JOINTS);
  *driver = km_model_sweep_coordinate(q->m->model);
  *locked = joints ? joints->coordinates : driver;
  if (joints)
    return joints->count;
  return *driver >= 0 && !q->m->held[*driver] && q->m->column_of[*driver] >= 0;
}

static bool add_coordinate_columns(const km_question *q, const char *prefix, bool has_units, km_table *table) {
  km_text name = {0};
  bool is_ok = true;
  for (int c = 0; is_ok && c < q->m->coordinate_count; ++c) {
    name.size = 0;
    km_text_format(&name, "%s.%s", prefix, q->m->model->coordinates[c].label);
    is_ok = !name.failed &&
            km_table_add_column(table, name.data, has_units ? km_model_coordinate_unit(q->m->model, c) : "") >= 0;
  }
  km_text_free(&name);
  return is_ok;
}

static bool fill_modes(const km_question *q, const km_all_modes *modes, const km_mode_circuits *circuits,
                       km_table *table) {
  static const char *const first[] = {"step", "s", "mode", "circuit"};
  bool is_ok = table != NULL;
  for (size_t k = 0; is_ok && k < sizeof first / sizeof *first; ++k)
    is_ok = km_table_add_column(table, first[k], "") >= 0;
  is_ok = is_ok && add_coordinate_columns(q, "q", true, table) && add_coordinate_columns(q, "m", false, table) &&
          km_table_add_column(table, "dof", "") >= 0;
  size_t n = (size_t)q->m->coordinate_count;
  for (int i = 0; is_ok && i < modes->count; ++i) {
    double *row = km_table_add_row(table);
    is_ok = row != NULL;
    if (!is_ok)
      break;
    *row++ = i;
    *row++ = i + 1;
    *row++ = i + 1;
    *row++ = circuits->count > 0 ? circuits->circuit[i] : nan("");
    memcpy(row, modes->coordinates + (size_t)i * n, n * sizeof *row);
    memcpy(row + n, modes->mobility_numbers + (size_t)i * n, n * sizeof *row);
    row[2 * n] = modes->evidence[i].mobility;
  }
  return is_ok;
}

static km_status answer_modes(km_question *q, km_state *s, km_error *error) {
  kind_data *o = q->kind_data;
  const km_option_value *limits = km_question_own_value(q, MODES_LIMITS);
  int driver;
  km_all_modes_def def = {.within_limits = limits && limits->flag, .seed = SEED};
  km_all_modes modes = {0};
  km_mode_circuits circuits = {0};
  def.locked_count = count_locked(q, &def.locked, &driver);
  km_status status = km_modes_and_circuits_find(q->m, s, &def, q->progress, q->context, &modes, &circuits, error);
  if (!status) {
    o->gap = modes.gap;
    o->is_lost = circuits.gap == KM_CIRCUIT_GAP_LOST;
    o->table = km_table_create();
    if (!fill_modes(q, &modes, &circuits, o->table))
      status = no_memory(error);
    else if (!modes.is_complete || o->is_lost)
      status = KM_PARTIAL;
  }
  km_mode_circuits_free(&circuits);
  km_all_modes_free(&modes);
  return status;
}

static void end_of_modes(const km_question *q, km_text *out) {
  const kind_data *o = q->kind_data;
  if (o->gap != KM_GAP_NONE)
    km_text_format(out, "the list of assembly modes may lack some: %s", km_mode_gap_name(o->gap));
  else if (o->is_lost)
    km_text_add(out, "a circuit wasn't followed to its end");
}

/* ---- A map. */

/* Range of a driver: the option's, else the limits, else a full turn. */
static km_status read_range(const km_question *q, int option, km_space_axis *axis, km_error *error) {
  const km_option_value *range = km_question_own_value(q, option);
  const km_model *model = q->m->model;
  km_model_coordinate_limits(model, axis->coordinate, &axis->from, &axis->to);
  if (range) {
    axis->from = range->numbers[0];
    axis->to = range->numbers[1];
  } else if (!(isfinite(axis->from) && isfinite(axis->to))) {
    if (km_model_coordinate_is_length(model, axis->coordinate))
      return km_fail(error, KM_USAGE, "`%s` is missing, and joint \"%s\" has no limits", map_options[option].name,
                     model->coordinates[axis->coordinate].label);
    axis->to = M_PI / km_model_units(model).angle->si;
    axis->from = -axis->to;
  }
  return KM_OK;
}

static km_status prepare_map(km_question *q, km_error *error) {
  kind_data *o = q->kind_data;
  const km_option_value *joints = km_question_own_value(q, MAP_JOINTS), *steps = km_question_own_value(q, MAP_GRID),
                        *second_steps = km_question_own_value(q, MAP_SECOND_GRID),
                        *point = km_question_own_value(q, MAP_POINT), *limits = km_question_own_value(q, MAP_LIMITS);
  const km_model *model = q->m->model;
  if ((joints ? joints->count : km_model_actuator_count(model)) != 2)
    return km_fail(error, KM_USAGE, "`joints`: expected the two drivers of a map, or two in analysis.actuators");
  if (point && point->count != 1)
    return km_fail(error, KM_USAGE, "`point`: expected one point of a map");
  o->def = (km_space_map_def){.own_sheet = true, .has_point = point != NULL, .within_limits = limits && limits->flag};
  if (point) {
    o->def.frame = point->points[0].frame;
    o->def.point_name = point->points[0].name;
  }
  km_status status = KM_OK;
  for (int d = 0; d < 2 && !status; ++d) {
    km_space_axis *axis = &o->def.axis[d];
    axis->coordinate = joints ? joints->coordinates[d] : km_model_actuator(model, d);
    axis->steps = d == 1 && second_steps ? second_steps->whole : steps ? steps->whole : MAP_STEPS;
    status = read_range(q, d == 0 ? MAP_FIRST_RANGE : MAP_SECOND_RANGE, axis, error);
  }
  return status;
}

/* Columns that are 0 where the sheet doesn't come. */
static bool is_zero_at_singularity(const char *name) {
  return strcmp(name, "sigma.input") == 0 || strcmp(name, "sigma.output") == 0 || strcmp(name, "manipulability") == 0;
}

static double axis_value(const km_space_axis *axis, int i) {
  return axis->from + (axis->to - axis->from) * i / axis->steps;
}

/* True at a grid point where a driver itself is beyond its limits, which leave it out. */
static bool is_beyond_limits(const km_model *model, const km_space_map_def *def, int point) {
  const int at[2] = {point % (def->axis[0].steps + 1), point / (def->axis[0].steps + 1)};
  bool is_beyond = false;
  for (int d = 0; d < 2 && def->within_limits; ++d) {
    const km_space_axis *axis = &def->axis[d];
    double low, high, value = axis_value(axis, at[d]), rounding = axis_rounding * fabs(axis->to - axis->from);
    km_model_coordinate_limits(model, axis->coordinate, &low, &high);
    is_beyond = is_beyond || value < low - rounding || value > high + rounding;
  }
  return is_beyond;
}

/* Fills rows[grid point] with the row of the cells there; -1: the sheet doesn't come. */
static void index_cells(const km_space_map_def *def, const km_table *cells, int points, int *rows) {
  for (int p = 0; p < points; ++p)
    rows[p] = -1;
  for (size_t r = 0; r < km_table_rows(cells); ++r) {
    int at[2];
    for (int d = 0; d < 2; ++d) {
      const km_space_axis *a = &def->axis[d];
      at[d] = (int)round((km_table_row(cells, r)[d] - a->from) / (a->to - a->from) * a->steps);
    }
    rows[at[1] * (def->axis[0].steps + 1) + at[0]] = (int)r;
  }
}

static bool add_map_columns(const km_table *cells, km_table *table) {
  static const char *const first[FIRST] = {"step", "s", "reached"};
  bool is_ok = table != NULL;
  for (size_t k = 0; is_ok && k < FIRST; ++k)
    is_ok = km_table_add_column(table, first[k], "") >= 0;
  for (size_t c = 0; is_ok && c < km_table_columns(cells); ++c)
    is_ok = km_table_add_column(table, km_table_name(cells, c), km_table_unit(cells, c)) >= 0;
  return is_ok;
}

/* Adds the row of a grid point: step, s, reached, then the cell, whose first columns are the drivers. cell: NULL, the
 * point is not reached. */
static bool add_map_row(const km_space_map_def *def, const km_table *cells, int point, const double *cell,
                        bool is_left_out, km_table *table) {
  int across = def->axis[0].steps + 1;
  size_t width = km_table_columns(cells);
  double *row = km_table_add_row(table);
  if (!row)
    return false;
  row[0] = row[1] = point;
  row[2] = cell != NULL;
  for (size_t c = 0; c < width; ++c)
    row[FIRST + c] = cell ? cell[c] : !is_left_out && is_zero_at_singularity(km_table_name(cells, c)) ? 0.0 : nan("");
  row[FIRST] = axis_value(&def->axis[0], point % across);
  row[FIRST + 1] = axis_value(&def->axis[1], point / across);
  return true;
}

/* cells: those that limits and clearance allow; all: those without these conditions. */
static bool fill_map(const km_model *model, const km_space_map_def *def, const km_table *cells, const km_table *all,
                     km_table *table) {
  int points = (def->axis[0].steps + 1) * (def->axis[1].steps + 1);
  int *rows = KM_NEW(int, 2 * (size_t)points), *all_rows = rows ? rows + points : NULL;
  bool is_ok = rows && add_map_columns(cells, table);
  if (rows) {
    index_cells(def, cells, points, rows);
    index_cells(def, all, points, all_rows);
  }
  for (int p = 0; is_ok && p < points; ++p)
    is_ok = add_map_row(def, cells, p, rows[p] >= 0 ? km_table_row(cells, (size_t)rows[p]) : NULL,
                        all_rows[p] >= 0 || is_beyond_limits(model, def, p), table);
  km_free(rows);
  return is_ok;
}

/* Figures and least clearance of the definition; free them in any case. */
static km_status create_map_parts(const km_question *q, km_state *s, km_space_map_def *def, km_map_figures **figures,
                                  km_clearance **clearance, km_error *error) {
  const km_option_value *ask = km_question_own_value(q, MAP_ASK), *least = km_question_own_value(q, MAP_CLEARANCE);
  const int drivers[2] = {def->axis[0].coordinate, def->axis[1].coordinate};
  km_status status = km_map_figures_create(q->m, s, ask ? (km_map_quantity)ask->whole : KM_MAP_QUANTITY_MOBILITY,
                                           drivers, figures, error);
  if (!status && least)
    status = km_question_prepare_clearance(q, s, NULL, clearance, error);
  def->figures = *figures;
  def->clearance = *clearance;
  def->least_clearance = least ? least->numbers[0] : 0.0;
  return status;
}

/* Computes the sheet of the mode, and where limits or a clearance leave out cells, that without these conditions. */
static km_status compute_maps(km_question *q, km_state *s, const km_space_map_def *def, const km_all_modes *own,
                              km_error *error) {
  kind_data *o = q->kind_data;
  km_space_map_def free_def = *def;
  km_space_map map = {0}, all = {0};
  bool has_conditions = def->within_limits || def->clearance;
  free_def.within_limits = false;
  free_def.clearance = NULL;
  km_progress_stage stage = {.progress = q->progress, .context = q->context};
  km_progress_stage_next(&stage, has_conditions ? 0.5 : 1.0);
  km_status status = km_space_map_compute(q->m, s, def, own, km_progress_stage_report, &stage, &map, error);
  km_progress_stage_next(&stage, 1.0);
  if (!status && has_conditions)
    status = km_space_map_compute(q->m, s, &free_def, own, km_progress_stage_report, &stage, &all, error);
  if (!status) {
    o->table = km_table_create();
    if (!fill_map(q->m->model, def, map.cells, has_conditions ? all.cells : map.cells, o->table))
      status = no_memory(error);
  }
  km_space_map_free(&map);
  km_space_map_free(&all);
  return status;
}

/* The sheet of the state: a list of modes that has it alone. */
static km_status answer_map(km_question *q, km_state *s, km_error *error) {
  km_space_map_def def = ((const kind_data *)q->kind_data)->def;
  km_map_figures *figures = NULL;
  km_clearance *clearance = NULL;
  km_all_modes own = {.count = 1, .coordinates = KM_NEW(double, (size_t)q->m->coordinate_count + 1)};
  km_status status = own.coordinates ? km_state_coordinates(q->m, s, own.coordinates, error) : no_memory(error);
  if (!status)
    status = create_map_parts(q, s, &def, &figures, &clearance, error);
  if (!status)
    status = compute_maps(q, s, &def, &own, error);
  km_free(own.coordinates);
  km_clearance_free(clearance);
  km_map_figures_free(figures);
  return status;
}

/* ---- Turning. */

static bool fill_turning(const km_model *model, int driver, const km_driver_swing *swing, km_table *table) {
  static const char *const names[] = {"step", "s", "turns", "dead_points", "low", "high", "range"};
  const char *unit = km_model_coordinate_unit(model, driver);
  double factor = km_model_coordinate_factor(model, driver);
  bool is_ok = table != NULL, is_found = swing->low <= swing->high;
  for (size_t k = 0; is_ok && k < sizeof names / sizeof *names; ++k)
    is_ok = km_table_add_column(table, names[k], k < 4 ? "" : unit) >= 0;
  double *row = is_ok ? km_table_add_row(table) : NULL;
  if (!row)
    return false;
  row[2] = swing->turns;
  row[3] = swing->dead_points;
  row[4] = is_found ? swing->low / factor : nan("");
  row[5] = is_found ? swing->high / factor : nan("");
  row[6] = swing->turns ? 2.0 * M_PI / factor : is_found ? row[5] - row[4] : HUGE_VAL;
  return true;
}

/* The circuit of the state, with all joints but held ones free. */
static km_status answer_turning(km_question *q, km_state *s, km_error *error) {
  kind_data *o = q->kind_data;
  const km_option_value *joint = km_question_own_value(q, TURNING_JOINT);
  int driver = joint ? joint->coordinate : km_model_sweep_coordinate(q->m->model);
  if (driver < 0)
    return km_fail(error, KM_USAGE, "`joint` is missing; expected the driver, a hinge or slide of a loop");
  km_arena arena = {0};
  km_driver_surface surface = {.m = q->m, .s = s, .frame = -1};
  km_driver_circuit circuit;
  km_driver_swing swing;
  km_status status = km_driver_circuit_create(&surface, driver, &arena, &circuit, error);
  if (!status)
    status = km_driver_surface_begin(&surface, &arena, error);
  if (!status)
    status = km_driver_circuit_follow(&circuit, &swing, error);
  if (!status) {
    o->table = km_table_create();
    if (!fill_turning(q->m->model, driver, &swing, o->table))
      status = no_memory(error);
  }
  km_arena_free(&arena);
  return status;
}

/* ---- The volume of a workspace. */

static km_status prepare_volume(km_question *q, km_error *error) {
  const km_option_value *point = km_question_own_value(q, VOLUME_POINT);
  return point && point->count == 1 ? KM_OK
                                    : km_fail(error, KM_USAGE, "`point`: expected the point of a workspace, one");
}

static bool fill_volume(const km_model *model, const km_space_volume *v, km_table *table) {
  const char *names[] = {"step",    "s",           v->dimension == 3 ? "volume" : "area",
                         "low",     "high",        "standard_error",
                         "reached", "not_reached", "undecided"};
  enum { FIRST_SIZE = 2, SIZES = 4, COLUMNS = sizeof names / sizeof *names };
  km_text unit = {0};
  km_text_format(&unit, "%s^%d", km_model_units(model).length->suffix, v->dimension);
  bool is_ok = table && !unit.failed;
  for (int k = 0; is_ok && k < COLUMNS; ++k)
    is_ok = km_table_add_column(table, names[k], k >= FIRST_SIZE && k < FIRST_SIZE + SIZES ? unit.data : "") >= 0;
  double *row = is_ok ? km_table_add_row(table) : NULL;
  if (row) /* step and s are 0 */
    memcpy(row + FIRST_SIZE,
           (const double[]){v->volume, v->low, v->high, v->standard_error, v->reached, v->not_reached, v->undecided},
           (COLUMNS - FIRST_SIZE) * sizeof *row);
  km_text_free(&unit);
  return row != NULL;
}

static km_status answer_volume(km_question *q, km_state *s, km_error *error) {
  kind_data *o = q->kind_data;
  const km_option_value *point = km_question_own_value(q, VOLUME_POINT),
                        *samples = km_question_own_value(q, VOLUME_SAMPLES),
                        *own = km_question_own_value(q, VOLUME_OWN), *limits = km_question_own_value(q, VOLUME_LIMITS),
                        *least = km_question_own_value(q, VOLUME_CLEARANCE);
  km_clearance *clearance = NULL;
  km_space_volume volume = {0};
  km_status status = least ? km_question_prepare_clearance(q, s, NULL, &clearance, error) : KM_OK;
  const km_space_volume_def def = {.frame = point->points[0].frame,
                                   .point_name = point->points[0].name,
                                   .own_circuit = own && own->flag,
                                   .within_limits = limits && limits->flag,
                                   .clearance = clearance,
                                   .least_clearance = least ? least->numbers[0] : 0.0,
                                   .samples = samples ? samples->whole : 0,
                                   .seed = SEED};
  if (!status)
    status = km_space_volume_find(q->m, s, &def, q->progress, q->context, &volume, error);
  if (!status) {
    o->table = km_table_create();
    if (!fill_volume(q->m->model, &volume, o->table))
      status = no_memory(error);
    else if (!volume.is_complete)
      status = KM_PARTIAL;
  }
  km_space_volume_free(&volume);
  km_clearance_free(clearance);
  return status;
}

static void end_of_volume(const km_question *q, km_text *out) {
  (void)q;
  km_text_add(out, "the box of the workspace grew to the last");
}

/* A map is complete, and so is a circuit. */
static void end_of_map(const km_question *q, km_text *out) {
  (void)q;
  (void)out;
}

/* ---- All. */

static const km_table *table(const km_question *q) {
  return ((const kind_data *)q->kind_data)->table;
}

static int planned_rows(const km_question *q) {
  return (int)km_table_rows(table(q));
}

static double planned_place(const km_question *q, int row) {
  return row >= 0 && row < planned_rows(q) ? km_table_row(table(q), (size_t)row)[1] : nan("");
}

/* A space has no events. */
static int event_count(const km_question *q) {
  (void)q;
  return 0;
}

static km_question_event event(const km_question *q, int index) {
  (void)q;
  (void)index;
  return (km_question_event){"", "", nan(""), nan("")};
}

static void clear_result(km_question *q) {
  kind_data *o = q->kind_data;
  km_table_free(o->table);
  o->table = NULL;
}

const km_question_class km_modes_question = {.name = "modes",
                                             .options = modes_options,
                                             .option_count = MODES_OPTIONS,
                                             .size = sizeof(kind_data),
                                             .is_space = true,
                                             .answer = answer_modes,
                                             .table = table,
                                             .planned_rows = planned_rows,
                                             .planned_place = planned_place,
                                             .end_reason = end_of_modes,
                                             .event_count = event_count,
                                             .event = event,
                                             .clear_result = clear_result};

const km_question_class km_map_question = {.name = "map",
                                           .options = map_options,
                                           .option_count = MAP_OPTIONS,
                                           .size = sizeof(kind_data),
                                           .is_space = true,
                                           .prepare = prepare_map,
                                           .answer = answer_map,
                                           .table = table,
                                           .planned_rows = planned_rows,
                                           .planned_place = planned_place,
                                           .end_reason = end_of_map,
                                           .event_count = event_count,
                                           .event = event,
                                           .clear_result = clear_result};

const km_question_class km_turning_question = {.name = "turning",
                                               .options = turning_options,
                                               .option_count = TURNING_OPTIONS,
                                               .size = sizeof(kind_data),
                                               .is_space = true,
                                               .answer = answer_turning,
                                               .table = table,
                                               .planned_rows = planned_rows,
                                               .planned_place = planned_place,
                                               .end_reason = end_of_map,
                                               .event_count = event_count,
                                               .event = event,
                                               .clear_result = clear_result};

const km_question_class km_volume_question = {.name = "volume",
                                              .options = volume_options,
                                              .option_count = VOLUME_OPTIONS,
                                              .size = sizeof(kind_data),
                                              .is_space = true,
                                              .prepare = prepare_volume,
                                              .answer = answer_volume,
                                              .table = table,
                                              .planned_rows = planned_rows,
                                              .planned_place = planned_place,
                                              .end_reason = end_of_volume,
                                              .event_count = event_count,
                                              .event = event,
                                              .clear_result = clear_result};
