/* Velocities and accelerations along a sweep, for a constant rate ω of the driver (docs/theory.md 10.6).
 *
 *   q' = dq/ds, J q' = 0, q'_driver = 1;   J q'' = γ(q'), q''_driver = 0;   q̇ = ω q', q̈ = ω² q''
 *   point   : p, v, a by the twists of its body;  path ∫ |v| dt;  curvature |v × a|/|v|³
 *   between two rows quintics through p, v, a, and through q, q̇, q̈, whose extremes are those of the swing
 *
 * Several freedoms leave q'' undetermined: accelerations are then NaN. */
#include "base/event_locator.h"
#include "base/number/gauss_legendre.h"
#include "base/number/tolerances.h"
#include "base/table.h"
#include "base/text.h"
#include "kinematics/body_poses.h"
#include "kinematics/loop_equations.h"
#include "kinematics/minimum_norm_step.h"
#include "sweep/sweep_observer.h"

#include <math.h>
#include <string.h>

typedef struct sweep_motion {
  km_motion_sweep *out;
  km_observer observer;
  km_arena arena;
  double factor; /* rate of s per time unit, radians or the model's length */
  double *rate;  /* [coordinate] q̇ and q̈ of the row, radians and the model's length */
  double *acceleration;
  double *gamma, *x, *t; /* [rows or columns of the moving substructure] */
  km_body_motion *bodies;
  double *path;         /* [point] length so far */
  double (*last)[3][3]; /* [point] place, velocity and acceleration in the last row */
  double first_s, last_s;
  size_t first_cell; /* cell of the first velocity */
  bool is_begun;
} sweep_motion;

static bool add_vector(km_table *table, const char *prefix, const char *name, const char *kind, const char *unit) {
  static const char *const axes[3] = {"x", "y", "z"};
  bool added = true;
  for (int k = 0; k < 3; ++k) {
    char suffix[16] = ".";
    strcat(strcat(suffix, kind), axes[k]);
    added = km_table_add_joined_column(table, prefix, name, suffix, unit) && added;
  }
  return added;
}

static bool add_coordinates(const km_sweeper *r, const char *prefix, const char *per, km_table *table) {
  bool added = true;
  for (int c = 0; c < r->m->coordinate_count && added; ++c) {
    km_text unit = {0};
    km_text_format(&unit, "%s/%s", km_model_coordinate_unit(r->m->model, c), per);
    added = !unit.failed && km_table_add_joined_column(table, prefix, r->m->model->coordinates[c].label, "", unit.data);
    km_text_free(&unit);
  }
  return added;
}

static bool add_point(const km_sweeper *r, const char *name, km_table *table) {
  const char *length = r->m->model->units.length->suffix, *time = r->m->model->units.time->suffix;
  km_text velocity = {0}, acceleration = {0}, curvature = {0};
  km_text_format(&velocity, "%s/%s", length, time);
  km_text_format(&acceleration, "%s/%s^2", length, time);
  km_text_format(&curvature, "1/%s", length);
  bool added = !velocity.failed && !acceleration.failed && !curvature.failed &&
               add_vector(table, "point.", name, "v", velocity.data) &&
               add_vector(table, "point.", name, "a", acceleration.data) &&
               km_table_add_joined_column(table, "point.", name, ".speed", velocity.data) &&
               km_table_add_joined_column(table, "point.", name, ".path", length) &&
               km_table_add_joined_column(table, "point.", name, ".curvature", curvature.data);
  km_text_free(&velocity);
  km_text_free(&acceleration);
  km_text_free(&curvature);
  return added;
}

static bool add_columns(void *self, const km_sweeper *r, km_table *table) {
  sweep_motion *w = self;
  const km_model *model = r->m->model;
  const char *time = model->units.time->suffix;
  km_text square = {0}, turn = {0}, turn_rate = {0};
  km_text_format(&square, "%s^2", time);
  km_text_format(&turn, "rad/%s", time);
  km_text_format(&turn_rate, "rad/%s^2", time);
  bool added = !square.failed && !turn.failed && !turn_rate.failed;
  added = added && km_table_add_joined_column(table, "", "t", "", time);
  w->first_cell = km_table_columns(table);
  added = added && add_coordinates(r, "v.", time, table) && add_coordinates(r, "a.", square.data, table);
  for (int b = 1; b < r->m->topology.body_count; ++b)
    added = added && add_vector(table, "body.", model->bodies[b].name, "w", turn.data) &&
            add_vector(table, "body.", model->bodies[b].name, "alpha", turn_rate.data);
  for (int i = 0; i < r->plan->point_count; ++i)
    added = added && add_point(r, r->plan->points[i].name, table);
  km_text_free(&square);
  km_text_free(&turn);
  km_text_free(&turn_rate);
  return added;
}

static void fill(double *values, int count, double value) {
  for (int i = 0; i < count; ++i)
    values[i] = value;
}

/* q'' of the moving substructure from q' (r->rates), into w->acceleration. */
static void compute_second_derivatives(sweep_motion *w, const km_sweeper *r) {
  const km_mechanism *m = r->m;
  const km_substructure *sub = &m->substructures[r->substructure];
  const int *coordinate = m->column_coordinate + sub->column_start;
  int driver = 0;
  km_loops_velocity_products(m, r->s, sub, r->rates, w->gamma);
  km_factor_solve(r->s->factor[r->substructure], w->gamma, w->x);
  km_minimum_norm_step(m, r->s, r->substructure, KM_NO_DRIVER, w->x);
  for (int k = 0; k < sub->columns; ++k) {
    w->t[k] = r->rates[coordinate[k]] / m->unit[coordinate[k]];
    driver = coordinate[k] == r->plan->coordinate ? k : driver;
  }
  double share = w->x[driver] / w->t[driver];
  for (int k = 0; k < sub->columns; ++k)
    w->acceleration[coordinate[k]] = (w->x[k] - share * w->t[k]) * m->unit[coordinate[k]];
}

/* True if the row isn't at a dead point of the driver, where rates are infinite: the square of the driver's entry in
 * the unit direction of motion, |1/D q'|, is as large as the error of a located end there. */
static bool is_regular(const km_sweeper *r) {
  double square = 0.0;
  for (int c = 0; c < r->m->coordinate_count; ++c)
    square += r->m->scale[c] * r->rates[c] * r->m->scale[c] * r->rates[c];
  const double scale = r->m->scale[r->plan->coordinate];
  return scale * scale > km_relative_zero * square;
}

/* Rates and accelerations at the row; NaN where the motion has no direction, and at a dead point of the driver. */
static void compute_rates(sweep_motion *w, km_sweeper *r) {
  int count = r->m->coordinate_count;
  bool moves = km_sweeper_update_rates(r) && is_regular(r),
       determined = r->out->freedom - r->out->passive - r->out->infinitesimal <= 1;
  fill(w->acceleration, count, moves && determined ? 0.0 : nan(""));
  if (moves && determined && r->substructure >= 0)
    compute_second_derivatives(w, r);
  for (int c = 0; c < count; ++c) {
    w->rate[c] = moves ? w->factor * r->rates[c] : nan("");
    w->acceleration[c] *= w->factor * w->factor;
  }
}

static double *write_vector(km_vec3 v, double *cell) {
  km_vec3_write(v, cell);
  return cell + 3;
}

/* Quintic between two rows, by u = 0 … 1. */
typedef struct quintic {
  double c[6];
} quintic;

static quintic quintic_through(double h, const double *a, const double *b) {
  /* a, b: value, first and second derivative */
  double d = b[0] - a[0], v0 = h * a[1], v1 = h * b[1], w0 = h * h * a[2], w1 = h * h * b[2];
  return (quintic){{a[0], v0, 0.5 * w0, 10.0 * d - 6.0 * v0 - 4.0 * v1 - 1.5 * w0 + 0.5 * w1,
                    -15.0 * d + 8.0 * v0 + 7.0 * v1 + 1.5 * w0 - w1, 6.0 * d - 3.0 * (v0 + v1) - 0.5 * (w0 - w1)}};
}

/* Cubic by values and first derivatives alone. */
static quintic cubic_through(double h, const double *a, const double *b) {
  double d = b[0] - a[0], v0 = h * a[1], v1 = h * b[1];
  return (quintic){{a[0], v0, 3.0 * d - 2.0 * v0 - v1, v0 + v1 - 2.0 * d, 0.0, 0.0}};
}

static double value_of(const quintic *q, double u) {
  double sum = 0.0;
  for (int k = 5; k >= 0; --k)
    sum = sum * u + q->c[k];
  return sum;
}

static double slope_of(const quintic *q, double u) {
  double sum = 0.0;
  for (int k = 5; k >= 1; --k)
    sum = sum * u + k * q->c[k];
  return sum;
}

static double curvature_of(const quintic *q, double u) {
  double sum = 0.0;
  for (int k = 5; k >= 2; --k)
    sum = sum * u + k * (k - 1) * q->c[k];
  return sum;
}

/* Slope of a quintic for the event locator. */
static double slope_at(double u, void *q) {
  return slope_of(q, u);
}

/* p'·p'' of the three quintics of a path: half the rate of its squared speed. */
static double speed_change(double u, void *context) {
  const quintic *path = context;
  double sum = 0.0;
  for (int k = 0; k < 3; ++k)
    sum += slope_of(&path[k], u) * curvature_of(&path[k], u);
  return sum;
}

/* ∫ |p'(u)| du from `from` to `to`. */
static double path_piece(const quintic *path, double from, double to) {
  double sum = 0.0;
  for (int i = 0; i < KM_GAUSS_POINTS; ++i) {
    double u = from + (to - from) * km_gauss_node[i], square = 0.0;
    for (int k = 0; k < 3; ++k)
      square += slope_of(&path[k], u) * slope_of(&path[k], u);
    sum += km_gauss_weight[i] * sqrt(square);
  }
  return (to - from) * sum;
}

/* Length of one curve between two rows, in two pieces where its speed is least between them: a path that reverses has a
 * corner there. */
static double curve_length(quintic *path) {
  double first = speed_change(0.0, path), last = speed_change(1.0, path);
  if (!(first < 0.0 && last > 0.0))
    return path_piece(path, 0.0, 1.0);
  double least = km_locate_root(speed_change, path, 0.0, 1.0, first, last);
  return path_piece(path, 0.0, least) + path_piece(path, least, 1.0);
}

/* Two interpolations of an interval that differ by more than this part don't resolve it: near a dead point of the
 * driver rates grow without bound. */
static const double most_difference = 0.02;

/* Length of a path between two rows: the quintic's if the cubic agrees with it, else the chord. */
static double path_length(double h, double last[3][3], double now[3][3]) {
  quintic path[3], cubic[3];
  double chord = 0.0;
  for (int k = 0; k < 3; ++k) {
    const double from[3] = {last[0][k], last[1][k], last[2][k]}, to[3] = {now[0][k], now[1][k], now[2][k]};
    path[k] = quintic_through(h, from, to);
    cubic[k] = cubic_through(h, from, to);
    chord = hypot(chord, to[0] - from[0]);
  }
  double length = curve_length(path), other = curve_length(cubic);
  return fabs(length - other) <= most_difference * length ? length : chord;
}

static double *write_point(sweep_motion *w, const km_sweeper *r, int index, double dt, double *cell) {
  const km_model_frame *frame = &r->m->model->frames[r->plan->points[index].frame];
  const km_body_motion *b = &w->bodies[frame->body];
  km_vec3 p = km_pose_point(&r->s->pose[frame->body], frame->pose.p);
  km_vec3 v = km_point_velocity(b->V, p), a = km_point_acceleration(b->V, b->A, p);
  double speed = km_vec3_norm(v), (*last)[3] = w->last[index], now[3][3];
  write_vector(a, write_vector(v, write_vector(p, now[0])));
  if (dt > 0.0)
    w->path[index] += path_length(dt, last, now);
  memcpy(last, now, sizeof now);
  cell = write_vector(a, write_vector(v, cell));
  *cell++ = speed;
  *cell++ = w->path[index];
  *cell++ = speed > 0.0 ? km_vec3_norm(km_vec3_cross(v, a)) / (speed * speed * speed) : nan("");
  return cell;
}

static double *write_cells(void *self, km_sweeper *r, double *cell) {
  sweep_motion *w = self;
  const km_mechanism *m = r->m;
  double s = km_table_row(w->out->motion.table, km_table_rows(w->out->motion.table) - 1)[1];
  compute_rates(w, r);
  km_poses_compute(m, r->s);
  km_body_motions(m, r->s, w->rate, w->acceleration, w->bodies);
  if (!w->is_begun)
    w->first_s = w->last_s = s;
  double unit = km_model_coordinate_factor(m->model, r->plan->coordinate) / w->factor, dt = (s - w->last_s) * unit;
  w->is_begun = true;
  w->last_s = s;
  *cell++ = (s - w->first_s) * unit;
  for (int c = 0; c < m->coordinate_count; ++c)
    *cell++ = w->rate[c] / m->factor[c];
  for (int c = 0; c < m->coordinate_count; ++c)
    *cell++ = w->acceleration[c] / m->factor[c];
  for (int b = 1; b < m->topology.body_count; ++b)
    cell = write_vector(w->bodies[b].A.w, write_vector(w->bodies[b].V.w, cell));
  for (int i = 0; i < r->plan->point_count; ++i)
    cell = write_point(w, r, i, dt, cell);
  return cell;
}

/* Extremum inside an interval in which the rate changes its sign, where the quintic and the cubic agree about it. */
static void take_inside(km_swing *swing, double h, const double *a, const double *b, double s0, double s1) {
  quintic q = quintic_through(h, a, b), cubic = cubic_through(h, a, b);
  const double u = km_locate_root(slope_at, &q, 0.0, 1.0, h * a[1], h * b[1]), value = value_of(&q, u);
  const double rise = fmax(fabs(value - a[0]), fabs(value - b[0]));
  if (fabs(value - value_of(&cubic, u)) <= most_difference * rise)
    km_swing_take(swing, value, s0 + u * (s1 - s0));
}

/* Swing of a coordinate: extremes over the rows and between them. */
static km_swing swing_of(const sweep_motion *w, const km_mechanism *m, int c) {
  const km_table *table = w->out->motion.table;
  size_t v = w->first_cell + (size_t)c, a = v + (size_t)m->coordinate_count, t = w->first_cell - 1;
  km_swing swing = km_swing_over_rows(m, table, c);
  for (size_t i = 1; i < km_table_rows(table); ++i) {
    const double *now = km_table_row(table, i), *last = km_table_row(table, i - 1);
    const double from[3] = {last[2 + c], last[v], last[a]}, to[3] = {now[2 + c], now[v], now[a]};
    if (from[1] * to[1] < 0.0 && isfinite(from[2]) && isfinite(to[2]))
      take_inside(&swing, now[t] - last[t], from, to, last[1], now[1]);
  }
  return swing;
}

static km_status finish(void *self, const km_sweep_job *job) {
  sweep_motion *w = self;
  int count = job->m->coordinate_count;
  w->out->swings = KM_NEW(km_swing, (size_t)count + 1);
  if (!w->out->swings)
    return km_fail(job->error, KM_MEMORY, "out of memory for the swings");
  for (int c = 0; c < count; ++c)
    w->out->swings[c] = swing_of(w, job->m, c);
  w->out->swing_count = count;
  return job->status;
}

static void close_observer(void *self) {
  sweep_motion *w = self;
  km_arena_free(&w->arena);
  km_free(w);
}

static bool allocate(sweep_motion *w, const km_sweep_job *job) {
  size_t coordinates = (size_t)job->m->coordinate_count, rows = 0, points = (size_t)job->plan->point_count;
  for (int i = 0; i < job->m->topology.substructure_count; ++i)
    rows = (size_t)job->m->substructures[i].rows > rows ? (size_t)job->m->substructures[i].rows : rows;
  w->rate = KM_ARENA_NEW(&w->arena, double, coordinates + 1);
  w->acceleration = KM_ARENA_NEW(&w->arena, double, coordinates + 1);
  w->gamma = KM_ARENA_NEW(&w->arena, double, rows + 1);
  w->x = KM_ARENA_NEW(&w->arena, double, coordinates + 1);
  w->t = KM_ARENA_NEW(&w->arena, double, coordinates + 1);
  w->bodies = KM_ARENA_NEW(&w->arena, km_body_motion, (size_t)job->m->topology.body_count);
  w->path = KM_ARENA_NEW(&w->arena, double, points + 1);
  w->last = km_arena_alloc(&w->arena, points + 1, sizeof *w->last);
  return !w->arena.failed;
}

void km_motion_sweep_open(km_sweep_job *job, double rate, km_motion_sweep *out) {
  *out = (km_motion_sweep){.motion = {.substructure = -1}, .rate = rate};
  job->out = &out->motion;
  sweep_motion *w = KM_NEW(sweep_motion, 1);
  if (!w || !allocate(w, job)) {
    if (w)
      close_observer(w);
    job->status = km_fail(job->error, KM_MEMORY, "out of memory for a motion");
    return;
  }
  w->out = out;
  w->factor = rate * km_model_coordinate_factor(job->m->model, job->plan->coordinate);
  w->observer = (km_observer){.self = w,
                              .columns = add_columns,
                              .cells = write_cells,
                              .finish = finish,
                              .close = close_observer,
                              .reads_jacobian = true};
  job->observer = &w->observer;
}

void km_motion_sweep_free(km_motion_sweep *sweep) {
  if (!sweep)
    return;
  km_sweep_free(&sweep->motion);
  km_free(sweep->swings);
  *sweep = (km_motion_sweep){0};
}
