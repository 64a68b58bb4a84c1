/* Values, rates and accelerations of prescribed motions: polynomials, sines, cubic splines of tables,
 * curves (docs/theory.md 11.11). */
#include "dynamics/prescribed_motion.h"

#include "base/memory.h"

#include <gsl/gsl_spline.h>

typedef struct law {
  int coordinate;
  double factor;                  /* radians per angle unit of the model; 1 for lengths */
  double angle;                   /* radians per angle unit, for the phase */
  const km_joint_prescribed *def; /* NULL: value + rate · t */
  double value, rate;
  gsl_spline *spline;       /* spline of a table */
  gsl_interp_accel *lookup; /* accelerator: interval of the last lookup */
} law;

struct km_prescribed {
  int count;
  law *laws;
};

/* Cubic spline of a table, linear for two rows. */
static bool make_spline(law *l) {
  size_t rows = (size_t)l->def->count;
  const gsl_interp_type *type = rows > 2 ? gsl_interp_cspline : gsl_interp_linear;
  double *t = KM_NEW(double, 2 * rows);
  l->spline = gsl_spline_alloc(type, rows);
  l->lookup = gsl_interp_accel_alloc();
  bool done = t && l->spline && l->lookup;
  for (size_t i = 0; done && i < rows; ++i) {
    t[i] = l->def->values[2 * i];
    t[rows + i] = l->def->values[2 * i + 1];
  }
  done = done && gsl_spline_init(l->spline, t, t + rows, rows) == 0;
  km_free(t);
  return done;
}

km_status km_prescribed_create(const km_mechanism *m, km_prescribed **out, km_error *error) {
  const km_model *model = m->model;
  km_prescribed *p = KM_NEW(km_prescribed, 1);
  *out = NULL;
  if (p)
    p->laws = KM_NEW(law, (size_t)model->coordinate_count + 1);
  bool done = p && p->laws;
  for (int j = 0; done && j < model->joint_count; ++j) {
    const km_model_joint *joint = &model->joints[j];
    int c = joint->first_coordinate;
    if (joint->prescribed.law == KM_MOTION_FREE || m->held[c])
      continue;
    law *l = &p->laws[p->count++];
    *l = (law){.coordinate = c,
               .factor = km_model_coordinate_factor(model, c),
               .angle = model->units.angle->si,
               .def = &joint->prescribed};
    done = l->def->law != KM_MOTION_TABLE || make_spline(l);
  }
  if (!done) {
    km_prescribed_free(p);
    return km_fail(error, KM_MEMORY, "out of memory for the prescribed motions");
  }
  *out = p;
  return KM_OK;
}

void km_prescribed_free(km_prescribed *p) {
  for (int i = 0; p && p->laws && i < p->count; ++i) {
    gsl_spline_free(p->laws[i].spline);
    gsl_interp_accel_free(p->laws[i].lookup);
  }
  if (p)
    km_free(p->laws);
  km_free(p);
}

void km_prescribed_set(km_prescribed *p, int coordinate, double value, double rate) {
  int i = 0;
  while (i < p->count && p->laws[i].coordinate != coordinate)
    ++i;
  p->count += i == p->count;
  gsl_spline_free(p->laws[i].spline);
  gsl_interp_accel_free(p->laws[i].lookup);
  p->laws[i] = (law){.coordinate = coordinate, .value = value, .rate = rate};
}

int km_prescribed_count(const km_prescribed *p) {
  return p->count;
}

/* Horner's scheme for value, rate and acceleration. */
static void polynomial_at(const km_joint_prescribed *def, double t, double motion[3]) {
  for (int k = def->count - 1; k >= 0; --k) {
    motion[2] = motion[2] * t + 2.0 * motion[1];
    motion[1] = motion[1] * t + motion[0];
    motion[0] = motion[0] * t + def->values[k];
  }
}

/* offset + amplitude sin(2π frequency t + phase), with its derivatives. */
static void sine_at(const law *l, double t, double motion[3]) {
  const double *v = l->def->values; /* values: offset, amplitude, frequency, phase */
  double w = 2.0 * M_PI * v[2], angle = w * t + l->angle * v[3];
  motion[0] = v[0] + v[1] * sin(angle);
  motion[1] = v[1] * w * cos(angle);
  motion[2] = -v[1] * w * w * sin(angle);
}

/* Value, rate and acceleration of a table; beyond its ends it continues linearly. */
static void table_at(const law *l, double t, double motion[3]) {
  const double *v = l->def->values;
  int last = l->def->count - 1;
  double inside = t < v[0] ? v[0] : t > v[2 * last] ? v[2 * last] : t;
  motion[0] = gsl_spline_eval(l->spline, inside, l->lookup);
  motion[1] = gsl_spline_eval_deriv(l->spline, inside, l->lookup);
  motion[2] = inside == t ? gsl_spline_eval_deriv2(l->spline, inside, l->lookup) : 0.0;
  motion[0] += (t - inside) * motion[1];
}

int km_prescribed_at(const km_prescribed *p, int index, double time, double motion[3]) {
  const law *l = &p->laws[index];
  motion[0] = motion[1] = motion[2] = 0.0;
  if (!l->def) {
    motion[0] = l->value + l->rate * time;
    motion[1] = l->rate;
    return l->coordinate;
  }
  if (l->def->law == KM_MOTION_POLYNOMIAL)
    polynomial_at(l->def, time, motion);
  else if (l->def->law == KM_MOTION_SINE)
    sine_at(l, time, motion);
  else if (l->def->law == KM_MOTION_CURVE)
    km_curve_at(&l->def->curve, time, motion);
  else
    table_at(l, time, motion);
  for (int i = 0; i < 3; ++i)
    motion[i] *= l->factor;
  return l->coordinate;
}
