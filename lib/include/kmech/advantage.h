/* Mechanical advantage: how fast an input moves for its output. */
#ifndef KMECH_ADVANTAGE_H
#define KMECH_ADVANTAGE_H

#include "kmech/mobility.h"

#include <stdbool.h>

#ifdef __cplusplus
extern "C" {
#endif

/* An end of a mechanism that is pushed, or pushes: a joint, or a point of a body along a direction. */
typedef enum km_handle_kind {
  KM_HANDLE_NONE,  /* no end */
  KM_HANDLE_JOINT, /* a joint's coordinate */
  KM_HANDLE_POINT  /* a point of a body along a direction */
} km_handle_kind;

/* One such end. Start from {0}. */
typedef struct km_handle {
  km_handle_kind kind; /* which members count */
  int coordinate;      /* of a joint */
  int frame;           /* the point: a frame's origin */
  double direction[3]; /* unit vector along the inertial axes */
  const char *name;    /* as columns call it: a joint's label, or body/frame:dx,dy,dz; borrowed */
} km_handle;

/* What kind of number an advantage is. */
typedef enum km_advantage_state {
  KM_ADVANTAGE_FINITE,   /* both move */
  KM_ADVANTAGE_ZERO,     /* the input stands while the output moves */
  KM_ADVANTAGE_INFINITE, /* the output stands while the input moves */
  KM_ADVANTAGE_UNDEFINED /* both stand, or nothing moves */
} km_advantage_state;

/* Which motion an advantage is about. */
typedef enum km_advantage_method {
  KM_ADVANTAGE_SINGLE_FREEDOM, /* the one motion there is: Z_i / Z_k (287) */
  KM_ADVANTAGE_LEAST_MOTION    /* of several freedoms, the motion of least length that moves the input: Z Zᵀ */
} km_advantage_method;

/* The advantage at one pose. */
typedef struct km_advantage {
  km_advantage_state state;   /* says what `value` can be */
  km_advantage_method method; /* of which motion it is */
  double value;               /* q̇_in / q̇_out, angles in radians, the model's length; infinity or NaN by state */
  double velocity_ratio;      /* q̇_out / q̇_in */
  double input_rate, output_rate; /* in that motion, whose largest scaled rate is 1; 0 where they count as 0 */
} km_advantage;

/* An end of the model's own analysis.mechanical_advantage, its `output` or its input: false where it has none. */
KM_API bool km_handle_default(const km_model *model, bool output, km_handle *out);

/* An input and an output, with the workspace of one thread. */
typedef struct km_lever km_lever;

/* Prepares for a driving `input` and a driven `output`. KM_USAGE: an end that is held or can't move, both the same, or
 * of parts that don't move each other. The caller frees `*out`. */
KM_API km_status km_lever_create(const km_mechanism *mechanism, const km_handle *input, const km_handle *output,
                                 km_lever **out, km_error *error);
KM_API void km_lever_free(km_lever *lever);

/* At the state's pose, whose mobility is up to date. One freedom: MA = q̇_i / q̇_k = (D_k/D_i) Z_i / Z_k; more: MA =
 * (D_k/D_i) m_i / (Z_k Z_iᵀ), the substructures that the input lies in moving, the others standing (theory 5; of
 * points: rows of the point's Jacobian). Rates below 3e-8 of the largest, each over its substructure's size, count as
 * 0. KM_USAGE: a pointer is missing, or the mobility isn't known; KM_MEMORY: the mobility is to be found again. `*out`
 * is undefined then. O(coordinates · freedoms). */
KM_API km_status km_lever_update(const km_mechanism *mechanism, km_state *state, km_lever *lever, km_advantage *out);
/* Where several motions meet at the state's configuration (a branch point), the advantages in each of them. Returns
 * their number, at most `most`; 0 at a regular configuration, -1 when out of memory. The state keeps its
 * configuration. */
KM_API int km_lever_branches(const km_mechanism *mechanism, km_state *state, km_lever *lever, km_advantage *out,
                             int most);
/* The motion that the last update was about: rates[coordinate], radians and model's length, largest scaled one 1.
 * Borrowed. */
KM_API const double *km_lever_rates(const km_lever *lever);

/* "rad/mm" of input over output; "" where both are of one kind. Borrowed. */
KM_API const char *km_advantage_unit(const km_model *model, const km_handle *input, const km_handle *output);
/* "finite", "zero", "infinite", "undefined"; "single freedom", "least motion". */
KM_API const char *km_advantage_state_name(km_advantage_state state);
KM_API const char *km_advantage_method_name(km_advantage_method method);

#ifdef __cplusplus
}
#endif
#endif
