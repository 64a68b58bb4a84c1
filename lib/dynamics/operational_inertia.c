/* Inverse operational-space inertia of a frame under the loop constraints (O. Khatib 1987).
 *
 *   Λ⁻¹ = J N (Nᵀ M N)⁻¹ (J N)ᵀ = Yᵀ Y,   Nᵀ M N = L Lᵀ,   Y = L⁻¹ (J N)ᵀ      N basis of the free motions */
#include "base/arguments.h"
#include "base/memory.h"
#include "kinematics/body_poses.h"
#include "kmech/mechanism.h"
#include "kmech/mobility.h"

#include <math.h>

/* Work data: n coordinates, r free motions. */
typedef struct inertia_work {
  const km_mechanism *m;
  const km_state *s;
  km_arena arena;
  int r;
  double *N;      /* [n × r] */
  double *twists; /* [6 × r] twists of one body's origin, by motion */
  double *M;      /* [r × r] Nᵀ M N, then its Cholesky factor in the lower triangle */
  double *T;      /* [6 × r] J N of the frame, then Y = L⁻¹ (J N)ᵀ by rows */
} inertia_work;

static int origin_of(const km_model *model, int body) {
  int frame = 0;
  while (model->frames[frame].body != body)
    frame++;
  return frame;
}

static km_status fill_twists(const inertia_work *w, int frame, double *out, km_error *error) {
  km_status status = KM_OK;
  for (int f = 0; f < w->r && !status; ++f)
    status = km_frame_twist(w->m, w->s, frame, w->N + (size_t)f * (size_t)w->m->coordinate_count, out + 6 * f, error);
  return status;
}

static km_vec3 inertia_times(const km_model_body *body, const km_rotation *R, km_vec3 w) {
  const double *I = body->inertia;
  km_vec3 a = km_rotate_back(R, w);
  return km_rotate(R, (km_vec3){I[0] * a.x + I[3] * a.y + I[5] * a.z, I[3] * a.x + I[1] * a.y + I[4] * a.z,
                                I[5] * a.x + I[4] * a.y + I[2] * a.z});
}

/* Adds a body to Nᵀ M N: m v_f · v_g + ω_f · I ω_g, v of the centre of mass. */
static void add_body(inertia_work *w, int b) {
  const km_model_body *body = &w->m->model->bodies[b];
  const km_pose *X = &w->s->pose[b];
  km_vec3 c = km_rotate(&X->R, body->center_of_mass);
  for (int f = 0; f < w->r; ++f) {
    km_vec3 wf = km_vec3_from_array(w->twists + 6 * f + 3);
    km_vec3 vf = km_vec3_add(km_vec3_from_array(w->twists + 6 * f), km_vec3_cross(wf, c));
    km_vec3 Iw = inertia_times(body, &X->R, wf);
    for (int g = 0; g <= f; ++g) {
      km_vec3 wg = km_vec3_from_array(w->twists + 6 * g + 3);
      km_vec3 vg = km_vec3_add(km_vec3_from_array(w->twists + 6 * g), km_vec3_cross(wg, c));
      w->M[f * w->r + g] += body->mass * km_vec3_dot(vf, vg) + km_vec3_dot(Iw, wg);
    }
  }
}

static void add_rotors(inertia_work *w) {
  int n = w->m->coordinate_count;
  for (int f = 0; f < w->r; ++f)
    for (int g = 0; g <= f; ++g)
      for (int c = 0; c < n; ++c)
        w->M[f * w->r + g] += w->m->armature[c] * w->N[f * n + c] * w->N[g * n + c];
}

/* Cholesky factorisation M = L Lᵀ; false if a motion moves no mass. The threshold is relative to the diagonal entry,
 * so it is independent of units. */
static bool factor_cholesky(inertia_work *w) {
  int r = w->r;
  for (int j = 0; j < r; ++j) {
    double diagonal = w->M[j * r + j];
    for (int i = j; i < r; ++i) {
      double sum = w->M[i * r + j];
      for (int k = 0; k < j; ++k)
        sum -= w->M[i * r + k] * w->M[j * r + k];
      if (i == j && !(sum > 1e-12 * diagonal))
        return false;
      w->M[i * r + j] = i == j ? sqrt(sum) : sum / w->M[j * r + j];
    }
  }
  return true;
}

/* Computes Λ⁻¹ = Yᵀ Y with Y = L⁻¹ (J N)ᵀ. */
static void compute_inverse(inertia_work *w, double out[36]) {
  int r = w->r;
  for (int row = 0; row < 6; ++row)
    for (int i = 0; i < r; ++i) {
      double sum = w->T[6 * i + row];
      for (int k = 0; k < i; ++k)
        sum -= w->M[i * r + k] * w->T[6 * k + row];
      w->T[6 * i + row] = sum / w->M[i * r + i];
    }
  for (int a = 0; a < 6; ++a)
    for (int b = 0; b < 6; ++b) {
      out[6 * a + b] = 0.0;
      for (int i = 0; i < r; ++i)
        out[6 * a + b] += w->T[6 * i + a] * w->T[6 * i + b];
    }
}

/* Sums Nᵀ M N over the bodies and rotors, factors it, and forms Λ⁻¹ of the frame. */
static km_status compute(inertia_work *w, int frame, double out[36], km_error *error) {
  const km_model *model = w->m->model;
  size_t n = (size_t)w->m->coordinate_count;
  w->N = KM_ARENA_NEW(&w->arena, double, n *n);
  w->twists = KM_ARENA_NEW(&w->arena, double, 6 * n);
  w->T = KM_ARENA_NEW(&w->arena, double, 6 * n);
  w->M = KM_ARENA_NEW(&w->arena, double, n *n);
  if (w->arena.failed)
    return km_fail(error, KM_MEMORY, "out of memory for inertias");
  km_status status = km_motions_basis(w->m, w->s, w->N, &w->r, error);
  for (int b = 1; b < model->body_count && !status; ++b) {
    status = fill_twists(w, origin_of(model, b), w->twists, error);
    add_body(w, b);
  }
  if (!status)
    status = fill_twists(w, frame, w->T, error);
  if (status)
    return status;
  add_rotors(w);
  if (!factor_cholesky(w))
    return km_fail(error, KM_MODEL, "a free motion moves no mass; expected masses, or the joint held");
  compute_inverse(w, out);
  return KM_OK;
}

km_status km_frame_inverse_inertia(const km_mechanism *m, const km_state *s, int frame, double inverse[36],
                                   km_error *error) {
  km_status status = km_check_state(m, s, error);
  if (!status)
    status = km_check_given(inverse != NULL, "place for the result", error);
  if (!status)
    status = km_check_index(frame, m->model->frame_count, "frame", error);
  if (status)
    return status;
  inertia_work w = {.m = m, .s = s};
  status = compute(&w, frame, inverse, error);
  km_arena_free(&w.arena);
  return status;
}
