/* Couplings as MJCF has them: of two joints by a polynomial, of more by tendons. */
#include "exchange/mjcf/mjcf_write.h"

#include <math.h>

/* A polynomial P(y) = x as one in y - b of x - a. */
static void count_from(double *c, int count, double a, double b) {
  for (int i = 0; i < count; ++i)
    for (int k = count - 2; k >= i; --k)
      c[k] += b * c[k + 1];
  c[0] -= a;
}

static const char *name_of_coordinate(const km_written *w, int coordinate) {
  return w->model->coordinates[coordinate].label;
}

static void add_equality(km_written *w, const char *name, const char *one, const char *two, const double *c,
                         int count) {
  km_xml_begin(&w->xml, "joint");
  km_xml_set(&w->xml, "name", name);
  km_xml_set(&w->xml, "joint1", one);
  if (two)
    km_xml_set(&w->xml, "joint2", two);
  km_xml_set_numbers(&w->xml, "polycoef", c, count, false);
  km_xml_end(&w->xml, "joint");
}

/* A coupling of more than two joints: the length of a fixed tendon, relative to the written configuration. */
static bool needs_tendon(const km_model_coupling *coupling) {
  return coupling->count > 2 && coupling->ratios;
}

/* Constant of Σ ratio · q in radians and metres: as stated in the file, or in the written configuration. */
static double constant_of(const km_written *w, const km_model_coupling *coupling) {
  double constant = coupling->constant;
  for (int k = 0; k < coupling->count && !coupling->constant_given; ++k)
    constant += coupling->ratios[k] * w->q[coupling->coordinates[k]] / km_written_unit(w, coupling->coordinates[k]);
  return constant;
}

static void add_tendon_constraint(km_written *w, const km_model_coupling *coupling) {
  double c[5] = {constant_of(w, coupling)};
  for (int k = 0; k < coupling->count; ++k)
    c[0] -= coupling->ratios[k] * w->reference[coupling->coordinates[k]] / km_written_unit(w, coupling->coordinates[k]);
  km_xml_begin(&w->xml, "tendon");
  km_xml_set(&w->xml, "name", coupling->name);
  km_xml_set(&w->xml, "tendon1", coupling->name);
  km_xml_set_numbers(&w->xml, "polycoef", c, 5, false);
  km_xml_end(&w->xml, "tendon");
}

void km_mjcf_write_tendons(km_written *w) {
  km_xml_begin(&w->xml, "tendon");
  for (int i = 0; i < w->model->coupling_count; ++i) {
    const km_model_coupling *coupling = &w->model->couplings[i];
    if (!needs_tendon(coupling))
      continue;
    km_xml_begin(&w->xml, "fixed");
    km_xml_set(&w->xml, "name", coupling->name);
    for (int k = 0; k < coupling->count; ++k) {
      double ratio = coupling->ratios[k] / km_written_unit(w, coupling->coordinates[k]);
      km_xml_begin(&w->xml, "joint");
      km_xml_set(&w->xml, "joint", name_of_coordinate(w, coupling->coordinates[k]));
      km_xml_set_numbers(&w->xml, "coef", &ratio, 1, false);
      km_xml_end(&w->xml, "joint");
    }
    km_xml_end(&w->xml, "fixed");
  }
  km_xml_end(&w->xml, "tendon");
}

static void add_coupling(km_written *w, const km_model_coupling *coupling) {
  enum { MOST = 5 };
  double c[MOST] = {0};
  int one = coupling->coordinates[0], two = coupling->count > 1 ? coupling->coordinates[1] : -1;
  int count = coupling->polynomial_count ? coupling->polynomial_count : 2;
  double scale = two >= 0 ? km_written_unit(w, two) : 1.0;
  if (needs_tendon(coupling)) {
    add_tendon_constraint(w, coupling);
    return;
  }
  if (count > MOST) {
    km_written_omit(w, "couplings not written, as their degree is above 4", coupling->name);
    return;
  }
  if (coupling->ratios && coupling->ratios[0] == 0.0)
    return;
  for (int k = 0; k < coupling->polynomial_count; ++k)
    c[k] = coupling->polynomial[k];
  if (coupling->ratios) {
    c[0] = constant_of(w, coupling) / coupling->ratios[0];
    c[1] = two >= 0 ? -coupling->ratios[1] / coupling->ratios[0] : 0.0;
  }
  for (int k = 0; k < count; ++k)
    c[k] *= km_written_unit(w, one) / pow(scale, k);
  count_from(c, count, w->reference[one], two >= 0 ? w->reference[two] : 0.0);
  add_equality(w, coupling->name, name_of_coordinate(w, one), two >= 0 ? name_of_coordinate(w, two) : NULL, c, count);
}

const char *km_mjcf_slide_of(km_written *w, const char *screw) {
  return km_written_text(w, "%s:slide", screw);
}

static void add_screws(km_written *w) {
  for (int j = 0; j < w->model->joint_count; ++j) {
    const km_model_joint *def = &w->model->joints[j];
    const double line[2] = {0.0, def->pitch * w->length / (2.0 * M_PI)};
    if (def->type == KM_SCREW)
      add_equality(w, km_mjcf_slide_of(w, w->joints[j]), km_mjcf_slide_of(w, w->joints[j]), w->joints[j], line, 2);
  }
}

/* MuJoCo refuses a range without an inside: a held joint is a constraint of its own. */
static void add_holds(km_written *w) {
  for (int h = 0; h < w->model->hold_count; ++h) {
    int c = w->model->holds[h].coordinate;
    const char *label = name_of_coordinate(w, c);
    km_joint_type type = w->model->joints[w->model->coordinates[c].joint].type;
    double range[2];
    if (type == KM_SPHERICAL || type == KM_FLOAT)
      continue;
    km_written_range(w, c, range);
    const double line[2] = {range[0] - w->reference[c], 0.0};
    add_equality(w, km_written_text(w, "%s:hold", label), label, NULL, line, 2);
  }
}

void km_mjcf_write_couplings(km_written *w) {
  add_screws(w);
  add_holds(w);
  for (int i = 0; i < w->model->coupling_count; ++i)
    add_coupling(w, &w->model->couplings[i]);
}
