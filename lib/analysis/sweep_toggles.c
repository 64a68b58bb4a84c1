/* Where a joint loses its grip: roots of its entry in the direction of motion. */
#include "analysis/sweeper.h"

/* |z| below this is 0: z = Z_j of the one free direction, known to about 1e-12. */
static const double zero = 1e-9;

bool km_sweeper_add_toggle(km_mobility_sweep *out, int coordinate, double s) {
  void *toggles = out->toggles;
  if (!km_reserve(&toggles, &out->toggle_capacity, out->toggle_count + 1, sizeof *out->toggles))
    return false;
  out->toggles = toggles;
  out->toggles[out->toggle_count++] = (km_toggle){coordinate, s};
  return true;
}

static void normalise(const km_mechanism *m, const double *rates, double *z) {
  double sum = 0.0;
  for (int c = 0; c < m->coordinate_count; ++c) {
    z[c] = m->scale[c] * rates[c];
    sum += z[c] * z[c];
  }
  for (int c = 0; c < m->coordinate_count; ++c)
    z[c] /= sqrt(sum);
}

/* The unit direction of the one free motion, in the order of the coordinates; false where there is more than
 * one, or the driver stands at its own toggle. */
static bool direction(const km_sweeper *r, double *z) {
  if (r->substructure < 0 || km_partition_freedom(&r->s->partition[r->substructure]) != 1 ||
      !r->mover.rates(r->mover.self, r->rates))
    return false;
  normalise(r->m, r->rates, z);
  return true;
}

/* Between last_s and s the sign of z_c changes: where exactly, by regula falsi (Illinois) on the closed pose. */
static double locate(const km_sweeper *r, int c, double s) {
  double a = r->last_s, b = s, fa = r->last_z[c], fb = r->z[c], root = b;
  for (int i = 0; i < 60 && fabs(b - a) > 1e-13 * (fabs(a) + fabs(b)); ++i) {
    root = (a * fb - b * fa) / (fb - fa);
    if (!r->mover.probe(r->mover.self, root, r->rates))
      break;
    normalise(r->m, r->rates, r->scratch);
    double f = r->scratch[c];
    if (fabs(f) < 1e-14)
      break;
    if (f * fb < 0.0) {
      a = b;
      fa = fb;
    } else {
      fa *= 0.5;
    }
    b = root;
    fb = f;
  }
  return root;
}

/* Looks for toggles since the last row, and comes back to this one. */
km_status km_sweeper_toggles(km_sweeper *r, double s, km_error *error) {
  if (!direction(r, r->z)) {
    r->have_last = false;
    return KM_OK;
  }
  bool moved = false, failed = false;
  for (int c = 0; c < r->m->coordinate_count; ++c) {
    if (r->m->substructure_of[c] != r->substructure || r->m->held[c])
      continue;
    bool here = fabs(r->z[c]) < zero, before = r->have_last && fabs(r->last_z[c]) < zero;
    bool between = r->have_last && !here && !before && r->z[c] * r->last_z[c] < 0.0;
    if (here && !before)
      failed = !km_sweeper_add_toggle(r->out, c, s) || failed;
    if (between)
      failed = !km_sweeper_add_toggle(r->out, c, locate(r, c, s)) || failed;
    moved = moved || between;
  }
  if (moved)
    r->mover.settle(r->mover.self, s);
  double *swap = r->last_z;
  r->last_z = r->z;
  r->z = swap;
  r->last_s = s;
  r->have_last = true;
  return failed ? km_fail(error, KM_MEMORY, "out of memory for the toggles") : KM_OK;
}
