#include "kmech/redundancy.h"

#include "analysis/whole_jacobian.h"
#include "kinematics/closure.h"
#include "kinematics/loops.h"
#include "kinematics/poses.h"

#include <string.h>

/* J: six rows a loop (force and moment balance in the inertial frame's axes about a point near the substructure,
 * lengths over its size), then the couplings. A left null vector holds one wrench (f; τ) a loop. */
typedef struct space {
  const km_mechanism *m;
  km_state *s;
  int index, rows, columns, rank;
  const km_substructure *sub;
  km_vec3 about;
  double tolerance;
  double *J;           /* rows × columns */
  km_twist *twist;     /* [coordinate] */
  double *T, *W, *one; /* transposed; left null vectors; ones */
  int null_count;
  double *all, *reach; /* all left null vectors of J, [all_count × rows]; [2 · all_count] */
  int all_count;
  double *nearby; /* the same a short way along the motion, [nearby_count × rows] */
  int nearby_count;
  km_partition p;
} space;

static bool allocate(space *a, km_arena *arena) {
  size_t rows = (size_t)a->rows, columns = (size_t)a->columns;
  a->J = KM_ARENA_NEW(arena, double, rows *columns);
  a->twist = KM_ARENA_NEW(arena, km_twist, (size_t)a->m->coordinate_count);
  a->T = KM_ARENA_NEW(arena, double, rows *columns);
  a->W = KM_ARENA_NEW(arena, double, rows *rows);
  a->one = KM_ARENA_NEW(arena, double, rows);
  for (size_t i = 0; i < rows && a->one; ++i)
    a->one[i] = 1.0;
  return km_partition_reserve(&a->p, a->columns, a->rows, arena);
}

static void entries(const space *a, km_twist h, double out[6]) {
  km_twist_entries(a->sub, h, a->about, 1.0, out);
}

static void fill(space *a) {
  const int *coordinate = a->m->column_coordinate + a->sub->column_start;
  for (int k = 0; k < a->columns; ++k)
    a->twist[coordinate[k]] = km_coordinate_twist(a->m, a->s, coordinate[k]);
  km_whole_jacobian(a->m, a->index, a->twist, a->about, a->J);
}

/* Rank of rows from … to-1 of J with `columns` columns, and their left null vectors into W (to - from entries each). */
static int left_null(space *a, int from, int to, int columns) {
  int rows = to - from;
  for (int r = 0; r < rows; ++r)
    for (int c = 0; c < columns; ++c)
      a->T[r * columns + c] = a->J[c * a->rows + from + r];
  km_partition_factor(&a->p, a->T, columns, rows, NULL, a->tolerance);
  a->null_count = km_partition_freedom(&a->p);
  km_partition_null(&a->p, a->one, a->null_count, a->W);
  return a->p.rank;
}

/* The part Wᵀh of a new freedom's column that no constraint row combination of the others reaches: W are all left
 * null vectors. */
static void beyond_reach(const space *a, int joint, km_twist h, double *out) {
  const km_topology *t = &a->m->topology;
  int first = t->loop_start[a->index];
  double column[6];
  entries(a, h, column);
  memset(out, 0, (size_t)a->all_count * sizeof *out);
  for (int i = 0; i < a->sub->loop_count; ++i) {
    int loop = t->loop[first + i];
    for (int n = t->member_start[loop]; n < t->member_start[loop + 1]; ++n) {
      if (t->member[n].joint != joint)
        continue;
      double s = km_member_sense(t, loop, &t->member[n]);
      for (int k = 0; k < a->all_count; ++k)
        for (int r = 0; r < 6; ++r)
          out[k] += s * column[r] * a->all[(size_t)k * (size_t)a->rows + (size_t)(6 * i + r)];
    }
  }
}

/* Would one or two new freedoms of a joint, as columns in the loops that it lies in, each raise the rank? */
static bool raises_rank(const space *a, int joint, const km_twist *h, int count) {
  double *x = a->reach, *y = a->reach + a->all_count, xx = 0.0, xy = 0.0, yy = 0.0;
  beyond_reach(a, joint, h[0], x);
  if (count > 1)
    beyond_reach(a, joint, h[1], y);
  for (int k = 0; k < a->all_count; ++k) {
    xx += x[k] * x[k];
    xy += count > 1 ? x[k] * y[k] : 0.0;
    yy += count > 1 ? y[k] * y[k] : 0.0;
  }
  const double least = 1e-10; /* squared: of columns of size about 1 */
  return xx > least && (count == 1 || xx * yy - xy * xy > least * fmax(xx, yy));
}

/* How squarely a twist meets the redundant wrench w (six entries): power over both sizes. */
static double meets(const space *a, km_twist h, const double *w) {
  double column[6], power = 0.0, size = 0.0, wrench = 0.0;
  entries(a, h, column);
  for (int r = 0; r < 6; ++r) {
    power += w[r] * column[r];
    size += column[r] * column[r];
    wrench += w[r] * w[r];
  }
  return size > 0.0 && wrench > 0.0 ? fabs(power) / sqrt(size * wrench) : 0.0;
}

static void add_remedy(km_redundancy *item, km_remedy remedy) {
  int at = item->remedy_count < KM_MOST_REMEDIES ? item->remedy_count++ : KM_MOST_REMEDIES;
  while (at > 0) {
    const km_remedy *before = &item->remedies[at - 1];
    bool better = remedy.freedoms < before->freedoms ||
                  (remedy.freedoms == before->freedoms && remedy.strength > before->strength + 1e-9);
    if (!better)
      break;
    if (at < KM_MOST_REMEDIES)
      item->remedies[at] = *before;
    --at;
  }
  if (at < KM_MOST_REMEDIES)
    item->remedies[at] = remedy;
}

/* Tries the swaps of one hinge or slide of the loop against the wrench. */
static void try_joint(space *a, int joint, const double *w, km_redundancy *item) {
  const km_joint_kind *kind = km_joint_kind_of(a->m->model->joints[joint].type);
  if (kind->freedom != 1 || a->m->held[a->m->model->joints[joint].first_coordinate] ||
      kind->motions[0].primitive == KM_HELICAL)
    return;
  bool hinge = kind->motions[0].primitive == KM_REVOLUTE;
  int k = kind->motions[0].axis;
  km_pose X = km_joint_pose(a->m, a->s, joint);
  km_twist along = km_twist_prismatic(X.R.axis[k]), about = km_twist_revolute(X.R.axis[k], X.p);
  km_twist other = hinge ? along : about; /* what makes the joint cylindrical */
  double strength = meets(a, other, w);
  if (strength > 0.02 && raises_rank(a, joint, &other, 1))
    add_remedy(item, (km_remedy){joint, "cylindrical", 1, strength});
  km_twist turns[2] = {km_twist_revolute(X.R.axis[(k + 1) % 3], X.p), km_twist_revolute(X.R.axis[(k + 2) % 3], X.p)};
  double each[2] = {meets(a, turns[0], w), meets(a, turns[1], w)};
  int best = each[1] > each[0];
  if (hinge && each[best] > 0.02 && raises_rank(a, joint, &turns[best], 1))
    add_remedy(item, (km_remedy){joint, "universal", 1, each[best]});
  if (hinge && each[best] > 0.02 && raises_rank(a, joint, turns, 2))
    add_remedy(item, (km_remedy){joint, "spherical", 2, each[best]});
}

static void find_remedies(space *a, const double *w, km_redundancy *item) {
  const km_topology *t = &a->m->topology;
  for (int i = t->member_start[item->loop]; i < t->member_start[item->loop + 1]; ++i)
    try_joint(a, t->member[i].joint, w, item);
}

/* The left null vectors a short way along the motion: a redundancy that isn't among them was the pose's. */
static void look_nearby(space *a, km_arena *arena) {
  int k = km_partition_freedom(&a->s->partition[a->index]);
  double *saved = KM_ARENA_NEW(arena, double, (size_t)(KM_SAVED_PER_COLUMN * a->columns));
  double *move = KM_ARENA_NEW(arena, double, (size_t)a->columns);
  a->nearby = KM_ARENA_NEW(arena, double, (size_t)a->all_count *(size_t)a->rows);
  a->nearby_count = a->all_count;
  if (arena->failed)
    return;
  memcpy(a->nearby, a->all, (size_t)a->all_count * (size_t)a->rows * sizeof *a->nearby);
  const double *Z = km_state_basis(a->s, a->sub), *weight = a->m->column_weight + a->sub->column_start;
  for (int c = 0; c < a->columns; ++c) {
    move[c] = 0.0;
    for (int i = 0; i < k; ++i)
      move[c] += 0.02 * (1.0 + 0.3 * i) * Z[i * a->columns + c] / weight[c];
  }
  km_closure evidence;
  km_state_save(a->s, a->sub, saved);
  km_state_move(a->m, a->s, a->sub, move);
  a->s->pivoted[a->index] = KM_NEVER;
  if (k > 0 && km_close(a->m, a->s, a->index, KM_NO_DRIVER, &evidence) == KM_CLOSED) {
    km_poses_update(a->m, a->s);
    memset(a->J, 0, (size_t)a->rows * (size_t)a->columns * sizeof *a->J);
    fill(a);
    left_null(a, 0, a->rows, a->columns);
    a->nearby_count = a->null_count < a->all_count ? a->null_count : a->all_count;
    memcpy(a->nearby, a->W, (size_t)a->nearby_count * (size_t)a->rows * sizeof *a->nearby);
  }
  km_state_restore(a->s, a->sub, saved);
  km_loops_update(a->m, a->s, a->sub);
  a->s->pivoted[a->index] = KM_NEVER;
  km_poses_update(a->m, a->s);
  memset(a->J, 0, (size_t)a->rows * (size_t)a->columns * sizeof *a->J);
  fill(a);
}

/* Is the (unit) left null vector v one of the nearby pose too? Its frame has turned by a few hundredths. */
static bool lasts(const space *a, const double *v) {
  double along = 0.0, size = 0.0;
  for (int r = 0; r < a->rows; ++r)
    size += v[r] * v[r];
  for (int i = 0; i < a->nearby_count; ++i) {
    double dot = 0.0;
    for (int r = 0; r < a->rows; ++r)
      dot += v[r] * a->nearby[(size_t)i * (size_t)a->rows + (size_t)r];
    along += dot * dot;
  }
  return a->nearby_count == a->all_count || along > 0.5 * size;
}

/* The physical meaning of a loop's wrench w: a force on a line, with a pitch, or a couple. */
static void describe(const space *a, const double *w, km_redundancy *item) {
  km_vec3 f = {w[0], w[1], w[2]}, c = {w[3], w[4], w[5]};
  double force = km_vec3_norm(f), couple = km_vec3_norm(c);
  item->rotation = force < 1e-6 * couple;
  km_vec3 d = item->rotation ? km_vec3_scale(1.0 / couple, c) : km_vec3_scale(1.0 / force, f);
  /* The sense of a constraint means nothing: the largest entry is made positive. */
  double largest = fabs(d.x) > fabs(d.y) ? (fabs(d.x) > fabs(d.z) ? d.x : d.z) : (fabs(d.y) > fabs(d.z) ? d.y : d.z);
  if (largest < 0.0)
    d = km_vec3_scale(-1.0, d);
  memcpy(item->direction, &(double[3]){d.x, d.y, d.z}, sizeof item->direction);
  if (item->rotation)
    return;
  km_vec3 p = km_vec3_axpy(a->sub->size / (force * force), km_vec3_cross(f, c), a->about);
  memcpy(item->point, &(double[3]){p.x, p.y, p.z}, sizeof item->point);
  item->pitch = a->sub->size * km_vec3_dot(f, c) / (force * force);
}

/* Left null vectors of one loop are turned so that couples come apart from forces: the forces' parts are
 * eliminated as far as they go (Gauss with complete pivoting on f). */
static void separate(double *W, int count) {
  for (int n = 0; n < count && n < 3; ++n) {
    int best = n, at = 0;
    for (int i = n; i < count; ++i)
      for (int r = 0; r < 3; ++r)
        if (fabs(W[6 * i + r]) > fabs(W[6 * best + at]) + 1e-12) {
          best = i;
          at = r;
        }
    if (fabs(W[6 * best + at]) < 1e-9)
      return;
    for (int r = 0; r < 6; ++r) {
      double swap = W[6 * n + r];
      W[6 * n + r] = W[6 * best + r];
      W[6 * best + r] = swap;
    }
    for (int i = 0; i < count; ++i) {
      double share = i == n ? 0.0 : W[6 * i + at] / W[6 * n + at];
      for (int r = 0; r < 6; ++r)
        W[6 * i + r] -= share * W[6 * n + r];
    }
  }
}

static bool add_item(km_redundancies *out, size_t *capacity, km_redundancy item) {
  void *items = out->items;
  if (!km_reserve(&items, capacity, (size_t)out->count + 1, sizeof item))
    return false;
  out->items = items;
  out->items[out->count++] = item;
  return true;
}

/* The redundancies that single loops have by themselves. Their vectors are kept in `own` (rows entries each). */
static bool single_loops(space *a, double *own, int *own_count, km_redundancies *out, size_t *capacity) {
  const km_topology *t = &a->m->topology;
  for (int i = 0; i < a->sub->loop_count; ++i) {
    double wrenches[36];
    left_null(a, 6 * i, 6 * i + 6, a->columns);
    int count = a->null_count;
    memcpy(wrenches, a->W, (size_t)(6 * count) * sizeof *wrenches);
    separate(wrenches, count);
    for (int k = 0; k < count; ++k) {
      km_redundancy item = {.substructure = a->index, .loop = t->loop[t->loop_start[a->index] + i], .loops = 1};
      describe(a, wrenches + 6 * k, &item);
      find_remedies(a, wrenches + 6 * k, &item);
      double *v = own + (size_t)(*own_count)++ * (size_t)a->rows;
      memset(v, 0, (size_t)a->rows * sizeof *v);
      memcpy(v + 6 * i, wrenches + 6 * k, 6 * sizeof *v);
      item.lasting = lasts(a, v);
      if (!add_item(out, capacity, item))
        return false;
    }
  }
  return true;
}

/* Removes from v what the `count` vectors before it span (they are made orthonormal on the way). */
static double orthogonalise(double *vectors, int count, int rows) {
  double *v = vectors + (size_t)count * (size_t)rows, sum = 0.0;
  for (int pass = 0; pass < 2; ++pass) {
    for (int i = 0; i < count; ++i) {
      double dot = 0.0;
      for (int r = 0; r < rows; ++r)
        dot += vectors[i * rows + r] * v[r];
      for (int r = 0; r < rows; ++r)
        v[r] -= dot * vectors[i * rows + r];
    }
  }
  for (int r = 0; r < rows; ++r)
    sum += v[r] * v[r];
  for (int r = 0; r < rows && sum > 1e-16; ++r)
    v[r] /= sqrt(sum);
  return sqrt(sum);
}

/* What several loops have only together. */
static bool several_loops(space *a, double *own, int own_count, km_redundancies *out, size_t *capacity) {
  const km_topology *t = &a->m->topology;
  for (int i = 0; i < own_count; ++i)
    orthogonalise(own, i, a->rows);
  for (int n = 0; n < a->all_count; ++n) {
    double *v = own + (size_t)own_count * (size_t)a->rows;
    memcpy(v, a->all + (size_t)n * (size_t)a->rows, (size_t)a->rows * sizeof *v);
    if (orthogonalise(own, own_count, a->rows) < 1e-6)
      continue;
    ++own_count;
    double largest = 0.0;
    km_redundancy item = {.substructure = a->index, .loop = -1};
    const double *wrench = NULL;
    for (int i = 0; i < a->sub->loop_count; ++i) {
      double size = 0.0;
      for (int r = 0; r < 6; ++r)
        size += v[6 * i + r] * v[6 * i + r];
      item.loops += size > 1e-10;
      if (size > 1.0000001 * largest) {
        largest = size;
        wrench = v + 6 * i;
        item.loop = t->loop[t->loop_start[a->index] + i];
      }
    }
    if (!wrench)
      continue; /* couplings among themselves */
    describe(a, wrench, &item);
    find_remedies(a, wrench, &item);
    item.lasting = lasts(a, v);
    if (!add_item(out, capacity, item))
      return false;
  }
  return true;
}

static bool find_in(const km_mechanism *m, km_state *s, int index, km_arena *arena, km_redundancies *out,
                    size_t *capacity) {
  const km_substructure *sub = &m->substructures[index];
  const km_topology *t = &m->topology;
  space a = {.m = m,
             .s = s,
             .index = index,
             .sub = sub,
             .columns = sub->columns,
             .rows = 6 * sub->loop_count + sub->coupling_count};
  int worst;
  a.tolerance = km_rank_tolerance(m, sub, km_loops_residual(m, s, sub, &worst));
  a.about = km_joint_pose(m, s, t->joint[t->joint_start[index]]).p;
  double *own = KM_ARENA_NEW(arena, double, (size_t)a.rows *(size_t)(a.rows + 1));
  if (!allocate(&a, arena))
    return false;
  fill(&a);
  a.rank = left_null(&a, 0, a.rows, a.columns);
  int own_count = 0;
  a.all_count = a.null_count;
  a.all = KM_ARENA_NEW(arena, double, (size_t)a.all_count *(size_t)a.rows);
  a.reach = KM_ARENA_NEW(arena, double, 2 * (size_t)a.all_count);
  if (arena->failed)
    return false;
  memcpy(a.all, a.W, (size_t)a.all_count * (size_t)a.rows * sizeof *a.all);
  if (a.all_count == 0)
    return true;
  look_nearby(&a, arena);
  return !arena->failed && single_loops(&a, own, &own_count, out, capacity) &&
         several_loops(&a, own, own_count, out, capacity);
}

km_status km_redundancies_find(const km_mechanism *m, km_state *s, km_redundancies *out, km_error *error) {
  *out = (km_redundancies){0};
  size_t capacity = 0;
  bool failed = false;
  km_mobility mobility;
  km_poses_update(m, s);
  km_mobility_update(m, s, &mobility);
  for (int i = 0; i < m->topology.substructure_count && !failed; ++i) {
    km_arena arena = {0};
    failed = !find_in(m, s, i, &arena, out, &capacity);
    km_arena_free(&arena);
  }
  return failed ? km_fail(error, KM_MEMORY, "out of memory for the redundant constraints") : KM_OK;
}

void km_redundancies_free(km_redundancies *redundancies) {
  km_free(redundancies->items);
  *redundancies = (km_redundancies){0};
}
