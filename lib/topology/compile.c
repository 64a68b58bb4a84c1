/* Compiles a model into a mechanism: topology first, then all numbers (docs/theory.md 1.4, 1.5, 2.2, 2.3). */
#include "topology/compile.h"

#include "base/arguments.h"
#include "base/extrema.h"

#include <string.h>

static bool is_ball_joint(const km_model *model, int joint) {
  const km_joint_kind *kind = km_joint_kind_of(model->joints[joint].type);
  return kind->motion_count == 1 && kind->motions[0].primitive == KM_BALL;
}

/* Builds the graph of bodies, joints and couplings, and its topology. */
static km_status build_topology(km_mechanism *m, bool cuts_balls, km_error *error) {
  const km_model *model = m->model;
  km_arena scratch = {0};
  km_edge *edges = KM_ARENA_NEW(&scratch, km_edge, (size_t)model->joint_count);
  bool *is_cut = KM_ARENA_NEW(&scratch, bool, (size_t)model->joint_count);
  km_coupled_joints *coupled = KM_ARENA_NEW(&scratch, km_coupled_joints, (size_t)model->coupling_count);
  size_t terms = 0;
  for (int i = 0; i < model->coupling_count; ++i)
    terms += (size_t)model->couplings[i].count;
  int *coupled_joint = KM_ARENA_NEW(&scratch, int, terms);
  if (scratch.failed) {
    km_arena_free(&scratch);
    return km_fail(error, KM_MEMORY, "out of memory while compiling the mechanism");
  }
  for (int j = 0; j < model->joint_count; ++j) {
    edges[j] = (km_edge){km_joint_body(model, j, 0), km_joint_body(model, j, 1)};
    is_cut[j] = cuts_balls && is_ball_joint(model, j);
  }
  for (int i = 0; i < model->coupling_count; ++i) {
    const km_model_coupling *coupling = &model->couplings[i];
    coupled[i] = (km_coupled_joints){coupled_joint, coupling->count};
    for (int k = 0; k < coupling->count; ++k)
      *coupled_joint++ = model->coordinates[coupling->coordinates[k]].joint;
  }
  km_graph graph = {model->body_count, model->joint_count, model->coupling_count, edges, is_cut, coupled};
  km_status status = km_topology_build(&graph, &m->arena, &m->topology, error);
  km_arena_free(&scratch);
  return status;
}

bool km_compile_allocate(km_mechanism *m, km_compile_workspace *workspace) {
  size_t steps, entries, terms = 0, curves = 0;
  km_compile_bounds(m, &steps, &entries);
  for (int i = 0; i < m->model->coupling_count; ++i) {
    terms += (size_t)m->model->couplings[i].count;
    curves += (size_t)m->model->couplings[i].polynomial_count;
  }

  km_arena *arena = &m->arena;
  size_t coordinates = (size_t)m->coordinate_count, loops = (size_t)m->topology.loop_count;
  size_t substructures = (size_t)m->topology.substructure_count, bodies = (size_t)m->model->body_count;
  m->held = KM_ARENA_NEW(arena, bool, coordinates);
  m->start = KM_ARENA_NEW(arena, double, coordinates);
  m->start_rate = KM_ARENA_NEW(arena, double, coordinates);
  m->start_stated = KM_ARENA_NEW(arena, bool, coordinates);
  m->low = KM_ARENA_NEW(arena, double, coordinates);
  m->high = KM_ARENA_NEW(arena, double, coordinates);
  m->max_ball_angle = KM_ARENA_NEW(arena, double, coordinates);
  m->max_rate = KM_ARENA_NEW(arena, double, coordinates);
  m->max_force = KM_ARENA_NEW(arena, double, coordinates);
  m->armature = KM_ARENA_NEW(arena, double, coordinates);
  m->friction = KM_ARENA_NEW(arena, double, coordinates);
  m->scale = KM_ARENA_NEW(arena, double, coordinates);
  m->factor = KM_ARENA_NEW(arena, double, coordinates);
  m->unit = KM_ARENA_NEW(arena, double, coordinates);
  m->ball_of = KM_ARENA_NEW(arena, int, coordinates);
  m->ball_coordinate = KM_ARENA_NEW(arena, int, coordinates);
  m->ball_order = KM_ARENA_NEW(arena, int, coordinates);
  m->substructure_of = KM_ARENA_NEW(arena, int, coordinates);
  m->column_of = KM_ARENA_NEW(arena, int, coordinates);
  m->column_coordinate = KM_ARENA_NEW(arena, int, coordinates);
  m->column_weight = KM_ARENA_NEW(arena, double, coordinates);
  m->limited_column = KM_ARENA_NEW(arena, int, coordinates);
  m->substructures = KM_ARENA_NEW(arena, km_substructure, substructures);
  m->programs = KM_ARENA_NEW(arena, km_program, loops);
  m->loops = KM_ARENA_NEW(arena, km_loop, loops);
  m->loop_order = KM_ARENA_NEW(arena, int, loops);
  m->steps = KM_ARENA_NEW(arena, km_step, steps);
  m->planar_steps = KM_ARENA_NEW(arena, km_planar_step, steps);
  m->entries = KM_ARENA_NEW(arena, km_entry, entries);
  m->couplings = KM_ARENA_NEW(arena, km_coupling, (size_t)m->model->coupling_count);
  m->terms = KM_ARENA_NEW(arena, km_term, terms);
  m->curves = KM_ARENA_NEW(arena, double, curves);
  m->arcs = KM_ARENA_NEW(arena, km_arc, bodies);
  m->arc_of = KM_ARENA_NEW(arena, int, bodies);
  return km_compile_workspace_create(m, steps, arena, workspace);
}

/* Characteristic length: given, stated by the model, longest link, or one length unit. */
static void set_characteristic_length(km_mechanism *m, const km_compiling *options,
                                      const km_compile_workspace *workspace) {
  const km_model *model = m->model;
  if (options->length > 0.0) {
    m->length = options->length;
    m->length_source = options->length_source;
  } else if (model->characteristic_length > 0.0) {
    m->length = model->characteristic_length;
    m->length_source = model->length_shared ? KM_LENGTH_SHARED : KM_LENGTH_STATED;
  } else {
    double link = km_longest_link(m, workspace->parent);
    m->length = link > 0.0 ? link : 1.0;
    m->length_source = link > 0.0 ? KM_LENGTH_LONGEST_LINK : KM_LENGTH_UNIT;
  }
}

double km_mechanism_characteristic_length(const km_mechanism *m, km_length_source *source) {
  if (!m)
    return nan("");
  if (source)
    *source = m->length_source;
  return m->length;
}

const char *km_length_source_name(km_length_source source) {
  static const char *const names[] = {"stated", "first model's", "longest link", "greatest distance between two joints",
                                      "one length unit"};
  return (size_t)source < sizeof names / sizeof *names ? names[source] : "";
}

/* Converts the data of coordinates to radians and lengths; held coordinates get their values. */
static void set_coordinates(km_mechanism *m, const km_hold *holds, int hold_count) {
  const km_model *model = m->model;
  for (int c = 0; c < m->coordinate_count; ++c) {
    const km_model_coordinate *def = &model->coordinates[c];
    double factor = km_model_coordinate_factor(model, c);
    bool length = km_model_coordinate_is_length(model, c);
    m->factor[c] = factor;
    m->start[c] = factor * def->position;
    m->start_rate[c] = factor * def->rate;
    m->start_stated[c] = def->rate_stated;
    m->low[c] = factor * def->low;
    m->high[c] = factor * def->high;
    double max_angle = def->index == 0 ? model->joints[def->joint].most_turn : 0.0;
    m->max_ball_angle[c] = max_angle > 0.0 ? factor * max_angle : HUGE_VAL;
    m->max_rate[c] = factor * def->max_rate;
    m->max_force[c] = def->max_force;
    m->armature[c] = def->armature;
    m->friction[c] = def->friction;
    m->scale[c] = length ? 1.0 / m->length : 1.0;
    m->unit[c] = 1.0;
    m->ball_of[c] = -1;
    m->substructure_of[c] = m->topology.substructure_of_joint[def->joint];
    m->column_of[c] = -1;
  }
  for (int h = 0; h < hold_count; ++h) {
    m->held[holds[h].coordinate] = true;
    m->start_rate[holds[h].coordinate] = 0.0;
    m->start_stated[holds[h].coordinate] = false;
    m->start[holds[h].coordinate] = holds[h].value * km_model_coordinate_factor(model, holds[h].coordinate);
  }
}

/* Numbers the ball motions of all joints. */
static void number_balls(km_mechanism *m) {
  for (int j = 0; j < m->model->joint_count; ++j) {
    const km_joint_kind *kind = km_joint_kind_of(m->model->joints[j].type);
    int c = m->model->joints[j].first_coordinate;
    for (int i = 0; i < kind->motion_count; ++i) {
      const km_primitive primitive = kind->motions[i].primitive;
      for (int k = 0; k < 3 && primitive == KM_BALL; ++k)
        m->ball_of[c + k] = m->ball_count;
      if (primitive == KM_BALL)
        m->ball_coordinate[m->ball_count++] = c;
      c += km_primitive_freedom(primitive);
    }
  }
}

/* Larger of `max_square` and the squared distances between the joints' frames on one body. */
static double max_squared_distance(const km_mechanism *m, const km_model_joint *a, const km_model_joint *b,
                                   double max_square) {
  const km_model_frame *frames = m->model->frames;
  for (int e = 0; e < 2; ++e) {
    const km_model_frame *one = &frames[a->frame[e]];
    for (int f = 0; f < 2; ++f) {
      const km_model_frame *other = &frames[b->frame[f]];
      if (one->body == other->body)
        max_square = km_larger(km_squared_distance(one->pose.p, other->pose.p, m->position_rounding), max_square);
    }
  }
  return max_square;
}

/* Span of a substructure: the larger of the greatest distance between two joints on one body of a loop, and the largest
 * pitch of a screw. */
static double span_of(const km_mechanism *m, int s) {
  const km_topology *t = &m->topology;
  const km_model *model = m->model;
  double square = 0.0, pitch = 0.0;
  for (int i = t->loop_start[s]; i < t->loop_start[s + 1]; ++i) {
    int loop = t->loop[i], first = t->member_start[loop], end = t->member_start[loop + 1];
    for (int k = first; k < end; ++k) {
      const km_model_joint *joint = &model->joints[t->member[k].joint];
      for (int o = first; o < k; ++o)
        square = max_squared_distance(m, joint, &model->joints[t->member[o].joint], square);
      pitch = km_larger(fabs(joint->pitch), pitch);
    }
  }
  return km_larger(sqrt(square), pitch);
}

/* Length unit of a substructure at q: its span, or its longest slide. */
double km_substructure_size(const km_mechanism *m, int s, const double *q) {
  const km_topology *t = &m->topology;
  const km_model *model = m->model;
  double size = m->substructures[s].span;
  for (int i = t->joint_start[s]; i < t->joint_start[s + 1]; ++i) {
    const km_model_joint *joint = &model->joints[t->joint[i]];
    for (int k = 0; k < km_model_freedom(model, t->joint[i]); ++k)
      if (km_joint_is_length(joint->type, k))
        size = km_larger(fabs(q[joint->first_coordinate + k]), size);
  }
  return size > 0.0 ? size : m->length;
}

/* Appends the free coordinates of a joint as columns of its substructure; only counts them if `next` is NULL. */
static void append_columns(km_mechanism *m, int joint, int *next) {
  int s = m->topology.substructure_of_joint[joint];
  if (s < 0)
    return;
  int first = m->model->joints[joint].first_coordinate;
  for (int c = first; c < first + km_model_freedom(m->model, joint); ++c) {
    if (next && km_joint_is_length(m->model->joints[joint].type, c - first))
      m->unit[c] = m->substructures[s].size;
    if (m->held[c])
      continue;
    m->column_of[c] = m->substructures[s].columns++;
    if (!next)
      continue;
    m->column_weight[next[s]] = m->scale[c] * m->unit[c];
    m->column_coordinate[next[s]++] = c;
  }
}

/* Appends all columns: tree joints by level, then chords. */
static void append_all_columns(km_mechanism *m, int *next) {
  const km_topology *t = &m->topology;
  for (int i = 1; i < t->body_count; ++i)
    append_columns(m, t->arc[t->order[i]], next);
  for (int l = 0; l < t->loop_count; ++l)
    append_columns(m, t->chord[l], next);
}

/* Numbers the columns of every substructure. */
static void set_columns(km_mechanism *m, int *next) {
  int used = 0;
  append_all_columns(m, NULL);
  for (int s = 0; s < m->topology.substructure_count; ++s) {
    m->substructures[s].column_start = next[s] = used;
    used += m->substructures[s].columns;
    m->substructures[s].columns = 0;
  }
  append_all_columns(m, next);
}

/* Lists the ball motions of each substructure, after set_columns. */
static void order_balls(km_mechanism *m) {
  int used = 0;
  for (int s = 0; s < m->topology.substructure_count; ++s) {
    km_substructure *sub = &m->substructures[s];
    sub->ball_start = used;
    for (int k = 0; k < sub->columns; ++k) {
      int c = m->column_coordinate[sub->column_start + k], ball = m->ball_of[c];
      if (ball >= 0 && m->ball_coordinate[ball] == c)
        m->ball_order[used++] = ball;
    }
    sub->ball_count = used - sub->ball_start;
  }
}

/* Lists the columns with limits of every substructure. */
static void list_limited_columns(km_mechanism *m) {
  for (int s = 0; s < m->topology.substructure_count; ++s) {
    km_substructure *sub = &m->substructures[s];
    const int *coordinate = m->column_coordinate + sub->column_start;
    sub->limited_count = 0;
    for (int k = 0; k < sub->columns; ++k) {
      int c = coordinate[k];
      if (km_is_limited(m, c))
        m->limited_column[sub->column_start + sub->limited_count++] = k;
    }
  }
}

/* Linear coupling: Σ ratio · q = constant. The constant is that of the file, also if a coordinate is held at another
 * value. */
static void set_ratios(km_mechanism *m, const km_model_coupling *def, km_coupling *out) {
  double max_square = 0.0, constant = 0.0;
  for (int k = 0; k < def->count; ++k)
    max_square = fmax(max_square, fabs(def->ratios[k] * m->unit[def->coordinates[k]]));
  for (int k = 0; k < def->count; ++k) {
    int c = def->coordinates[k];
    m->terms[m->term_count++] =
        (km_term){.coordinate = c, .column = m->column_of[c], .coefficient = def->ratios[k] * m->unit[c] / max_square};
    constant +=
        def->ratios[k] / max_square * m->model->coordinates[c].position * km_model_coordinate_factor(m->model, c);
  }
  out->constant = def->constant_given ? def->constant / max_square : constant;
}

/* Polynomial coupling: q1 − Σ c_k q2^k = 0, scaled by the largest derivative at the start. */
static void set_polynomial(km_mechanism *m, const km_model_coupling *def) {
  int one = def->coordinates[0], two = def->coordinates[1];
  double x = m->start[two], slope = 0.0, power = 1.0;
  for (int k = def->polynomial_count - 1; k > 0; --k)
    slope = slope * x + k * def->polynomial[k];
  double max_square = fmax(m->unit[one], fabs(slope) * m->unit[two]);
  m->terms[m->term_count++] =
      (km_term){.coordinate = one, .column = m->column_of[one], .coefficient = m->unit[one] / max_square};
  m->terms[m->term_count++] = (km_term){.coordinate = two,
                                        .column = m->column_of[two],
                                        .curve_start = m->curve_size,
                                        .curve_count = def->polynomial_count};
  for (int k = 0; k < def->polynomial_count; ++k, power *= m->unit[two])
    m->curves[m->curve_size++] = -def->polynomial[k] * power / max_square;
}

/* Appends the couplings of a substructure as rows. */
static void set_couplings(km_mechanism *m, int s) {
  km_substructure *sub = &m->substructures[s];
  sub->coupling_start = m->coupling_count;
  for (int i = 0; i < m->model->coupling_count; ++i) {
    const km_model_coupling *def = &m->model->couplings[i];
    if (m->substructure_of[def->coordinates[0]] != s)
      continue;
    km_coupling *coupling = &m->couplings[m->coupling_count++];
    *coupling = (km_coupling){.row = sub->rows++, .term_start = m->term_count, .term_count = def->count};
    if (def->polynomial_count > 0)
      set_polynomial(m, def);
    else
      set_ratios(m, def, coupling);
  }
  sub->coupling_count = m->coupling_count - sub->coupling_start;
}

/* Compiles the loops and couplings of a substructure and numbers its rows. */
static void compile_substructure(km_mechanism *m, int s, km_compile_workspace *workspace) {
  const km_topology *t = &m->topology;
  km_substructure *sub = &m->substructures[s];
  sub->loop_start = t->loop_start[s];
  sub->loop_count = t->loop_start[s + 1] - t->loop_start[s];
  for (int i = 0; i < sub->loop_count; ++i)
    m->loop_order[sub->loop_start + i] = t->loop[sub->loop_start + i];
  km_compile_loops(m, s, workspace);
  set_couplings(m, s);
  sub->error_start = m->error_size;
  m->error_size += sub->rows;
  if (sub->rows > m->largest_rows)
    m->largest_rows = sub->rows;
  if (sub->columns > m->largest_columns)
    m->largest_columns = sub->columns;
}

/* Sets the storage of all Jacobians. False when out of memory. */
static bool set_patterns(km_mechanism *m) {
  for (int s = 0; s < m->topology.substructure_count; ++s) {
    km_substructure *sub = &m->substructures[s];
    if (!km_compile_pattern(m, sub))
      return false;
    sub->matrix_start = m->matrix_size;
    m->matrix_size += sub->pattern.size;
  }
  return true;
}

/* Lists the tree joints of all bodies by level, with their constant displacements. */
static void set_arcs(km_mechanism *m) {
  const km_topology *t = &m->topology;
  m->arc_of[0] = -1;
  for (int i = 1; i < t->body_count; ++i) {
    int body = t->order[i], joint = t->arc[body];
    m->arc_of[body] = i - 1;
    bool is_reversed = t->is_reversed[joint];
    const km_model_joint *def = &m->model->joints[joint];
    m->arcs[i - 1] = (km_arc){.body = body,
                              .parent = t->parent[body],
                              .joint = joint,
                              .is_reversed = is_reversed,
                              .before = m->model->frames[def->frame[is_reversed]].pose,
                              .after = km_pose_inverse(&m->model->frames[def->frame[!is_reversed]].pose)};
  }
}

/* Compiles all numbers of the model into the mechanism's arrays. */
void km_compile_values(km_mechanism *m, const km_compiling *options, km_compile_workspace *workspace) {
  m->position_rounding = km_position_rounding(m->model);
  set_characteristic_length(m, options, workspace);
  set_coordinates(m, options->holds, options->hold_count);
  number_balls(m);
  for (int s = 0; s < m->topology.substructure_count; ++s) {
    m->substructures[s].span = span_of(m, s);
    m->substructures[s].size = km_substructure_size(m, s, m->start);
  }
  set_columns(m, workspace->next_column);
  order_balls(m);
  list_limited_columns(m);
  for (int s = 0; s < m->topology.substructure_count; ++s)
    compile_substructure(m, s, workspace);
  set_arcs(m);
}

/* Builds the topology, then compiles numbers and Jacobian patterns. */
static km_status compile_mechanism(km_mechanism *m, const km_compiling *options, km_error *error) {
  km_status status = build_topology(m, options->cuts_balls, error);
  km_compile_workspace workspace;
  if (status)
    return status;
  m->coordinate_count = m->model->coordinate_count;
  m->holds = KM_ARENA_NEW(&m->arena, km_hold, (size_t)options->hold_count);
  if (!m->holds || !km_compile_allocate(m, &workspace))
    return km_fail(error, KM_MEMORY, "out of memory while compiling the mechanism");
  if (options->hold_count)
    memcpy(m->holds, options->holds, (size_t)options->hold_count * sizeof *m->holds);
  m->hold_count = options->hold_count;
  km_compile_values(m, options, &workspace);
  return set_patterns(m) ? KM_OK : km_fail(error, KM_MEMORY, "out of memory while compiling the mechanism");
}

/* A ball joint must be held with all three components. */
static km_status check_held_ball(const km_model *model, const km_hold *holds, int count, int h, km_error *error) {
  int joint = model->coordinates[holds[h].coordinate].joint, held_components = 0;
  for (int k = 0; k < count; ++k)
    held_components +=
        model->coordinates[holds[k].coordinate].joint == joint && km_model_turns(model, holds[k].coordinate);
  return held_components == 3
             ? KM_OK
             : km_fail(error, KM_USAGE,
                       "\"%s\" is a component of a rotation vector; expected all three of joint \"%s\" together",
                       model->coordinates[holds[h].coordinate].label, model->joints[joint].label);
}

/* Checks indices and values of held coordinates. */
static km_status check_holds(const km_model *model, const km_hold *holds, int count, km_error *error) {
  km_status status = km_check_list(holds, count, "holds", error);
  for (int h = 0; h < count && !status; ++h) {
    status = km_check_index(holds[h].coordinate, model->coordinate_count, "coordinate", error);
    if (!status && !isfinite(holds[h].value))
      status = km_fail(error, KM_USAGE, "joint \"%s\" can't be held at %g; expected a finite value",
                       model->coordinates[holds[h].coordinate].label, holds[h].value);
  }
  for (int h = 0; h < count && !status; ++h)
    if (km_model_turns(model, holds[h].coordinate))
      status = check_held_ball(model, holds, count, h, error);
  return status;
}

km_hold *km_model_list_holds(const km_model *model) {
  km_hold *holds = KM_NEW(km_hold, (size_t)model->hold_count + 1);
  for (int i = 0; holds && i < model->hold_count; ++i)
    holds[i] = (km_hold){model->holds[i].coordinate, model->holds[i].value};
  return holds;
}

km_status km_mechanism_compile_as(const km_model *model, const km_compiling *options, km_mechanism **out,
                                  km_error *error) {
  *out = NULL;
  km_status status = check_holds(model, options->holds, options->hold_count, error);
  if (status)
    return status;
  km_mechanism *m = KM_NEW(km_mechanism, 1);
  if (!m)
    return km_fail(error, KM_MEMORY, "out of memory while compiling the mechanism");
  m->model = model;
  m->closure_tolerance = options->closure_tolerance > 0.0 ? options->closure_tolerance : model->closure_tolerance;
  m->closure_tolerance_given = options->closure_tolerance > 0.0 || model->closure_tolerance_given;
  status = compile_mechanism(m, options, error);
  if (status)
    km_mechanism_free(m);
  else
    *out = m;
  return status;
}

void km_mechanism_free(km_mechanism *m) {
  if (!m)
    return;
  km_mechanism_free(m->spare);
  km_arena_free(&m->arena);
  km_free(m);
}
