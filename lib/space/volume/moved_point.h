/* Closed configurations of a mechanism as a point of it is moved (docs/theory.md 4.23).
 *
 *   dq = D⁻¹ Z w,   J D⁻¹ Z = 0,   dx = L A w        Z: of each substructure, and a unit column for each joint of none
 *   towards p:  d = (p − x)/L,   w = bounded step (space/volume/bounded_step.h) with ε = μ |d|,   then the loops close
 *   μ grows where a step fails or takes less than a quarter of what it promises, and falls where it takes three
 * quarters (D. Marquardt 1963; ε proportional to |d|: N. Yamashita, M. Fukushima 2001)
 *   bounds : joint limits, angles of ball joints, the least clearance of pairs of bodies */
#ifndef KM_SPACE_MOVED_POINT_H
#define KM_SPACE_MOVED_POINT_H

#include "kmech/volume.h"
#include "space/surface/kept_clearance.h"
#include "space/volume/bounded_step.h"

/* End of an attempt to move the point. */
typedef enum km_point_end {
  KM_POINT_REACHED,
  KM_POINT_BLOCKED,  /* no motion brings it nearer */
  KM_POINT_UNSETTLED /* the iteration ended without a result */
} km_point_end;

typedef struct km_moved_point {
  const km_mechanism *m;
  km_state *s;
  int frame;
  bool keeps_limits;
  km_kept_clearance kept;
  int dimension;    /* coordinates of the point that count: 2 or 3 */
  km_vec3 axis[3];  /* their axes */
  double x[3];      /* place along the axes, model's unit */
  int part_count;   /* substructures on the way from the inertial frame to the point's body */
  int *part;        /* [part_count] */
  int *rank;        /* [part_count] rank of the Jacobian at the beginning: steps keep it */
  int columns;      /* coordinates of the parts, and of joints of none on the way */
  double travel;    /* L and the strokes of slides and screws between limits, model's unit */
  bool is_bounded;  /* all slides and screws have limits */
  double *longest;  /* [columns] longest change in a step, scaled */
  int tree_start;   /* the first of the latter */
  int *coordinate;  /* [columns] */
  int freedoms;     /* rows of Z at the last update */
  double *Z;        /* [freedoms × columns] */
  double *z;        /* [columns] D dq of a step */
  double *jacobian; /* [6 × coordinate] of the frame */
  double *move;     /* [columns] workspace */
  double *before;   /* saved configuration */
  km_bounded_step step;
  size_t saved_size; /* numbers of a saved configuration */
} km_moved_point;

/* Finds parts and columns, and allocates; m, s, frame, keeps_limits and kept's definition are given. KM_MEMORY. */
km_status km_moved_point_create(km_moved_point *p, km_arena *arena, km_error *error);
void km_moved_point_save(const km_moved_point *p, double *saved);
/* Moves the state to a saved configuration. Its next steps don't depend on those before. */
void km_moved_point_restore(km_moved_point *p, const double *saved);
/* Closes the loops anew and updates Z, A and x. False if they are open, or a bound is exceeded: then
 * km_moved_point_return may help. */
bool km_moved_point_begin(km_moved_point *p);
/* Closes the loops anew and moves back within the bounds by minimum-norm steps. False: the loops are open, or a bound
 * is still exceeded. */
bool km_moved_point_return(km_moved_point *p);
/* Rank of A, singular values below 1e-6 of the largest left out. */
int km_moved_point_rank(km_moved_point *p);
/* Moves the point to `target`[dimension] along the axes, to 1e-9 L, or as near as it gets. */
km_point_end km_moved_point_move_to(km_moved_point *p, const double *target);
/* Moves the point along ±axis as far as it gets. False: a slide or screw without limits carries it on without end. */
bool km_moved_point_find_extremum(km_moved_point *p, int axis, double sense);
/* Moves on in a random direction of the configurations, up to half a turn, or to a bound. */
void km_moved_point_move_at_random(km_moved_point *p, uint64_t *random);
/* Starts from random values of all columns: closes the loops and moves within the bounds. KM_MEMORY. */
km_status km_moved_point_assemble(km_moved_point *p, uint64_t *random, bool *is_closed);

#endif
