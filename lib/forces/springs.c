/* Springs: force modules of type stiffness, a piecewise polynomial of a displacement between frames or in a joint
 * (docs/theory.md 11.8). */
#include "forces/forces.h"
#include "forces/motion_forces.h"

static double piece_force(const km_law *law, int piece, double x) {
  double force = 0.0;
  for (int k = law->start[piece + 1] - 1; k >= law->start[piece]; --k)
    force = force * x + law->coefficients[k];
  return force;
}

/* Value of a piecewise polynomial. */
double km_law_force(const km_law *law, double x) {
  int piece = 0;
  while (piece < law->knot_count && x >= law->knots[piece])
    ++piece;
  return piece_force(law, piece, x);
}

double km_module_law_value(const km_model_module *module, double variable) {
  return module->curve.form ? km_curve_value(&module->curve, variable) : km_law_force(&module->law, variable);
}

/* Half width over which the jump at a knot is spread: at most half the distance to the next knot, so that spreads
 * don't overlap. */
static double spread_at(const km_law *law, int knot, double width) {
  if (knot > 0)
    width = fmin(width, 0.5 * (law->knots[knot] - law->knots[knot - 1]));
  if (knot + 1 < law->knot_count)
    width = fmin(width, 0.5 * (law->knots[knot + 1] - law->knots[knot]));
  return width;
}

double km_law_resistance(const km_law *law, double rate, double width) {
  double force = km_law_force(law, rate);
  for (int k = 0; k < law->knot_count; ++k) {
    double beyond = rate - law->knots[k], spread = spread_at(law, k, width);
    if (fabs(beyond) >= spread)
      continue;
    double jump = piece_force(law, k + 1, law->knots[k]) - piece_force(law, k, law->knots[k]);
    return force + 0.5 * jump * (km_slip_share(beyond, spread) - (beyond < 0.0 ? -1.0 : 1.0));
  }
  return force;
}

/* Integral of a piecewise polynomial from 0, knot by knot. */
double km_law_work(const km_law *law, double x) {
  double from = 0.0, work = 0.0;
  int piece = 0, step = x < 0.0 ? -1 : 1;
  while (piece < law->knot_count && 0.0 >= law->knots[piece])
    ++piece;
  for (bool last = false; !last;) {
    /* integrates to the next knot, or to x */
    int knot = step > 0 ? piece : piece - 1;
    double to = x;
    last = knot < 0 || knot >= law->knot_count || (x - law->knots[knot]) * step <= 0.0;
    if (!last)
      to = law->knots[knot];
    double at_to = 0.0, at_from = 0.0;
    for (int k = law->start[piece + 1] - 1; k >= law->start[piece]; --k) {
      double c = law->coefficients[k] / (k - law->start[piece] + 1);
      at_to = (at_to + c) * to;
      at_from = (at_from + c) * from;
    }
    work += at_to - at_from;
    from = to;
    piece += step;
  }
  return work;
}

void km_springs_collect(const km_model *model, km_forces *f) {
  for (int i = 0; i < model->module_count; ++i)
    if (model->modules[i].type == KM_MODULE_STIFFNESS && model->modules[i].variable == KM_VARIABLE_DISPLACEMENT)
      f->springs[f->spring_count++] = &model->modules[i];
}

double km_module_saturate(const km_model_module *module, double force) {
  return module->saturates ? fmin(fmax(force, module->least), module->most) : force;
}

/* True if a spring's energy is known: it acts where it measures, by a piecewise polynomial, and not on a ball's
 * coordinate, whose rate isn't conjugate to its torque. */
static bool is_conservative(const km_mechanism *m, const km_model_module *module) {
  const km_module_port *in = &module->input, *out = &module->output;
  if (module->input_count != 1 || module->inputs[0].weight != 1.0 || module->saturates || module->curve.form)
    return false;
  if (in->coordinate >= 0 || out->coordinate >= 0)
    return in->coordinate == out->coordinate && m->ball_of[in->coordinate] < 0;
  return in->coordinate == out->coordinate && in->frame[0] == out->frame[0] && in->frame[1] == out->frame[1] &&
         module->inputs[0].distance == module->distance;
}

double km_springs_add(const km_mechanism *m, const km_state *s, km_forces *f) {
  double power_supplied = 0.0;
  for (int i = 0; i < f->spring_count; ++i) {
    const km_model_module *spring = f->springs[i];
    double x = km_module_measure(m, s, f, spring).displacement;
    double force = km_module_saturate(spring, km_module_law_value(spring, x));
    double power = force * km_module_apply(m, s, f, spring, force);
    *km_module_report_of(m, f, spring) = (km_module_report){.variable = x, .force = force, .power = power};
    if (!is_conservative(m, spring))
      power_supplied += power;
  }
  return power_supplied;
}

double km_springs_energy(const km_mechanism *m, const km_state *s, const km_forces *f) {
  double energy = 0.0;
  for (int i = 0; i < f->spring_count; ++i)
    if (is_conservative(m, f->springs[i]))
      energy -= km_law_work(&f->springs[i]->law, km_module_measure(m, s, f, f->springs[i]).displacement);
  return energy;
}
