/* Left null vectors of the six-row Jacobian: those of single loops first, then what several loops have together. */
#include "analysis/left_null.h"

#include "analysis/whole_jacobian.h"
#include "kinematics/closure.h"
#include "kinematics/loops.h"
#include "kinematics/poses.h"

#include <string.h>

/* Lists the loops of every joint. False when out of memory. */
static bool find_places(km_left_space *a, km_arena *arena) {
  const km_topology *t = &a->m->topology;
  const int *loops = t->loop + t->loop_start[a->index];
  size_t joints = (size_t)a->m->model->joint_count, members = 0;
  for (int i = 0; i < a->sub->loop_count; ++i)
    members += (size_t)(t->member_start[loops[i] + 1] - t->member_start[loops[i]]);
  int *first = KM_ARENA_NEW(arena, int, joints + 2);
  a->place = KM_ARENA_NEW(arena, km_loop_place, members);
  a->first_place = first;
  if (arena->failed)
    return false;
  for (int i = 0; i < a->sub->loop_count; ++i)
    for (int k = t->member_start[loops[i]]; k < t->member_start[loops[i] + 1]; ++k)
      first[t->member[k].joint + 2]++;
  for (size_t j = 0; j < joints; ++j)
    first[j + 2] += first[j + 1];
  /* First[j + 1] is where the next place of joint j goes, and ends up where the joint's places end. */
  for (int i = 0; i < a->sub->loop_count; ++i)
    for (int k = t->member_start[loops[i]]; k < t->member_start[loops[i] + 1]; ++k)
      a->place[first[t->member[k].joint + 1]++] = (km_loop_place){i, k};
  return true;
}

bool km_left_space_make(const km_mechanism *m, km_state *s, int index, km_arena *arena, km_left_space *out) {
  const km_substructure *sub = &m->substructures[index];
  const km_topology *t = &m->topology;
  int worst;
  *out = (km_left_space){.m = m,
                         .s = s,
                         .index = index,
                         .sub = sub,
                         .rows = 6 * sub->loop_count + sub->coupling_count,
                         .tolerance = km_rank_tolerance(m, sub, km_loops_residual(m, s, sub, &worst))};
  out->about = KM_ARENA_NEW(arena, km_vec3, (size_t)sub->loop_count);
  out->helps = KM_ARENA_NEW(arena, signed char, 4 * (size_t)m->model->joint_count);
  for (int i = 0; i < sub->loop_count && out->about; ++i)
    out->about[i] = km_joint_pose(m, s, t->chord[t->loop[t->loop_start[index] + i]]).p;
  return find_places(out, arena);
}

/* Calls `take` with the six entries of each column of the loop at a place. */
static void visit_loop(const km_left_space *a, int place, void (*take)(void *out, int column, const double entry[6]),
                       void *out) {
  const km_topology *t = &a->m->topology;
  int loop = t->loop[t->loop_start[a->index] + place];
  for (int i = t->member_start[loop]; i < t->member_start[loop + 1]; ++i) {
    const km_member *member = &t->member[i];
    int first = a->m->model->joints[member->joint].first_coordinate;
    for (int c = first; c < first + km_model_freedom(a->m->model, member->joint); ++c) {
      if (a->m->column_of[c] < 0)
        continue;
      double column[6], sense = km_member_sense(t, loop, member);
      km_twist_entries(a->sub, km_coordinate_twist(a->m, a->s, c), a->about[place], a->m->unit[c], column);
      for (int r = 0; r < 6; ++r)
        column[r] *= sense;
      take(out, a->m->column_of[c], column);
    }
  }
}

/* J transposed: row `column` holds the constraints' entries of a column. */
typedef struct transposed {
  double *entries; /* column-major: a constraint after the other */
  int height, at;  /* columns of J; the next row, or the first constraint of a loop */
} transposed;

static void take_next(void *out, int column, const double entry[6]) {
  transposed *T = out;
  (void)column;
  for (int r = 0; r < 6; ++r)
    T->entries[r * T->height + T->at] = entry[r];
  T->at++;
}

static void count_one(void *out, int column, const double entry[6]) {
  (void)column;
  (void)entry;
  ++*(int *)out;
}

/* Orthonormal left null vectors from a transposed matrix of `rows` constraints. Returns how many; -1: out of memory. */
static int solve(const transposed *T, int rows, double tolerance, km_arena *arena, double *W) {
  km_partition p;
  double *one = KM_ARENA_NEW(arena, double, (size_t)rows);
  if (!one || !km_partition_reserve(&p, T->height, rows, arena))
    return -1;
  for (int r = 0; r < rows; ++r)
    one[r] = 1.0;
  km_partition_factor(&p, T->entries, T->height, rows, NULL, tolerance);
  km_partition_null(&p, one, km_partition_freedom(&p), W);
  return km_partition_freedom(&p);
}

/* What a loop has by itself, 36 entries at most. Returns how many vectors; -1: out of memory. */
static int solve_loop(const km_left_space *a, int place, double *W) {
  km_arena scratch = {0};
  int columns = 0;
  visit_loop(a, place, count_one, &columns);
  transposed T = {KM_ARENA_NEW(&scratch, double, 6 * (size_t)columns), columns, 0};
  int count = -1;
  if (!scratch.failed) {
    visit_loop(a, place, take_next, &T);
    count = solve(&T, 6, a->tolerance, &scratch, W);
  }
  km_arena_free(&scratch);
  return count;
}

/* Subtracts from v what the unit vector has of it. */
static void subtract(double *v, const double *unit, int count) {
  double dot = 0.0;
  for (int r = 0; r < count; ++r)
    dot += unit[r] * v[r];
  for (int r = 0; r < count; ++r)
    v[r] -= dot * unit[r];
}

/* What is left of the six directions of a loop at right angles to its own null vectors W: orthonormal, C[6 × returned].
 */
static int complement(const double *W, int count, double *C) {
  int found = 0;
  for (; count + found < 6; ++found) {
    double *best = C + 6 * found, largest = 0.0;
    for (int axis = 0; axis < 6; ++axis) {
      double v[6] = {0}, size = 0.0;
      v[axis] = 1.0;
      for (int pass = 0; pass < 2; ++pass) {
        for (int k = 0; k < count; ++k)
          subtract(v, W + 6 * k, 6);
        for (int k = 0; k < found; ++k)
          subtract(v, C + 6 * k, 6);
      }
      for (int r = 0; r < 6; ++r)
        size += v[r] * v[r];
      for (int r = 0; r < 6 && size > 1.0001 * largest; ++r)
        best[r] = v[r] / sqrt(size);
      largest = fmax(largest, size);
    }
  }
  return found;
}

/* The loops' rows along their complements: their left null vectors are those of several loops together. */
typedef struct reduced {
  transposed T;
  const double *C; /* of the loop that is being filled */
  int count;
} reduced;

static void take_reduced(void *out, int column, const double entry[6]) {
  reduced *R = out;
  for (int k = 0; k < R->count; ++k) {
    double sum = 0.0;
    for (int r = 0; r < 6; ++r)
      sum += R->C[6 * k + r] * entry[r];
    R->T.entries[(size_t)(R->T.at + k) * (size_t)R->T.height + (size_t)column] = sum;
  }
}

static void fill_couplings(const km_left_space *a, transposed *T) {
  for (int i = 0; i < a->sub->coupling_count; ++i, T->at++) {
    const km_coupling *coupling = &a->m->couplings[a->sub->coupling_start + i];
    for (int k = 0; k < coupling->term_count; ++k) {
      const km_term *term = &a->m->terms[coupling->term_start + k];
      if (term->column >= 0)
        km_term_value(a->m, a->s, term, &T->entries[(size_t)T->at * (size_t)T->height + (size_t)term->column]);
    }
  }
}

/* A null vector of the reduced rows in all rows. */
static void expand(const km_left_space *a, const double *C, const int *count, const double *w, double *v) {
  memset(v, 0, (size_t)a->rows * sizeof *v);
  for (int i = 0; i < a->sub->loop_count; ++i)
    for (int k = 0; k < count[i]; ++k, ++w)
      for (int r = 0; r < 6; ++r)
        v[6 * i + r] += *w * C[36 * i + 6 * k + r];
  memcpy(v + 6 * a->sub->loop_count, w, (size_t)a->sub->coupling_count * sizeof *v);
}

/* What several loops have only together. */
static bool find_whole(const km_left_space *a, km_arena *arena, km_left_null *out) {
  km_arena scratch = {0};
  int loops = a->sub->loop_count, rows = a->rows - out->local_count,
      *count = KM_ARENA_NEW(&scratch, int, (size_t)loops);
  double *C = KM_ARENA_NEW(&scratch, double, 36 * (size_t)loops);
  double *W = KM_ARENA_NEW(&scratch, double, (size_t)rows *(size_t)rows);
  reduced R = {.T = {KM_ARENA_NEW(&scratch, double, (size_t)rows *(size_t)a->sub->columns), a->sub->columns, 0}};
  int found = -1;
  if (!scratch.failed) {
    for (int i = 0; i < loops; ++i, R.T.at += R.count) {
      R.C = C + 36 * i;
      R.count = count[i] = complement(out->local + 6 * out->first[i], out->first[i + 1] - out->first[i], C + 36 * i);
      visit_loop(a, i, take_reduced, &R);
    }
    fill_couplings(a, &R.T);
    found = solve(&R.T, rows, a->tolerance, &scratch, W);
  }
  out->whole = found > 0 ? KM_ARENA_NEW(arena, double, (size_t)found *(size_t)a->rows) : NULL;
  for (int n = 0; n < found && out->whole; ++n)
    expand(a, C, count, W + (size_t)n * (size_t)rows, out->whole + (size_t)out->whole_count++ * (size_t)a->rows);
  km_arena_free(&scratch);
  return found >= 0 && !arena->failed;
}

bool km_left_null_find(const km_left_space *a, km_arena *arena, km_left_null *out) {
  size_t loops = (size_t)a->sub->loop_count;
  *out = (km_left_null){.first = KM_ARENA_NEW(arena, int, loops + 1), .local = KM_ARENA_NEW(arena, double, 36 * loops)};
  if (arena->failed)
    return false;
  for (int i = 0; i < a->sub->loop_count; ++i) {
    int count = solve_loop(a, i, out->local + 6 * out->local_count);
    if (count < 0)
      return false;
    out->first[i] = out->local_count;
    out->local_count += count;
  }
  out->first[loops] = out->local_count;
  return a->rows - a->s->partition[a->index].rank <= out->local_count || find_whole(a, arena, out);
}
