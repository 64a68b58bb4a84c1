/* Assembly modes: the configurations that close the loops with the driver fixed. */
#include "kmech/mechanism.h"

#include "base/arguments.h"
#include "kinematics/assembly.h"
#include "kinematics/body_poses.h"
#include "kinematics/loop_closing.h"
#include "kinematics/mode_identity.h"

#include <stdint.h>
#include <string.h>

static const double different = 1e-6; /* of a body's place, lengths over the substructure's size */

/* One mode, while others are looked for. */
typedef struct mode {
  double *saved;  /* [3 · columns] saved coordinates */
  km_pose *place; /* [body] in the inertial frame */
  int finds;      /* starts that led to it */
  bool is_within; /* the joint limits */
} mode;

typedef struct search {
  const km_mechanism *m;
  km_state *s; /* with the driver locked */
  const km_state *original;
  int driver, substructure;
  km_arena arena;
  double *saved, *way; /* [3 · columns], [columns] workspace */
  km_body_placement *places;
  mode *modes;
  size_t capacity;
  int count, closed;
  bool moves; /* a mode has a mobility above 0 */
  uint64_t random;
  km_progress progress;
  void *context;
  bool cancelled;
} search;

/* splitmix64, -1 … 1. */
static double uniform(search *f) {
  uint64_t z = (f->random += 0x9E3779B97F4A7C15u);
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
  return (double)((z ^ (z >> 31)) >> 11) * 0x1p-52 - 1.0;
}

static const km_substructure *sub_of(const search *f) {
  return &f->m->substructures[f->substructure];
}

static int coordinate_of(const search *f, int column) {
  return f->m->column_coordinate[sub_of(f)->column_start + column];
}

/* A random start from the state's configuration: hinges anywhere, slides within the size of the substructure; what is
 * locked stays. */
static void scatter(search *f) {
  const km_substructure *sub = sub_of(f);
  for (int k = 0; k < sub->columns; ++k) {
    int c = coordinate_of(f, k);
    f->way[k] = f->s->locked[c] ? 0.0 : uniform(f) * (km_model_coordinate_is_length(f->m->model, c) ? 1.0 : M_PI);
  }
  km_state_move(f->m, f->s, sub, f->way);
}

static bool close(search *f) {
  bool closed;
  f->arena.failed = km_assemble_one(f->m, f->s, f->substructure, f->saved, &closed) || f->arena.failed;
  return closed;
}

static int body_of(const km_mechanism *m, int joint, int end) {
  return m->model->frames[m->model->joints[joint].frame[end]].body;
}

/* True if the coordinate belongs to the strut's slide or to the joint at either end. */
static bool belongs_to_strut(const km_mechanism *m, int strut, int coordinate) {
  int slide = m->model->coordinates[strut].joint, joint = m->model->coordinates[coordinate].joint;
  return joint == slide || body_of(m, joint, 1) == body_of(m, slide, 0) || body_of(m, joint, 0) == body_of(m, slide, 1);
}

static void lock_driver(search *f) {
  km_state_unlock(f->s);
  if (f->driver >= 0)
    km_state_lock(f->s, f->driver);
}

/* Turns a strut of negative length round: its length is |q|, its own joints are found anew, and all others stay.
 * False, with the state as it was, if no start closes. */
static bool turn_strut(search *f, int strut) {
  enum { STARTS = 40 };
  const km_substructure *sub = sub_of(f);
  size_t size = (size_t)(KM_SAVED_PER_COLUMN * sub->columns);
  double *before = KM_NEW(double, size);
  bool turned = false;
  f->arena.failed = f->arena.failed || !before;
  if (!before)
    return false;
  km_state_save(f->s, sub, before);
  km_state_lock(f->s, strut);
  for (int k = 0; k < sub->columns; ++k)
    if (!belongs_to_strut(f->m, strut, coordinate_of(f, k)))
      km_state_lock(f->s, coordinate_of(f, k));
  for (int i = 0; i < STARTS && !turned; ++i) {
    km_state_restore(f->s, sub, before);
    f->s->q[strut] = fabs(f->s->q[strut]);
    scatter(f);
    turned = close(f);
  }
  lock_driver(f);
  if (!turned)
    km_state_restore(f->s, sub, before);
  km_free(before);
  return turned;
}

/* Hinges come within half a turn of where the state has them, or by further turns within their limits. */
static void choose_turns(search *f) {
  const km_substructure *sub = sub_of(f);
  for (int k = 0; k < sub->columns && sub->coupling_count == 0; ++k) {
    int c = coordinate_of(f, k);
    double *q = &f->s->q[c];
    if (!km_coordinate_turns(f->m, c))
      continue;
    double turn = remainder(*q - f->original->q[c], 2.0 * M_PI);
    *q = f->original->q[c] + (turn < different - M_PI ? turn + 2.0 * M_PI : turn);
    if (*q > f->m->high[c])
      *q -= 2.0 * M_PI * ceil((*q - f->m->high[c]) / (2.0 * M_PI));
    else if (*q < f->m->low[c])
      *q += 2.0 * M_PI * ceil((f->m->low[c] - *q) / (2.0 * M_PI));
  }
}

/* Normalises the configuration: strut lengths of at least 0, hinge turns nearest to the original ones or within
 * limits. False: a strut can't be turned round. */
static bool make_canonical(search *f) {
  bool turned = true;
  for (int k = 0; k < sub_of(f)->columns; ++k) {
    int c = coordinate_of(f, k);
    if (f->m->model->coordinates[c].is_strut && f->s->q[c] < 0.0 && c != f->driver)
      turned = turn_strut(f, c) && turned;
  }
  choose_turns(f);
  return turned;
}

/* The mode that the state's configuration is; -1: a new one. */
static int find_known(const search *f) {
  double size = sub_of(f)->size;
  km_poses_compute(f->m, f->s);
  for (int i = 0; i < f->count; ++i)
    if (km_is_same_mode(f->m, f->places, f->modes[i].place, f->s->pose, size, different))
      return i;
  return -1;
}

static bool keep(search *f) {
  size_t bodies = (size_t)f->m->model->body_count;
  void *modes = f->modes;
  mode kept = {.saved = KM_ARENA_NEW(&f->arena, double, (size_t)(KM_SAVED_PER_COLUMN * sub_of(f)->columns)),
               .place = KM_ARENA_NEW(&f->arena, km_pose, bodies),
               .finds = 1};
  if (f->arena.failed || !km_reserve(&modes, &f->capacity, (size_t)f->count + 1, sizeof *f->modes))
    return false;
  f->modes = modes;
  f->moves = f->moves || km_partition_freedom(&f->s->partition[f->substructure]) > 0;
  memcpy(kept.place, f->s->pose, bodies * sizeof *kept.place);
  bool is_own = f->count == 0;
  kept.is_within = is_own || (make_canonical(f) && km_state_find_outside_limit(f->s, sub_of(f)) < 0);
  km_state_save(f->s, sub_of(f), kept.saved);
  f->modes[f->count++] = kept;
  return !f->arena.failed;
}

/* Counts the state's configuration. False when out of memory. */
static bool count_find(search *f) {
  int known = find_known(f);
  ++f->closed;
  if (known < 0)
    return keep(f);
  ++f->modes[known].finds;
  return true;
}

static bool collect(search *f, int starts) {
  if (!count_find(f))
    return false;
  for (int i = 0; i < starts; ++i) {
    f->cancelled = f->progress && !f->progress(f->context, (double)i / starts);
    if (f->cancelled)
      return false;
    km_state_restore(f->s, sub_of(f), f->modes[0].saved);
    scatter(f);
    if ((close(f) && !count_find(f)) || f->arena.failed)
      return false;
  }
  return true;
}

/* Returns the coordinate for output. What closing the loops leaves of 0 is written as 0. */
static double written(const search *f, int c) {
  static const double rounding = 1e-12; /* radians, or substructure sizes */
  if (f->m->substructure_of[c] != f->substructure)
    return km_state_coordinate(f->original, c);
  return fabs(f->s->q[c]) <= rounding * f->m->unit[c] ? 0.0 : km_state_coordinate(f->s, c);
}

static bool write_out(search *f, km_modes *out) {
  int n = f->m->coordinate_count;
  out->coordinates = KM_NEW(double, (size_t)f->count *(size_t)n);
  if (!out->coordinates)
    return false;
  for (int i = 0; i < f->count; ++i) {
    out->once += f->modes[i].finds == 1;
    out->outside += !f->modes[i].is_within;
    if (!f->modes[i].is_within)
      continue;
    km_state_restore(f->s, sub_of(f), f->modes[i].saved);
    for (int c = 0; c < n; ++c)
      out->coordinates[(size_t)out->count * (size_t)n + (size_t)c] = written(f, c);
    ++out->count;
  }
  out->closed = f->closed;
  return true;
}

static km_status search_modes(search *f, int starts, km_modes *out, km_error *error) {
  size_t columns = (size_t)sub_of(f)->columns;
  f->saved = KM_ARENA_NEW(&f->arena, double, KM_SAVED_PER_COLUMN *columns);
  f->way = KM_ARENA_NEW(&f->arena, double, columns);
  f->places = KM_ARENA_NEW(&f->arena, km_body_placement, (size_t)f->m->model->body_count);
  bool done = !f->arena.failed, moves = false, is_closed = true;
  if (done) {
    f->arena.failed = !km_body_placements(f->m, f->places);
    km_state_copy(f->m, f->s, f->original);
    is_closed = close(f);
    done = is_closed && !f->arena.failed;
    moves = done && f->driver < 0 && km_partition_freedom(&f->s->partition[f->substructure]) > 0;
    done = done && !moves && collect(f, starts) && write_out(f, out);
  }
  out->isolated = done && !f->moves;
  bool is_open = !is_closed && !f->arena.failed;
  km_free(f->modes);
  km_arena_free(&f->arena);
  if (is_open)
    return km_fail(error, KM_USAGE, "the loops of the state are open; expected an assembled one");
  if (moves)
    return km_fail(
        error, KM_USAGE,
        "assembly modes need a driver, since the mechanism moves: the model has no analysis.sweep with a joint; "
        "expected one by --set");
  if (f->cancelled)
    return km_fail(error, KM_CANCELLED, "the search for assembly modes was cancelled");
  return done ? KM_OK : km_fail(error, KM_MEMORY, "out of memory for the assembly modes");
}

/* The substructure with most coordinates; -1: nothing is in a loop. */
static int largest_substructure(const km_mechanism *m) {
  int best = -1;
  for (int i = 0; i < m->topology.substructure_count; ++i)
    if (m->substructures[i].loop_count > 0 &&
        (best < 0 || m->substructures[i].columns > m->substructures[best].columns))
      best = i;
  return best;
}

static km_status check_driver(const km_mechanism *m, int driver, km_error *error) {
  if (driver == -1)
    return largest_substructure(m) >= 0
               ? KM_OK
               : km_fail(error, KM_USAGE, "the model has no loop; expected one that closes in different ways");
  km_status status = km_check_index(driver, m->coordinate_count, "coordinate", error);
  if (!status && (m->held[driver] || m->substructure_of[driver] < 0 || m->ball_of[driver] >= 0))
    status =
        km_fail(error, KM_USAGE, "joint \"%s\" can't be the driver of assembly modes; expected a free joint of a loop",
                m->model->coordinates[driver].label);
  return status;
}

km_status km_modes_find(const km_mechanism *m, const km_state *s, int driver, int starts, unsigned long seed,
                        km_progress progress, void *context, km_modes *out, km_error *error) {
  if (!out)
    return km_check_given(false, "place for the result", error);
  *out = (km_modes){0};
  km_state *state = NULL;
  km_status status = km_check_state(m, s, error);
  if (!status && (starts < 0 || starts > KM_MAX_MODE_STARTS))
    status = km_fail(error, KM_USAGE, "%d starts; expected 0 to %d", starts, KM_MAX_MODE_STARTS);
  if (!status)
    status = check_driver(m, driver, error);
  if (!status)
    status = km_state_create(m, &state, error);
  if (!status) {
    search f = {.m = m,
                .s = state,
                .original = s,
                .driver = driver,
                .substructure = driver >= 0 ? m->substructure_of[driver] : largest_substructure(m),
                .random = seed,
                .progress = progress,
                .context = context};
    lock_driver(&f);
    status = search_modes(&f, starts, out, error);
  }
  km_state_free(state);
  return status;
}

void km_modes_free(km_modes *modes) {
  if (!modes)
    return;
  km_free(modes->coordinates);
  *modes = (km_modes){0};
}
