/* Text of kspace modes. */
#include "kspace/modes_answer.h"

#include "kmech/data.h"
#include "kmech/inspect.h"
#include "kmech/mobility.h"
#include "kmech/model.h"
#include "kmech/report.h"

#include <math.h>

void kspace_print_leverage(const kspace_modes_answer *a, int i, km_text *out) {
  const km_advantage *advantage = &a->advantage[i];
  const char *unit = km_advantage_unit(a->pose->model, &a->input, &a->output);
  if (advantage->state == KM_ADVANTAGE_FINITE)
    km_text_format(out, "%.4g%s%s", advantage->value, *unit ? " " : "", unit);
  else
    km_text_add(out, km_advantage_state_name(advantage->state));
}

void kspace_print_locked(const kspace_modes_answer *a, km_text *out) {
  for (int i = 0; i < a->locked_count; ++i)
    km_text_format(out, "%s%s at %.6g %s", i ? ", " : " with ", km_model_coordinate_label(a->pose->model, a->locked[i]),
                   km_state_coordinate(a->pose->state, a->locked[i]),
                   km_model_coordinate_unit(a->pose->model, a->locked[i]));
}

/* The verdict, and the reason why the list may lack modes. */
static void print_gap(const km_all_modes *m, km_text *out) {
  switch (m->gap) {
  case KM_GAP_NONE:
    km_text_format(out,
                   "complete: the trace test passed, and %s %d complex solutions was followed to the closed loops\n",
                   m->complex_solutions == 1 ? "the one of" : "each of", m->complex_solutions);
    break;
  case KM_GAP_TRACE:
    km_text_format(
        out,
        "at least these: the trace test did not pass. %d complex solutions are known, about %d are estimated "
        "(random starts found %d of them once only, in %d finds); another --seed may find more\n",
        m->complex_solutions, m->estimate, m->found_once, m->samples);
    break;
  case KM_GAP_LOST:
    km_text_add(out, "at least these: solutions were lost on the way to the closed loops; try another --seed\n");
    break;
  case KM_GAP_SINGULAR:
    km_text_format(out,
                   "at least these: %d of %d complex solutions are singular, so that modes coincide there or form "
                   "curves; change a dimension a little to tell them apart\n",
                   m->singular, m->complex_solutions);
    break;
  case KM_GAP_MOVES:
    km_text_add(out, "self-motion: bodies move although the locked joints stay. Modes that move are samples of "
                     "infinitely many; lock one joint more by --set, or change a dimension\n");
    break;
  case KM_GAP_LIMIT:
    km_text_format(out, "at least these: the search ended at its limit of work; %d complex solutions are known\n",
                   m->complex_solutions);
    break;
  case KM_GAP_STOPPED:
    km_text_format(out, "at least these: the search was stopped; %d complex solution%s known\n", m->complex_solutions,
                   m->complex_solutions == 1 ? " is" : "s are");
    break;
  case KM_GAP_REFUSED: /* an error of kspace modes */
    break;
  }
}

/* Worst figures of the proofs. */
static void print_proofs(const km_all_modes *m, km_text *out) {
  int proved = 0, left_out = 0;
  double bound = 0.0, radius = HUGE_VAL;
  for (int i = 0; i < m->count; ++i)
    if (!m->evidence[i].is_certified && m->evidence[i].kantorovich <= 0.5) {
      ++left_out; /* the proof holds for the equations that are left, not for the others */
    } else if (m->evidence[i].is_certified) {
      ++proved;
      bound = fmax(bound, m->evidence[i].error_bound);
      radius = fmin(radius, m->evidence[i].radius);
    }
  if (proved > 0)
    km_text_format(out, "proved: %s%d of them, each one solution within %.2g rad or sizes and no other within %.2g\n",
                   proved == m->count ? "all " : "", proved, bound, radius);
  if (left_out > 0)
    km_text_add(out, "not proved: the loops are overconstrained, so that some of their equations are left out\n");
  if (m->outside > 0)
    km_text_format(out, "%d mode%s outside the joint limits\n", m->outside, m->outside == 1 ? " is" : "s are");
}

/* Numbers of the modes of one circuit: "2, 4 and 7". */
static void print_members(const kspace_modes_answer *a, int circuit, km_text *out) {
  int left = 0, printed = 0;
  for (int i = 0; i < a->modes.count; ++i)
    left += a->circuits.circuit[i] == circuit;
  for (int i = 0; i < a->modes.count; ++i)
    if (a->circuits.circuit[i] == circuit) {
      km_text_format(out, "%s%d", printed == 0 ? "" : left == 1 ? " and " : ", ", i + 1);
      ++printed;
      --left;
    }
}

/* Writes the modes of each circuit, or the reason why they aren't known. */
static void print_circuits(const kspace_modes_answer *a, km_text *out) {
  const km_mode_circuits *c = &a->circuits;
  switch (c->gap) {
  case KM_CIRCUIT_GAP_NONE:
  case KM_CIRCUIT_GAP_LOST:
    if (c->freedom == 0) {
      km_text_add(out,
                  "circuits: nothing moves with the locked joints free, so that each mode is a circuit of its own\n");
      return;
    }
    if (a->modes.count == 1) {
      km_text_add(out, "1 mode in 1 circuit\n");
      return;
    }
    km_text_format(out, "%d modes in %s%d circuit%s: ", a->modes.count, c->gap ? "at most " : "", c->count,
                   c->count == 1 ? "" : "s");
    for (int k = 1; k <= c->count; ++k) {
      km_text_add(out, k == 1 ? "" : "; ");
      print_members(a, k, out);
    }
    km_text_add(out, c->count == 1 ? ". The motion connects them\n"
                     : c->gap      ? ". A curve was not followed to its end: circuits may be connected there\n"
                                   : ". Another circuit can't be reached without taking the mechanism apart\n");
    return;
  case KM_CIRCUIT_GAP_FREEDOMS:
    km_text_format(out,
                   "circuits: not answered, since the bodies move in %d ways with the locked joints free, not in one; "
                   "hold all joints but one rigid by --hold\n",
                   c->freedom);
    return;
  case KM_CIRCUIT_GAP_SELF_MOTION:
    km_text_add(out, "circuits: not answered, since modes are samples of self-motions\n");
    return;
  case KM_CIRCUIT_GAP_BALL:
    km_text_add(out, "circuits: not answered, since nothing but ball joints is held; hold a hinge or a slide\n");
    return;
  case KM_CIRCUIT_GAP_STOPPED:
    km_text_add(out, "circuits: not answered, since the search was stopped\n");
    return;
  }
}

void kspace_print_modes(const kspace_modes_answer *a, km_text *out) {
  const km_all_modes *m = &a->modes;
  int coordinates = km_model_coordinate_count(a->pose->model);
  km_text_format(out, "%s: %d assembly mode%s", a->o->model, m->count, m->count == 1 ? "" : "s");
  kspace_print_locked(a, out);
  km_text_add(out, "\n");
  print_gap(m, out);
  print_proofs(m, out);
  print_circuits(a, out);
  for (int i = 0; i < m->count; ++i) {
    const km_mode_evidence *e = &m->evidence[i];
    km_text_format(out, "  %d:", i + 1);
    for (int c = 0; c < coordinates; ++c)
      km_text_format(out, "%s %s %.6g %s", c ? "," : "", km_model_coordinate_label(a->pose->model, c),
                     m->coordinates[i * coordinates + c], km_model_coordinate_unit(a->pose->model, c));
    if (a->circuits.count > 0)
      km_text_format(out, "; circuit %d", a->circuits.circuit[i]);
    if (a->has_leverage) {
      km_text_format(out, "; leverage %s/%s ", a->input.name, a->output.name);
      kspace_print_leverage(a, i, out);
    }
    km_text_format(out, "%s%s%s\n",
                   e->moves         ? "; moves"
                   : e->is_singular ? "; singular"
                                    : "",
                   e->is_certified || e->is_singular ? "" : "; not proved",
                   e->is_within_limits ? "" : "; outside the limits");
  }
}
