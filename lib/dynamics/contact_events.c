/* Contacts that a step passed over: the bodies are apart at both ends of it and touch in between, so that no
 * evaluation noticed them (docs/theory.md 11.6, 11.15).
 *
 *   δ(t) < 0 at both ends t_0, t_1 of a step;  searched if  −max(δ_0, δ_1) <= h (|δ̇_0| + |δ̇_1|) + |δ_1 − δ_0|
 *   δ at eight samples of the interpolant, then its maximum */
#include "dynamics/simulation.h"

#include "base/event_locator.h"

/* Sets poses and twists of the bodies with forces at a time within the last step. */
static bool move_to(km_simulation *run, double time) {
  if (!km_simulation_interpolate(run, time, run->at))
    return false;
  km_simulation_locate_bodies(run, run->at, time);
  return true;
}

/* Contact of a module at a time. */
typedef struct contact_at {
  km_simulation *run;
  const km_model_module *module;
} contact_at;

/* Distance −δ of the bodies; NaN: not known. */
static double distance_at(double time, void *context) {
  const contact_at *c = context;
  return move_to(c->run, time)
             ? -km_contact_touch(c->run->dynamics->mechanism, c->run->dynamics->forces, c->module).depth
             : nan("");
}

/* True if the bodies can have touched, judged by depth and rate at both ends of the step. */
static bool can_have_touched(const km_touch *one, const km_touch *other, double h) {
  double reach = h * (fabs(one->depth_rate) + fabs(other->depth_rate)) + fabs(other->depth - one->depth);
  return one->depth < 0.0 && other->depth < 0.0 && -fmax(one->depth, other->depth) <= reach;
}

/* Time within the last step at which the bodies overlap by more than `depth`; infinity: none. */
static double find_touch(km_simulation *run, const km_model_module *module, const km_touch *one, const km_touch *other,
                         double depth) {
  contact_at at = {run, module};
  return km_locate_excursion(distance_at, &at, run->last_time, run->time, -one->depth, -other->depth, depth);
}

/* Time within the last step at which the bodies begin or cease to touch; infinity: they don't, or the step begins or
 * ends there. */
static double find_change(km_simulation *run, const km_model_module *module, const km_touch *one,
                          const km_touch *other) {
  static const double end = 1e-6; /* part of the step; a change so close to its ends needs no shorter step */
  const double h = run->time - run->last_time;
  contact_at at = {run, module};
  if ((one->depth > 0.0) == (other->depth > 0.0))
    return HUGE_VAL;
  const double time = km_locate_root(distance_at, &at, run->last_time, run->time, -one->depth, -other->depth);
  return time > run->last_time + end * h && time < run->time - end * h ? time : HUGE_VAL;
}

double km_contacts_passed_over(km_simulation *run) {
  const km_dynamics *d = run->dynamics;
  const double error = (run->def.absolute + run->def.relative) * d->mechanism->length;
  double first = HUGE_VAL;
  for (int i = 0; i < d->forces->contact_count; ++i) {
    const km_model_module *contact = d->forces->contacts[i];
    if (!move_to(run, run->last_time))
      return HUGE_VAL;
    const km_touch one = km_contact_touch(d->mechanism, d->forces, contact);
    move_to(run, run->time);
    const km_touch other = km_contact_touch(d->mechanism, d->forces, contact);
    first = fmin(first, find_change(run, contact, &one, &other));
    if (can_have_touched(&one, &other, run->time - run->last_time))
      first = fmin(first, find_touch(run, contact, &one, &other, error));
  }
  if (d->forces->contact_count)
    move_to(run, run->time);
  return first;
}
