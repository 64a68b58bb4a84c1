/* Random planar linkages in any plane of space, and their balance of forces by three equations a body: what the answers
 * about forces are compared with. */
#ifndef KM_TESTS_PLANAR_H
#define KM_TESTS_PLANAR_H

#include "support/support.h"

enum { PLANAR_MOST_BODIES = 8, PLANAR_MOST_JOINTS = 12, PLANAR_MOST_SIZE = 40 };

typedef struct planar_joint {
  int parent, child; /* bodies; 0 is the ground */
  bool slides;
  double place[2], along[2]; /* assembled configuration; `along`: direction of a prismatic joint */
  double coefficient, radius;
} planar_joint;

/* `freedoms` hinges from the ground to bodies 1, 2, …, then pairs of bodies with three joints, each between two bodies
 * that were there. All coordinates are 0 at the assembled pose, where every body's frame is the inertial one's. */
typedef struct planar {
  int bodies, joints, freedoms; /* number of bodies without the ground */
  planar_joint joint[PLANAR_MOST_JOINTS];
  double mass[PLANAR_MOST_BODIES], centre[PLANAR_MOST_BODIES][2]; /* pose of body 1 + i */
  km_rotation plane;                                              /* its third axis is normal to the plane */
} planar;

planar planar_random(randomness *r, int freedoms, int pairs, bool friction);
/* The model's text; the caller frees it (km_free). Joint i is coordinate i. */
char *planar_text(const planar *p);

/* A force on a body at a place of it (at the assembled pose), along fixed axes of the plane. */
typedef struct planar_load {
  int body;
  double place[2], force[2];
} planar_load;

/* Equations of balance at the state's pose: 3 · bodies rows; columns: two of the reaction in every joint, then what a
 * force of 1 in every joint's coordinate does. Column-major. `load`: weights and loads. */
typedef struct planar_balance {
  int rows;
  double A[PLANAR_MOST_SIZE * PLANAR_MOST_SIZE], load[PLANAR_MOST_SIZE];
} planar_balance;
void planar_balance_at(const planar *p, const fixture *f, const double gravity[2], const planar_load *loads, int count,
                       planar_balance *out);

/* Joint rates of the only motion, the largest 1: bodies' velocities against which no reaction does work. */
void planar_rates(const planar *p, const planar_balance *b, double *rates);

/* det of a matrix, column-major n × n, which it destroys. */
double planar_determinant(double *a, int n);

/* A vector of the plane in space. */
km_vec3 planar_in_space(const planar *p, const double v[2]);

#endif
