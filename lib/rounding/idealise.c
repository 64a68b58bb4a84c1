/* Rounded numbers: verdicts for all substructures of a model, and its numbers replaced by the nearest ones that move
 * (docs/theory.md 14.6-14.8).
 *
 *   ν = √(Σ_k |h_k ξ_k|²)   noise: change of J that half a last digit of every number causes, about; ξ_k: twist of the
 *                           frame that the number places
 *   σ_i > 10 ν kept, σ_i < 1e-12 σ_1 zero; those between may be rounding: each rank is tried, the lowest first */
#include "kmech/rounding.h"

#include "base/number/tolerances.h"
#include "kinematics/assembly.h"
#include "kinematics/damped_least_squares.h"
#include "kinematics/loop_closing.h"
#include "rounding/digits.h"
#include "rounding/nearest_mechanism.h"

#include <stdio.h>
#include <string.h>

enum { MOST_COLUMNS = 400 };             /* larger substructures take minutes */
static const double noise_margin = 10.0; /* times the noise: lower bound of singular values that are kept */
/* A unit above this part of the substructure's size explains any gap, and a larger gap shows a poor start. */
static const double largest_unit = 1e-2;

/* The result while it grows. */
typedef struct result {
  km_idealisation *out;
  void *verdict, *change; /* the arrays of `out` */
  size_t verdict_room, change_room;
  km_text words; /* verdicts on the substructures whose numbers aren't exact */
  bool failed;   /* out of memory */
} result;

/* Data that the examinations of all substructures share. */
typedef struct shared_data {
  km_mechanism *m; /* the model as written, with a state whose poses are current */
  km_state *s;
  const km_pose *written; /* [frame] */
  const int *owner;       /* [frame] substructure of its joints */
  bool regular;           /* relations are made exact too */
  const km_compiling *options;
} shared_data;

/* Analysis of one substructure. */
typedef struct examination {
  km_model *model;
  km_compiling options;
  km_nearest_mechanism nearest;
  km_rounded_numbers numbers;
  km_relations relations; /* none unless they are requested */
  int lowest, highest;    /* rank without and with the singular values that may be rounding */
  double gap;             /* the largest gap at the lowest rank */
  km_rounding verdict;
} examination;

/* Numbers that may change: those that are known to be rounded, in their planes; all, in their planes; all. Relations
 * begin with those that are known to be rounded, in any direction. */
typedef enum freedom_of_numbers { LONG_IN_PLANES, ALL_IN_PLANES, ALL, FREEDOMS_OF_NUMBERS, LONG } freedom_of_numbers;

static void choose_numbers(examination *x, freedom_of_numbers freedom) {
  km_nearest_mechanism *n = &x->nearest;
  double size = n->m->substructures[n->index].size;
  n->count = 0;
  const bool in_planes = freedom == LONG_IN_PLANES || freedom == ALL_IN_PLANES,
             long_only = freedom == LONG_IN_PLANES || freedom == LONG;
  n->gaps.keeps_planes = in_planes;
  for (int k = 0; k < x->numbers.count; ++k) {
    km_written_number number = *x->numbers.number[k];
    if (in_planes)
      number = km_loop_gaps_keep_plane(&n->gaps, &number);
    double unit = x->numbers.half[k], moves = km_vec3_norm(number.move) / size, turns = km_vec3_norm(number.turn);
    if ((long_only && !x->numbers.is_long[k]) || unit == 0.0 || unit * fmax(moves, turns) > largest_unit)
      continue;
    n->number[n->count] = number;
    n->half[n->count] = unit;
    n->x[n->count++] = 0.0;
  }
}

static int count_above(const km_nearest_mechanism *n, double bound) {
  int count = 0, least = n->rows < n->columns ? n->rows : n->columns;
  while (count < least && n->S[count] > bound)
    ++count;
  return count;
}

static double largest_gap(const km_nearest_mechanism *n, int first_row) {
  double most = 0.0;
  for (int r = first_row; r < n->rows; ++r) {
    double along = 0.0;
    for (int i = 0; i < n->rows; ++i)
      along += n->U[(size_t)r * (size_t)n->rows + (size_t)i] * n->e[i];
    most = fmax(most, fabs(along));
  }
  return most;
}

/* Finds ranks and gaps of the numbers as they are written. *closed: the
 * start is near a configuration without gaps in the directions that are kept. */
static km_status examine_as_written(examination *x, bool *converged, km_error *error) {
  km_nearest_mechanism *n = &x->nearest;
  km_status status = km_nearest_decompose(n, error);
  double open = largest_gap(n, 0);
  *converged = false;
  if (!status && open > largest_unit) {
    status = km_damped_least_squares(n->m, n->s, n->index, error);
    status = status ? status : km_nearest_decompose(n, error);
  }
  if (status)
    return status;
  choose_numbers(x, ALL_IN_PLANES);
  double noise = km_loop_gaps_noise(&n->gaps, n->number, n->half, n->count);
  x->lowest = n->rank = count_above(n, fmax(noise_margin * noise, km_solved_rounding * n->S[0]));
  status = km_nearest_correct(n, converged, error);
  if (status || !*converged)
    return status;
  km_state_save(n->s, &n->m->substructures[n->index], n->start);
  x->highest = count_above(n, km_solved_rounding * n->S[0]);
  x->gap = largest_gap(n, x->lowest);
  int rank = count_above(n, km_relative_zero * n->S[0]);
  x->verdict.closes = largest_gap(n, rank) <= km_relative_zero;
  x->verdict.mobility = x->verdict.mobility_as_written = n->columns - rank;
  return KM_OK;
}

/* Puts the frames back to what was written. */
static km_status restore(examination *x, km_error *error) {
  choose_numbers(x, ALL);
  return km_nearest_apply(&x->nearest, error);
}

/* True if the loops of the present numbers are closed from the model's start as every tool closes them. */
static km_status check_assembly(const km_nearest_mechanism *n, bool *closed, km_error *error) {
  km_state_restart(n->s);
  double *saved = KM_ARENA_NEW(n->arena, double, KM_SAVED_PER_COLUMN *(size_t)n->columns);
  return saved ? km_assemble_one(n->m, n->s, n->index, saved, closed)
               : km_fail(error, KM_MEMORY, "out of memory for the nearest mechanism");
}

/* Tries the ranks between, first with the numbers that are known to be rounded. */
static km_status find_rank(examination *x, bool *found, km_error *error) {
  km_nearest_mechanism *n = &x->nearest;
  km_status status = KM_OK;
  *found = false;
  for (int rank = x->lowest; rank <= x->highest && !status; ++rank)
    for (int freedom = 0; freedom < FREEDOMS_OF_NUMBERS && !status; ++freedom) {
      if (rank == x->highest && x->gap <= km_relative_zero)
        continue;
      status = restore(x, error);
      choose_numbers(x, (freedom_of_numbers)freedom);
      n->rank = rank;
      status = status ? status : km_nearest_find(n, found, error);
      if (!status && *found)
        status = check_assembly(n, found, error);
      if (*found)
        return status;
    }
  return status;
}

/* Drops the relations of the frames that numbers place whose changes are at least half as large as the largest one; all
 * if there are none. */
static void drop_relations(km_relations *relations, const km_nearest_mechanism *n) {
  double most = 0.0;
  int kept = 0;
  for (int k = 0; k < n->count; ++k)
    most = fmax(most, fabs(n->x[k]));
  for (int i = 0; i < relations->count; ++i) {
    bool is_placed = false;
    for (int k = 0; k < n->count; ++k)
      is_placed =
          is_placed || (fabs(n->x[k]) >= 0.5 * most && km_relation_is_placed(&relations->relation[i], &n->number[k]));
    if (!is_placed)
      relations->relation[kept++] = relations->relation[i];
  }
  relations->count = kept < relations->count ? kept : 0;
}

/* Makes the relations alone exact; those that need more than rounding are dropped. */
static km_status make_regular(examination *x, bool *made, km_error *error) {
  km_nearest_mechanism *n = &x->nearest;
  km_status status = KM_OK;
  *made = false;
  while (x->relations.count > 0 && !*made && !status) {
    for (int i = 0; i < 2 && !*made && !status; ++i) {
      status = restore(x, error);
      choose_numbers(x, i == 0 ? LONG : ALL);
      status = status ? status : km_nearest_regular(n, made, error);
      if (!status && *made)
        status = check_assembly(n, made, error);
    }
    if (!*made && !status)
      drop_relations(&x->relations, n);
  }
  return status;
}

/* Finds the rank with the relations; without them if no mechanism has them. */
static km_status find_regular_rank(examination *x, bool *found, km_error *error) {
  x->nearest.relations = x->relations.count > 0 ? &x->relations : NULL;
  km_status status = find_rank(x, found, error);
  if (status || *found || !x->nearest.relations)
    return status;
  x->nearest.relations = NULL;
  x->relations.count = 0;
  return find_rank(x, found, error);
}

/* Writes "R[5] of frame link/B". */
static void write_place(const km_model *model, const km_written_number *number, char out[KM_NUMBER_PLACE]) {
  const km_model_frame *frame = &model->frames[number->frame[0]];
  char index[16] = "";
  if (number->index >= 0)
    snprintf(index, sizeof index, "[%d]", number->index);
  snprintf(out, KM_NUMBER_PLACE, "%s%s of frame %.80s/%.80s", number->key, index, model->bodies[frame->body].name,
           frame->name);
}

/* Value of a number in the nearest mechanism. */
static double nearest_value(const km_nearest_mechanism *n, int k) {
  const km_written_number *number = &n->number[k];
  const km_pose *pose = &n->model->frames[number->frame[0]].pose;
  const double p[3] = {pose->p.x, pose->p.y, pose->p.z};
  double R[9];
  km_rotation_rows(&pose->R, R);
  if (number->index < 0)
    return number->value;
  if (strcmp(number->key, "R") == 0)
    return R[number->index];
  return strcmp(number->key, "T") == 0 ? p[number->index] : number->value + n->half[k] * n->x[k];
}

/* Adds the changes of a substructure; its largest is entered in the verdict. */
static void record_changes(examination *x, result *r) {
  /* rounding errors of the search in last digits: smaller changes are none, and of equal ones the first is named */
  const km_nearest_mechanism *n = &x->nearest;
  for (int k = 0; k < n->count; ++k) {
    const km_written_number *number = &n->number[k];
    double nearest = nearest_value(n, k), digits = 0.5 * n->x[k];
    if (number->index >= 0)
      digits = 0.5 * (nearest - number->value) / n->half[k];
    if (fabs(digits) <= km_root_rounding)
      continue;
    km_number_change change = {n->index, "", number->value, nearest, digits};
    write_place(x->model, number, change.place);
    if (fabs(digits) > x->verdict.largest_change + km_root_rounding) {
      x->verdict.largest_change = fabs(digits);
      memcpy(x->verdict.place, change.place, sizeof change.place);
    }
    r->failed = r->failed || !km_reserve(&r->change, &r->change_room, (size_t)r->out->change_count + 1, sizeof change);
    r->out->change = r->change;
    if (!r->failed)
      r->out->change[r->out->change_count++] = change;
  }
}

static void record_verdict(const km_rounding *verdict, result *r) {
  r->failed = r->failed || !km_reserve(&r->verdict, &r->verdict_room, (size_t)r->out->count + 1, sizeof *verdict);
  r->out->verdict = r->verdict;
  if (!r->failed)
    r->out->verdict[r->out->count++] = *verdict;
}

/* Adds the verdict on a substructure to the words about the model: the nearest mechanism, or that there is none. */
static void add_words(const examination *x, const km_mechanism *m, km_text *out) {
  const km_rounding *v = &x->verdict;
  if (v->verdict == KM_ROUNDING_EXACT)
    return;
  km_text_format(out, "%ssubstructure %d (joint %.80s and others): ", out->size ? "; " : "", v->substructure + 1,
                 m->model->joints[m->topology.joint[m->topology.joint_start[v->substructure]]].label);
  if (v->closes)
    km_text_format(out, "mobility %d as written", v->mobility_as_written);
  else
    km_text_add(out, "doesn't close as written");
  if (v->verdict == KM_ROUNDING_FOUND)
    km_text_format(out, "; mobility %d within rounding, which is used (largest change %.2g of a last digit, %s)",
                   v->mobility, v->largest_change, v->place[0] ? v->place : "none");
  else
    km_text_add(out, "; doubtful, since no numbers within half a last digit explain the gap or the small singular "
                     "value: look for a wrong digit");
}

static void add_note(const examination *x, const km_mechanism *m, km_messages *messages) {
  km_text words = {0};
  add_words(x, m, &words);
  km_messages_add(messages, KM_NOTE,
                  "%s; kmob convert --idealise writes these numbers, --exact takes the numbers as written",
                  words.data ? words.data : "");
  km_text_free(&words);
}

/* Enters the verdict of loops of exact numbers that close. *closed is false for other ones,
 * and the state is then at the start. LAPACKE need not be loaded for it. */
static km_status accept_exact(const shared_data *shared, int index, km_rounding *verdict, bool *closed,
                              km_error *error) {
  const km_substructure *sub = &shared->m->substructures[index];
  km_arena scratch = {0};
  size_t size = KM_SAVED_PER_COLUMN * (size_t)sub->columns;
  double *start = KM_ARENA_NEW(&scratch, double, size), *saved = KM_ARENA_NEW(&scratch, double, size);
  km_status status = KM_MEMORY;
  *closed = false;
  if (!scratch.failed) {
    km_state_save(shared->s, sub, start);
    status = km_assemble_one(shared->m, shared->s, index, saved, closed);
  }
  if (!status && *closed) {
    km_update_and_search_pivots(shared->m, shared->s, index, KM_NO_DRIVER, 0.0);
    verdict->closes = true;
    verdict->mobility = verdict->mobility_as_written = km_factor_freedom(shared->s->factor[index]);
  } else if (!status) {
    km_state_restore(shared->s, sub, start);
  }
  km_arena_free(&scratch);
  return status ? km_fail(error, status, "out of memory for the digits of a model") : KM_OK;
}

static km_status find_relations(examination *x, km_arena *arena, km_error *error) {
  km_nearest_mechanism *n = &x->nearest;
  choose_numbers(x, ALL);
  return km_relations_find(n->m, n->index, n->number, n->half, n->count, arena, &x->relations)
             ? KM_OK
             : km_fail(error, KM_MEMORY, "out of memory for the relations of a model");
}

static void count_relations(const km_relations *relations, km_idealisation *out) {
  for (int i = 0; i < relations->count; ++i) {
    const km_relation_kind kind = relations->relation[i].kind;
    out->parallel_axes += kind == KM_PARALLEL_AXES;
    out->right_angles += kind == KM_RIGHT_ANGLE;
    out->equal_lengths += kind == KM_EQUAL_LENGTHS;
  }
}

static km_status examine(km_model *model, int index, const shared_data *shared, result *r, km_messages *messages,
                         km_error *error) {
  const km_mechanism *m = shared->m;
  const km_substructure *sub = &m->substructures[index];
  examination x = {.model = model, .options = *shared->options, .verdict = {.substructure = index}};
  km_arena arena = {0};
  km_status status = KM_OK;
  bool converged = false, found = false, regular = false;
  if (!km_rounded_numbers_find(m, index, shared->owner, &arena, &x.numbers))
    status = km_fail(error, KM_MEMORY, "out of memory for the digits of a model");
  bool is_examined = sub->loop_count > 0 && sub->columns <= MOST_COLUMNS && x.numbers.count > 0, is_exact = false;
  if (!status && is_examined && !x.numbers.is_rounded && !shared->regular) {
    status = accept_exact(shared, index, &x.verdict, &is_exact, error);
    if (is_exact)
      record_verdict(&x.verdict, r);
  }
  if (!status && is_examined && !is_exact) {
    status = km_nearest_create(model, &x.options, m, shared->s, shared->written, index, x.numbers.count, &arena,
                               &x.nearest, error);
    if (!status)
      status = examine_as_written(&x, &converged, error);
    bool is_suspect = converged && ((x.lowest < x.highest && x.numbers.is_rounded) || x.gap > km_relative_zero);
    if (!status && shared->regular)
      status = find_relations(&x, &arena, error);
    if (!status && is_suspect)
      status = find_regular_rank(&x, &found, error);
    x.verdict.verdict = found ? KM_ROUNDING_FOUND : is_suspect ? KM_ROUNDING_BEYOND : KM_ROUNDING_EXACT;
    if (found) {
      x.verdict.mobility = x.nearest.columns - x.nearest.rank;
      record_changes(&x, r);
      add_note(&x, m, messages);
    } else if (!status && converged && x.relations.count > 0) {
      x.nearest.relations = &x.relations;
      status = make_regular(&x, &regular, error);
    }
    if (regular)
      record_changes(&x, r);
    else if (!status && !found && (is_suspect || shared->regular))
      status = restore(&x, error);
    if (!status)
      add_words(&x, m, &r->words);
    if (found || regular)
      count_relations(&x.relations, r->out);
    km_nearest_release(&x.nearest);
    if (!status)
      record_verdict(&x.verdict, r);
  }
  km_arena_free(&arena);
  return status;
}

static void set_tolerance(km_model *model, double tolerance, bool is_given) {
  model->closure_tolerance = tolerance;
  model->closure_tolerance_given = is_given;
}

/* A tolerance that a reader inferred is needed unless the numbers that are used now close the loops that it is for. */
static void settle_tolerance(km_model *model, const km_idealisation *out, double inferred) {
  bool found = false, beyond = false;
  for (int i = 0; i < out->count; ++i) {
    found = found || out->verdict[i].verdict == KM_ROUNDING_FOUND;
    beyond = beyond || out->verdict[i].verdict == KM_ROUNDING_BEYOND;
  }
  if (model->closure_tolerance_inferred && (!found || beyond))
    set_tolerance(model, inferred, true);
}

/* Compiles the model as written, with a state and what else is shared. */
static km_status prepare(km_model *model, km_arena *arena, shared_data *out, km_error *error) {
  km_pose *written = KM_ARENA_NEW(arena, km_pose, (size_t)model->frame_count);
  for (int f = 0; written && f < model->frame_count; ++f)
    written[f] = model->frames[f].pose;
  out->written = written;
  km_status status = km_mechanism_compile_as(model, out->options, &out->m, error);
  if (!status)
    status = km_state_create(out->m, &out->s, error);
  if (status)
    return status;
  km_poses_compute(out->m, out->s);
  out->owner = km_frame_owners(out->m, arena);
  return arena->failed ? km_fail(error, KM_MEMORY, "out of memory for the digits of a model") : KM_OK;
}

static km_status examine_all(km_model *model, bool regular, result *r, km_messages *messages, km_error *error) {
  km_arena arena = {0};
  km_hold *holds = km_model_list_holds(model);
  double inferred = model->closure_tolerance;
  if (model->closure_tolerance_inferred)
    set_tolerance(model, km_relative_zero, false);
  const km_compiling options = {.holds = holds, .hold_count = model->hold_count};
  shared_data shared = {.options = &options, .regular = regular};
  km_status status = holds ? prepare(model, &arena, &shared, error) : KM_MEMORY;
  for (int i = 0; !status && i < shared.m->topology.substructure_count; ++i)
    status = examine(model, i, &shared, r, messages, error);
  km_state_free(shared.s);
  km_mechanism_free(shared.m);
  km_free(holds);
  km_arena_free(&arena);
  settle_tolerance(model, r->out, inferred);
  model->digits = km_text_move_to_arena(&r->words, &model->arena);
  return r->failed || !holds || model->arena.failed
             ? km_fail(error, KM_MEMORY, "out of memory for the digits of a model")
             : status;
}

km_status km_model_idealise(km_model *model, bool regular, km_messages *messages, km_idealisation *found,
                            km_error *error) {
  km_idealisation own = {0};
  result r = {.out = found ? found : &own};
  *r.out = (km_idealisation){0};
  if (!model)
    return km_fail(error, KM_USAGE, "found no model");
  km_status status = KM_OK;
  if (model->written_count > 0 && (!model->closure_tolerance_given || model->closure_tolerance_inferred))
    status = examine_all(model, regular, &r, messages, error);
  km_idealisation_free(&own);
  return status;
}

void km_idealisation_free(km_idealisation *idealisation) {
  if (!idealisation)
    return;
  km_free(idealisation->verdict);
  km_free(idealisation->change);
  *idealisation = (km_idealisation){0};
}
