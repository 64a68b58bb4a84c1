/* Arms and path studies for tests. */
#ifndef KM_TESTS_ARMS_H
#define KM_TESTS_ARMS_H

#include "support/support.h"

#include "arm/study/path_study.h"
#include "arm/tracking/track.h"

/* An arm of a model in models/, of a text, or with prismatic, helical and reversed joints (8 coordinates). */
km_arm *arm_of(const fixture *f, const char *body, const char *frame, km_task task);
fixture odd_arm(void);

/* Random joint values within the limits and ±2. */
void random_pose(const km_arm *arm, randomness *r, double *q);

/* The begin of a study's text: a circle at the panda's flange, with its own start. */
#define PANDA_CIRCLE                                                                                                   \
  "{\"effector\": [\"flange\", \"tool\"], \"path\": {\"start\": {\"T\": [0.5, 0.0, 0.45], \"R\": [[1, 0, 0], "         \
  "[0, -1, 0], [0, 0, -1]]}, \"segments\": [{\"type\": \"circle\", \"center\": [0.4, 0.0, 0.45], \"axis\": [0, 0, "    \
  "1], "                                                                                                               \
  "\"steps\": 96}]}, \"q0\": [1.188359, -0.3642308, -1.092908, -2.1855599, -0.3532835, 1.987876, 0.2719783]"

/* A study's text bound to a fixture; fails the test if anything is wrong with it. */
km_study *study_of(const fixture *f, const char *json);
km_track *track_of(const km_study *study, int method, int jobs);
double track_cell(const km_track *track, size_t row, const char *column);

/* A study of studies/ on its model. */
typedef struct opened_study {
  fixture f;
  km_study *study;
} opened_study;
opened_study study_open(const char *name);

/* The effector's pose in the inertial frame by the bodies' poses: independent of the arm. */
km_pose effector_by_bodies(const fixture *f, const km_arm *arm, const double *q);

/* Every row on the path, by the bodies' poses, and within limits; rates that move the effector along it. */
void assert_on_path(const fixture *f, const km_study *study, const km_track *track);
/* Row by row the same, to the bit. */
void assert_same_rows(const km_track *a, const km_track *b);

#endif
