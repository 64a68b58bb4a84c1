/* Driven sweeps in a batch: advance from row to row, with samples between rows (theory 4.12, 10.1). */
#include "sweep/driver_sweep.h"

#include <math.h>
#include <string.h>

/* Returns how many rows can be passed at once, if the observer does not read all of them. */
static int count_passable_rows(const km_driver_sweep *w) {
  const km_sweeper *r = w->r;
  const km_sweep_plan *plan = r->plan;
  if (w->step == 0 || !r->observer->number_cells || r->out->start.stop || plan->derivatives || plan->point_count > 0)
    return 1;
  int left = plan->steps - w->step + 1;
  return left < KM_BATCH_ROWS ? left : KM_BATCH_ROWS;
}

/* Rows at the end of those passed that are reported to the observer. */
enum { KM_REPORTED_ROWS = 2 };

/* Advances the counters by `count` written rows, the last one at s. */
static void advance_counters(km_driver_sweep *w, int count, double s) {
  w->last = s;
  w->row += count;
  w->step += count;
}

/* Writes the passed rows that are not reported to the observer, at s[row × KM_BATCH_LANES], of `count` in all. */
static void write_unreported_rows(km_driver_sweep *w, int count, const double *s) {
  const int reported = !w->r->observer->row_written ? 0
                       : count < KM_REPORTED_ROWS   ? count
                                                    : KM_REPORTED_ROWS,
            unreported = count - reported;
  w->job->status = km_sweeper_passed_rows(w->r, w->at.motion, unreported, w->row, s, w->job->error);
  if (unreported > 0)
    advance_counters(w, unreported, s[(unreported - 1) * KM_BATCH_LANES]);
}

/* Writes a passed row, which the state represents, and reports it to the observer. */
static void write_reported_row(km_driver_sweep *w, double s) {
  km_sweeper *r = w->r;
  r->is_batched = r->is_passed_row = true;
  r->residual = km_driver_motion_batched_residual(w->at.motion);
  if (!w->job->status)
    w->job->status = km_sweeper_row(r, w->row, s, w->job->error);
  r->is_passed_row = false;
  advance_counters(w, 1, s);
}

/* Writes the rows that the sweeps `active` have passed. */
static void write_passed_rows(km_driver_sweep *sweeps, unsigned active, km_batch *lanes, int count,
                              const double *rows) {
  for (unsigned bits = active; bits; bits &= bits - 1)
    write_unreported_rows(&sweeps[__builtin_ctz(bits)], count, rows + __builtin_ctz(bits));
  for (int k = count > KM_REPORTED_ROWS ? count - KM_REPORTED_ROWS : 0; k < count; ++k) {
    km_batch_write_row(lanes, k);
    for (unsigned bits = active; bits; bits &= bits - 1) {
      int i = __builtin_ctz(bits);
      if (sweeps[i].r->observer->row_written)
        write_reported_row(&sweeps[i], rows[k * KM_BATCH_LANES + i]);
    }
  }
}

/* True if the observer reads more than the lane provides. */
static bool needs_state(const km_sweeper *r) {
  const km_observer *observer = r->observer;
  return observer->reads_jacobian || (observer->reads_basis && km_factor_freedom(r->s->factor[r->substructure]) > 1);
}

void km_driver_sweep_prepare(km_driver_sweep *w) {
  km_sweeper *r = w->r;
  r->is_batched = km_driver_motion_is_batched(w->at.motion);
  if (r->is_batched && needs_state(r)) {
    km_driver_motion_prepare_read(w->at.motion);
    r->is_batched = false;
  }
  if (r->is_batched)
    r->residual = km_driver_motion_batched_residual(w->at.motion);
  if (r->is_batched && r->observer->reads_basis && !r->observer->uses_direction)
    km_driver_motion_read_basis(w->at.motion);
}

static bool samples_between_rows(const km_driver_sweep *w) {
  return w->r->observer->sampled_between && w->step > 0;
}

static km_row_interval interval_to(const km_driver_sweep *w, double s) {
  return (km_row_interval){w->last, s, w->row == 1, w->step == w->r->plan->steps};
}

/* Moves singly to the row at s, with the samples between from part `first` on. */
static km_motion_end advance_singly(km_driver_sweep *w, double s, int first) {
  km_row_interval interval = interval_to(w, s);
  if (samples_between_rows(w))
    w->job->status = km_sweeper_sample_to_row(w->r, w->at.motion, &interval, first, w->job->error);
  return km_driver_motion_move_to(w->at.motion, s);
}

/* True if both sweeps have the same range and the same step. */
static bool is_same_row(const km_driver_sweep *a, const km_driver_sweep *b) {
  const km_sweep_plan *p = a->r->plan, *q = b->r->plan;
  return a->step == b->step && p->from == q->from && p->to == q->to && p->steps == q->steps;
}

/* Returns the active sweeps at the same row as the first of them. */
static unsigned find_same_row(const km_driver_sweep *sweeps, unsigned active) {
  unsigned same = 0;
  for (unsigned bits = active; bits; bits &= bits - 1)
    same |= is_same_row(&sweeps[__builtin_ctz(active)], &sweeps[__builtin_ctz(bits)]) ? bits & -bits : 0;
  return same;
}

/* Computes the targets of the active sweeps k rows ahead; those in `same` have the same target. */
static void set_targets(const km_driver_sweep *sweeps, unsigned active, unsigned same, int k, double *targets) {
  const km_driver_sweep *first = &sweeps[__builtin_ctz(active)];
  double target = km_driver_sweep_value(first->r->plan, first->step + k);
  for (int i = 0; i < KM_BATCH_LANES; ++i)
    targets[i] = target;
  for (unsigned bits = active & ~same; bits; bits &= bits - 1) {
    int i = __builtin_ctz(bits);
    targets[i] = km_driver_sweep_value(sweeps[i].r->plan, sweeps[i].step + k);
  }
}

static bool any_reads_rows(const km_driver_sweep *sweeps, unsigned active) {
  bool found = false;
  for (unsigned bits = active; bits; bits &= bits - 1)
    found = found || sweeps[__builtin_ctz(bits)].r->observer->row_written;
  return found;
}

/* Advances the active sweeps in the batch: through rows that are not reported, which are written, to the next row.
 * targets[lane]: of the next row, afterwards of the reached one. */
static void advance_in_batch(km_driver_sweep *sweeps, unsigned active, km_batch *lanes, double *targets,
                             km_motion_end *reaches) {
  double rows[KM_BATCH_ROWS * KM_BATCH_LANES];
  int count = KM_BATCH_ROWS;
  for (unsigned bits = active; bits; bits &= bits - 1) {
    int passable = count_passable_rows(&sweeps[__builtin_ctz(bits)]);
    count = passable < count ? passable : count;
  }
  unsigned same = find_same_row(sweeps, active);
  memcpy(rows, targets, KM_BATCH_LANES * sizeof *rows);
  for (int k = 1; k < count; ++k)
    set_targets(sweeps, active, same, k, rows + k * KM_BATCH_LANES);
  int passed = km_batch_advance_rows(lanes, active, rows, count, any_reads_rows(sweeps, active));
  write_passed_rows(sweeps, active, lanes, passed, rows);
  memcpy(targets, rows + passed * KM_BATCH_LANES, KM_BATCH_LANES * sizeof *targets);
  km_batch_arrive(lanes, active, targets, reaches);
}

/* Returns the active sweeps whose observers take samples between rows. */
static unsigned find_sampling_sweeps(const km_driver_sweep *sweeps, unsigned active) {
  unsigned found = 0;
  for (unsigned bits = active; bits; bits &= bits - 1)
    found |= samples_between_rows(&sweeps[__builtin_ctz(bits)]) ? bits & -bits : 0;
  return found;
}

/* Advances the sweeps `batched`, which are at one row, over part k of their intervals; those that leave the batch
 * move singly to their rows. Returns the others. */
static unsigned advance_part(km_driver_sweep *sweeps, unsigned batched, int k, km_batch *lanes, const double *targets,
                             km_motion_end *reaches) {
  double samples[KM_BATCH_LANES] = {0}; /* registers also read unused lanes */
  unsigned in_batch = 0;
  int parts = km_sweeper_interval_parts(sweeps[__builtin_ctz(batched)].r);
  for (unsigned bits = batched; bits; bits &= bits - 1) {
    int i = __builtin_ctz(bits);
    km_row_interval interval = interval_to(&sweeps[i], targets[i]);
    samples[i] = km_sweeper_part_end(interval.from, interval.to, k, parts);
    in_batch |= k == parts && interval.is_last ? 0 : bits & -bits;
  }
  unsigned reached = km_batch_try(lanes, in_batch, samples, reaches);
  for (unsigned bits = batched & ~reached; bits; bits &= bits - 1) {
    int i = __builtin_ctz(bits);
    reaches[i] = advance_singly(&sweeps[i], targets[i], k);
  }
  for (unsigned bits = k < parts ? reached : 0; bits; bits &= bits - 1) {
    km_driver_sweep *w = &sweeps[__builtin_ctz(bits)];
    km_driver_sweep_prepare(w);
    w->job->status =
        w->r->observer->sampled_between(w->r->observer->self, w->r, samples[__builtin_ctz(bits)], w->job->error);
    w->r->is_batched = false;
    reached &= w->job->status ? ~(bits & -bits) : ~0U;
  }
  return reached;
}

/* Moves the active sweeps to their rows with samples between, in the batch as far as possible. */
static void advance_with_samples(km_driver_sweep *sweeps, unsigned active, km_batch *lanes, const double *targets,
                                 km_motion_end *reaches) {
  unsigned batched = lanes ? find_sampling_sweeps(sweeps, active) : 0;
  batched = batched ? find_same_row(sweeps, batched) : 0;
  for (unsigned bits = active; bits; bits &= bits - 1) {
    int i = __builtin_ctz(bits);
    if (batched >> i & 1 && !interval_to(&sweeps[i], targets[i]).is_first)
      continue;
    batched &= ~(1u << i);
    reaches[i] = advance_singly(&sweeps[i], targets[i], 1);
  }
  int parts = batched ? km_sweeper_interval_parts(sweeps[__builtin_ctz(batched)].r) : 0;
  for (int k = 1; k <= parts && batched; ++k)
    batched = advance_part(sweeps, batched, k, lanes, targets, reaches);
}

void km_driver_sweeps_advance(km_driver_sweep *sweeps, unsigned active, km_batch *lanes, double *targets,
                              km_motion_end *reaches) {
  if (lanes && active && !find_sampling_sweeps(sweeps, active))
    advance_in_batch(sweeps, active, lanes, targets, reaches);
  else
    advance_with_samples(sweeps, active, lanes, targets, reaches);
}
