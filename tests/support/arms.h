/* Arms and path studies for tests. */
#ifndef KM_TESTS_ARMS_H
#define KM_TESTS_ARMS_H

#include "support/support.h"

#include "arm/study.h"
#include "arm/track.h"

/* An arm of a model in models/, of a text, or with prismatic, helical and reversed joints (8 coordinates). */
km_arm *arm_of(const fixture *f, const char *body, const char *frame, km_task task);
fixture odd_arm(void);

/* Random joint values within the limits and ±2. */
void random_pose(const km_arm *arm, randomness *r, double *q);

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

#endif
