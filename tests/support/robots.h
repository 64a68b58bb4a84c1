/* Robot descriptions as fixtures, and where their bodies stand. */
#ifndef KM_TESTS_ROBOTS_H
#define KM_TESTS_ROBOTS_H

#include "kmech/mechanism.h"
#include "support/support.h"

km_model *read_as(const char *text, bool floating, km_messages *messages);
fixture open_text(const char *text);
int coordinate_of(const km_model *model, const char *label);
int body_of(const km_model *model, const char *name);
void go_to(fixture *f, const char *label, double value);
km_frame_pose pose_of(const fixture *f, const char *body);
/* Position, and rotation about z. A few operations on numbers of size 1: 1e-14. */
void assert_planar(const fixture *f, const char *body, double x, double y, double angle);
/* Data of the assembled configuration. */
int mobility_of(fixture *f);

#endif
