/* Search of joint types that end all redundant constraints of a substructure (theory 7.5).
 *
 *   V = Wᵀ H      W: basis of the left null vectors [redundant], H: twists of the motions that joints could have more
 *   redundant' = redundant − rank V_S,  mobility' = mobility + |S| − rank V_S,   S: motions of the chosen options
 *
 * S with independent columns V_S and |S| = redundant ends all and keeps the mobility. Options are chosen one by one:
 *   level  0 types of the format, 1 such types of driven joints, 2 series of joints, 3 such of driven joints
 *   score  more motions first, then the largest least pivot of the option's columns, orthogonal to those chosen before
 * If the choice ends early, one chosen option is exchanged and the choice is continued, as long as fewer constraints
 * remain. The levels are admitted one after another until none remains. */
#include "mobility/remedies/remedy_search.h"
#include "base/number/tolerances.h"
#include "base/number/vectors.h"

#include "kinematics/body_poses.h"
#include "mobility/full_jacobian.h"

#include <stdlib.h>
#include <string.h>

enum { NONE = -1, LEVELS = 4 };

typedef struct candidate {
  int joint, option_count;
  km_joint_option options[KM_MAX_JOINT_OPTIONS];
  int level[KM_MAX_JOINT_OPTIONS];
  int chosen; /* option, or NONE */
} candidate;

typedef struct search {
  int redundant, count;
  candidate *candidates; /* [count] */
  double *columns;       /* [candidate · motion · redundant] V */
  double *rest;          /* V less its part along the chosen columns */
  double *trial;         /* [KM_JOINT_MOTIONS · redundant] */
  int remaining, level;
  double work;
} search;

static double *column_of(const search *f, double *columns, int candidate_index, int motion) {
  return columns + ((size_t)candidate_index * KM_JOINT_MOTIONS + (size_t)motion) * (size_t)f->redundant;
}

/* Wᵀ h of a motion of unit length over all loops that contain the joint. */
static void project_motion(const km_left_space *a, const km_left_null *null, int joint, km_twist h, double unit,
                           double *out) {
  const km_topology *t = &a->m->topology;
  double length = 0.0;
  for (int n = t->joint_loop_start[joint]; n < t->joint_loop_start[joint + 1]; ++n) {
    const km_joint_loop *in = &t->joint_loop[n];
    double column[6];
    km_twist_entries(a->sub, h, a->about[in->loop], unit, column);
    length += km_dot(column, column, 6);
    for (int k = null->first[in->loop]; k < null->first[in->loop + 1]; ++k)
      out[k] += in->sign * km_dot(column, null->local + 6 * k, 6);
    for (int i = null->spanning_count ? null->block_start[in->loop] : 0;
         null->spanning_count && i < null->block_start[in->loop + 1]; ++i) {
      const km_left_part *part = &null->part[null->block_part[i]];
      out[null->local_count + part->vector] += in->sign * km_dot(column, part->w, 6);
    }
  }
  for (int k = 0; k < km_left_null_count(null) && length > 0.0; ++k)
    out[k] /= sqrt(length);
}

/* Writes the columns of all six motions of a joint along and about the axes of its parent frame. */
static void project_joint(const search *f, const km_left_space *a, const km_left_null *null, int index) {
  int joint = f->candidates[index].joint;
  km_pose X = km_joint_pose(a->m, a->s, joint);
  for (int k = 0; k < 3; ++k) {
    project_motion(a, null, joint, km_twist_prismatic(X.R.axis[k]), a->sub->size, column_of(f, f->columns, index, k));
    project_motion(a, null, joint, km_twist_revolute(X.R.axis[k], X.p), 1.0, column_of(f, f->columns, index, 3 + k));
  }
}

static void mark_fixed_joints(const km_left_space *a, bool *fixed) {
  const km_model *model = a->m->model;
  for (int i = 0; i < model->coupling_count; ++i)
    for (int k = 0; k < model->couplings[i].count; ++k)
      fixed[model->coordinates[model->couplings[i].coordinates[k]].joint] = true;
  for (int c = 0; c < a->m->coordinate_count; ++c)
    fixed[model->coordinates[c].joint] = fixed[model->coordinates[c].joint] || a->m->held[c];
}

static bool list_candidates(search *f, const km_left_space *a, const km_left_null *null, const bool *driven,
                            km_arena *arena) {
  const km_model *model = a->m->model;
  const km_topology *t = &a->m->topology;
  bool *fixed = KM_ARENA_NEW(arena, bool, (size_t)model->joint_count);
  f->candidates = KM_ARENA_NEW(arena, candidate, (size_t)model->joint_count);
  if (arena->failed)
    return false;
  mark_fixed_joints(a, fixed);
  for (int n = t->joint_start[a->index]; n < t->joint_start[a->index + 1]; ++n) {
    int j = t->joint[n];
    candidate *c = &f->candidates[f->count];
    *c = (candidate){.joint = j, .chosen = NONE};
    if (fixed[j] || t->joint_loop_start[j] == t->joint_loop_start[j + 1])
      continue;
    c->option_count = km_joint_options(&model->joints[j], c->options);
    for (int i = 0; i < c->option_count; ++i)
      c->level[i] = (c->options[i].is_type ? 0 : 2) + (driven[j] ? 1 : 0);
    f->count += c->option_count > 0;
  }
  size_t size = (size_t)f->count * KM_JOINT_MOTIONS * (size_t)f->redundant;
  f->columns = KM_ARENA_NEW(arena, double, size);
  f->rest = KM_ARENA_NEW(arena, double, size);
  f->trial = KM_ARENA_NEW(arena, double, (size_t)KM_JOINT_MOTIONS *(size_t)f->redundant);
  if (arena->failed)
    return false;
  for (int i = 0; i < f->count; ++i)
    project_joint(f, a, null, i);
  return true;
}

/* Orthonormalises the remaining columns of an option in `trial`. Returns the least pivot. */
static double find_least_pivot(const search *f, int index, const km_joint_option *option) {
  double least = HUGE_VAL;
  int n = 0;
  for (int motion = 0; motion < KM_JOINT_MOTIONS; ++motion) {
    if (!(option->added >> motion & 1))
      continue;
    double *v = f->trial + (size_t)n * (size_t)f->redundant;
    memcpy(v, column_of(f, f->rest, index, motion), (size_t)f->redundant * sizeof *v);
    for (int i = 0; i < n; ++i)
      km_remove_projection(f->trial + (size_t)i * (size_t)f->redundant, v, f->redundant);
    double pivot = km_norm(v, f->redundant);
    least = fmin(least, pivot);
    for (int i = 0; i < f->redundant && pivot > 0.0; ++i)
      v[i] /= pivot;
    ++n;
  }
  return least;
}

/* Chooses an option whose columns are independent of those chosen before. */
static void choose(search *f, int index, int option) {
  candidate *c = &f->candidates[index];
  find_least_pivot(f, index, &c->options[option]);
  c->chosen = option;
  int motions = km_motion_count(c->options[option].added), columns = f->count * KM_JOINT_MOTIONS;
  f->remaining -= motions;
  f->work += 2.0 * motions * columns * f->redundant;
  for (int i = 0; i < columns; ++i)
    for (int n = 0; n < motions; ++n)
      km_remove_projection(f->trial + (size_t)n * (size_t)f->redundant, f->rest + (size_t)i * (size_t)f->redundant,
                           f->redundant);
}

/* A motion whose column of unit length has a smaller pivot than 1/km_significant_ratio would turn errors of the links
 * into much larger motions. */
static bool is_admitted(const search *f, int index, int option) {
  const candidate *c = &f->candidates[index];
  return c->level[option] <= f->level && km_motion_count(c->options[option].added) <= f->remaining &&
         find_least_pivot(f, index, &c->options[option]) > 1.0 / km_significant_ratio;
}

/* Chooses the best admitted option of an unchanged joint. False if there is none. */
static bool choose_best(search *f) {
  int best_index = NONE, best_option = NONE, best_level = LEVELS, most_motions = 0;
  double best_pivot = 0.0;
  for (int i = 0; i < f->count; ++i)
    for (int k = 0; k < f->candidates[i].option_count && f->candidates[i].chosen == NONE; ++k) {
      if (!is_admitted(f, i, k))
        continue;
      int level = f->candidates[i].level[k], motions = km_motion_count(f->candidates[i].options[k].added);
      double pivot = find_least_pivot(f, i, &f->candidates[i].options[k]);
      bool is_better = level != best_level       ? level < best_level
                       : motions != most_motions ? motions > most_motions
                                                 : pivot > best_pivot * (1.0 + 1e-6);
      if (is_better) {
        best_index = i;
        best_option = k;
        best_level = level;
        most_motions = motions;
        best_pivot = pivot;
      }
    }
  f->work += (double)f->count * KM_MAX_JOINT_OPTIONS * KM_JOINT_MOTIONS * f->redundant;
  if (best_index == NONE)
    return false;
  choose(f, best_index, best_option);
  return true;
}

static void complete(search *f) {
  while (f->remaining > 0 && choose_best(f))
    continue;
}

/* Starts again from given choices, without that of `left_out`. */
static void restart(search *f, const int *chosen, int left_out) {
  f->remaining = f->redundant;
  memcpy(f->rest, f->columns, (size_t)f->count * KM_JOINT_MOTIONS * (size_t)f->redundant * sizeof *f->rest);
  for (int i = 0; i < f->count; ++i)
    f->candidates[i].chosen = NONE;
  for (int i = 0; i < f->count; ++i)
    if (chosen && chosen[i] != NONE && i != left_out)
      choose(f, i, chosen[i]);
}

static void save(const search *f, int *chosen) {
  for (int i = 0; i < f->count; ++i)
    chosen[i] = f->candidates[i].chosen;
}

/* Exchanges the option of one joint and continues the choice; the best choices stay in `chosen`. True if fewer
 * constraints remain. */
static bool exchange_one(search *f, int *chosen, int *remaining) {
  for (int i = 0; i < f->count; ++i)
    for (int k = NONE; k < f->candidates[i].option_count && chosen[i] != NONE; ++k) {
      if (k == chosen[i] || f->work > km_search_work)
        continue;
      restart(f, chosen, i);
      if (k != NONE && !is_admitted(f, i, k))
        continue;
      if (k != NONE)
        choose(f, i, k);
      complete(f);
      if (f->remaining < *remaining) {
        *remaining = f->remaining;
        save(f, chosen);
        return true;
      }
    }
  return false;
}

/* Chooses options of all levels up to f->level. Returns the number of constraints that remain. */
static int choose_at_level(search *f, int *chosen) {
  restart(f, NULL, NONE);
  complete(f);
  save(f, chosen);
  int remaining = f->remaining;
  while (remaining > 0 && exchange_one(f, chosen, &remaining))
    continue;
  return remaining;
}

static bool write_changes(const search *f, const int *chosen, km_arena *arena, km_remedy_search *out) {
  out->changes = KM_ARENA_NEW(arena, km_joint_change, (size_t)f->count);
  for (int i = 0; i < f->count && out->changes; ++i) {
    if (chosen[i] == NONE)
      continue;
    const km_joint_option *option = &f->candidates[i].options[chosen[i]];
    out->changes[out->change_count++] = (km_joint_change){.joint = f->candidates[i].joint,
                                                          .to = option->to,
                                                          .freedoms = km_motion_count(option->added),
                                                          .motions = option->added};
  }
  return out->changes;
}

bool km_remedy_search_run(const km_left_space *a, const km_left_null *null, const bool *driven, km_arena *arena,
                          km_remedy_search *out) {
  search f = {.redundant = km_left_null_count(null)};
  *out = (km_remedy_search){.redundant = f.redundant, .remaining = f.redundant};
  if (f.redundant == 0)
    return true;
  if (!list_candidates(&f, a, null, driven, arena))
    return false;
  int *chosen = KM_ARENA_NEW(arena, int, (size_t)f.count), *best = KM_ARENA_NEW(arena, int, (size_t)f.count);
  if (arena->failed)
    return false;
  for (f.level = 0; f.level < LEVELS && out->remaining > 0; ++f.level) {
    int remaining = choose_at_level(&f, chosen);
    if (f.level == 0 || remaining < out->remaining) {
      out->remaining = remaining;
      memcpy(best, chosen, (size_t)f.count * sizeof *best);
    }
  }
  return write_changes(&f, best, arena, out);
}
