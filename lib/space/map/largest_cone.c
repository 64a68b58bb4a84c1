/* The largest cone of directions in which a point on a sphere passes no curve (docs/theory.md 4.22).
 *
 *   d(n)     : least angle between the direction n and the curves' images, arcs of great circles between their points
 *   maximum  : by branch and bound over the six faces of a cube around the sphere; the central projection of a face
 *              makes no distance longer, so that |d(n) − d(n')| <= |x − x'|, x and x' on one face */
#include "space/map/map_workspace.h"

static const double accuracy = 1e-5;      /* radians */
static const double end_of_chart = 1e-12; /* 1 + a₃·n */

/* The arc of a great circle from a to b, shorter than half of it. A direction is beside it if its products with both
 * `inwards` are positive. */
typedef struct great_arc {
  km_vec3 a, b, normal, inwards[2];
} great_arc;

/* The arcs of a segment, within a cone. */
typedef struct arc_chain {
  great_arc arc[KM_SEGMENT_CHORDS];
  km_vec3 middle;
  double cosine, sine; /* cone around `middle`: its half-angle's */
  int piece;
} arc_chain;

typedef struct sphere_region {
  const km_workspace_search *w;
  const arc_chain *chains;
  int chain_count;
} sphere_region;

static km_vec3 unit(km_vec3 a) {
  return km_vec3_scale(1.0 / km_vec3_norm(a), a);
}

static km_vec3 direction_of(const km_workspace_search *w, const double chart[2]) {
  const km_point_surface *s = &w->g->f.point_surface;
  return unit(km_vec3_sub(km_point_surface_place(s, chart), km_vec3_from_array(s->origin)));
}

/* A point has an arc without normal, which no direction is beside. */
static great_arc arc_between(km_vec3 a, km_vec3 b) {
  km_vec3 normal = km_vec3_cross(a, b);
  double size = km_vec3_norm(normal);
  normal = km_vec3_scale(size > 0.0 ? 1.0 / size : 0.0, normal);
  return (great_arc){a, b, normal, {km_vec3_cross(normal, a), km_vec3_cross(b, normal)}};
}

static void fill_chain(const km_workspace_search *w, const km_outline_segment *s, arc_chain *out) {
  km_vec3 point[KM_SEGMENT_CHORDS + 1];
  for (int k = 0; k <= KM_SEGMENT_CHORDS; ++k) {
    double chart[2];
    km_segment_chord_point(s, k, chart);
    point[k] = direction_of(w, chart);
  }
  *out = (arc_chain){.piece = s->piece, .middle = point[KM_SEGMENT_CHORDS / 2], .cosine = 1.0};
  for (int k = 0; k < KM_SEGMENT_CHORDS; ++k)
    out->arc[k] = arc_between(point[k], point[k + 1]);
  for (int k = 0; k <= KM_SEGMENT_CHORDS; ++k)
    out->cosine = fmin(out->cosine, km_vec3_dot(out->middle, point[k]));
  out->sine = sqrt(fmax(1.0 - out->cosine * out->cosine, 0.0));
}

/* Cosine of the angle between a direction and an arc. */
static double cosine_to_arc(const great_arc *arc, km_vec3 n) {
  double out = km_vec3_dot(arc->normal, n);
  bool is_beside = km_vec3_dot(arc->inwards[0], n) > 0.0 && km_vec3_dot(arc->inwards[1], n) > 0.0;
  return is_beside ? sqrt(fmax(1.0 - out * out, 0.0)) : fmax(km_vec3_dot(arc->a, n), km_vec3_dot(arc->b, n));
}

/* Direction of the centre of a square on a face: axis face / 2, negative for odd faces. */
static km_vec3 direction_at(const km_square *s) {
  double at[3];
  int axis = s->face / 2;
  at[axis] = s->face % 2 ? -1.0 : 1.0;
  at[(axis + 1) % 3] = s->centre[0];
  at[(axis + 2) % 3] = s->centre[1];
  return unit(km_vec3_from_array(at));
}

static double sphere_distance(const void *context, const km_square *s) {
  const sphere_region *r = context;
  km_vec3 n = direction_at(s);
  double cosine = -1.0, sine = 0.0; /* least angle's so far */
  for (int i = 0; i < r->chain_count; ++i) {
    const arc_chain *chain = &r->chains[i];
    bool is_far = cosine > -chain->cosine && /* n is farther from `middle` than the least angle and the half-angle */
                  km_vec3_dot(n, chain->middle) < cosine * chain->cosine - sine * chain->sine;
    if (!r->w->jump[chain->piece] || is_far)
      continue;
    for (int k = 0; k < KM_SEGMENT_CHORDS; ++k)
      cosine = fmax(cosine, cosine_to_arc(&chain->arc[k], n));
    sine = sqrt(fmax(1.0 - cosine * cosine, 0.0));
  }
  return acos(fmin(cosine, 1.0));
}

static bool is_inside_sphere(const void *context, const km_square *s) {
  const sphere_region *r = context;
  const km_point_surface *surface = &r->w->g->f.point_surface;
  km_vec3 n = direction_at(s);
  double chart[2];
  if (1.0 + km_vec3_dot(n, km_vec3_from_array(surface->axis[2])) < end_of_chart)
    return r->w->net.at_end > 0;
  km_point_surface_chart(surface, km_vec3_axpy(surface->radius, n, km_vec3_from_array(surface->origin)), chart);
  return km_curve_net_count(&r->w->net, r->w->jump, chart) > 0;
}

bool km_map_find_largest_cone(km_workspace_search *w, km_aspect_workspace *out) {
  arc_chain *chains = KM_NEW(arc_chain, (size_t)w->net.segment_count + 1);
  if (!chains)
    return false;
  for (int i = 0; i < w->net.segment_count; ++i)
    fill_chain(w, &w->net.segments[i], &chains[i]);
  const sphere_region sphere = {w, chains, w->net.segment_count};
  const km_free_region region = {&sphere, sphere_distance, is_inside_sphere, accuracy};
  km_square face[6], best = {0};
  for (int k = 0; k < 6; ++k)
    face[k] = (km_square){.half = 1.0, .face = k};
  out->half_angle = km_largest_distance(&region, face, 6, &best);
  km_vec3 n = direction_at(&best);
  if (out->half_angle > 0.0)
    km_vec3_write(n, out->cone);
  km_free(chains);
  return true;
}
