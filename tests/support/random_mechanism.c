/* Random mechanisms: any topology, any joint types, any senses, perhaps gears, closed by construction. */
#include "support/random_mechanism.h"

#include "topology/chain.h"

#include <stdio.h>

enum { MOST_BODIES = 8, MOST_JOINTS = 16 };

static km_pose random_pose(randomness *r) {
  km_vec3 v = {uniform(r, -1.5, 1.5), uniform(r, -1.5, 1.5), uniform(r, -1.5, 1.5)};
  return (km_pose){km_quaternion_rotation(km_quaternion_exp(v)),
                   {uniform(r, -1, 1), uniform(r, -1, 1), uniform(r, -1, 1)}};
}

/* The text of a mechanism in the making. */
typedef struct maker {
  randomness *r;
  km_text frames[MOST_BODIES], joints;
  km_pose body[MOST_BODIES]; /* pose in the inertial frame */
  int bodies, joint_count;
  int scalar[MOST_JOINTS], scalars; /* joints of one coordinate */
} maker;

static const double pitch = 0.3;

static void add_frame(maker *m, int body, const char *end, const km_pose *X) {
  const km_vec3 *a = X->R.axis;
  km_text *out = &m->frames[body];
  km_text_format(
      out,
      "%s{\"name\": \"%s%d\", \"T\": [%.17g, %.17g, %.17g], \"R\": [[%.17g, %.17g, %.17g], [%.17g, %.17g, %.17g], "
      "[%.17g, %.17g, %.17g]]}",
      out->size ? ", " : "", end, m->joint_count, X->p.x, X->p.y, X->p.z, a[0].x, a[1].x, a[2].x, a[0].y, a[1].y,
      a[2].y, a[0].z, a[1].z, a[2].z);
}

static const char *body_name(int body, char out[8]) {
  snprintf(out, 8, body ? "b%d" : "fixed", body);
  return out;
}

/* Writes a joint of a random type; returns the displacement from its parent frame to its child frame. */
static km_pose add_joint(maker *m, int parent, int child, km_joint_type type) {
  const km_joint_kind *kind = km_joint_kind_of(type);
  double q[KM_MAX_FREEDOM];
  char p[8], c[8];
  km_pose X = km_pose_identity();
  if (kind->freedom == 1)
    m->scalar[m->scalars++] = m->joint_count;
  for (int k = 0; k < kind->freedom; ++k)
    q[k] = uniform(m->r, -1.2, 1.2);
  for (int i = 0, k = 0; i < kind->motion_count; k += km_primitive_freedom(kind->motions[i++].primitive)) {
    km_pose motion = km_motion_pose(kind->motions[i], pitch / (2.0 * M_PI), &q[k]);
    X = km_pose_product(&X, &motion);
  }
  km_text_format(&m->joints,
                 "%s{\"name\": \"j%d\", \"type\": \"%s\", \"body_frame_pairs\": [[\"%s\", \"p%d\"], [\"%s\", \"c%d\"]]",
                 m->joint_count ? ", " : "", m->joint_count, kind->word, body_name(parent, p), m->joint_count,
                 body_name(child, c), m->joint_count);
  if (type == KM_SCREW)
    km_text_format(&m->joints, ", \"pitch\": %.17g", pitch);
  for (int k = 0; k < kind->freedom; ++k)
    km_text_format(&m->joints, "%s%.17g", k ? ", " : ", \"initial_displacement\": [", q[k]);
  km_text_add(&m->joints, kind->freedom ? "]}" : "}");
  return X;
}

static km_joint_type random_type(maker *m, bool chord) {
  for (;;) {
    km_joint_type type = (km_joint_type)below(m->r, KM_JOINT_TYPES);
    if (type != KM_FLOAT || (chord && below(m->r, 3) == 0))
      return type;
  }
}

/* A new body on a joint to an earlier one, either way round. */
static void grow(maker *m) {
  int old = below(m->r, m->bodies), new = m->bodies++;
  bool against = below(m->r, 2);
  km_pose here = random_pose(m->r), there = random_pose(m->r), back = km_pose_inverse(&there);
  km_pose X = add_joint(m, against ? new : old, against ? old : new, random_type(m, false));
  if (against)
    X = km_pose_inverse(&X);
  add_frame(m, old, against ? "c" : "p", &here);
  add_frame(m, new, against ? "p" : "c", &there);
  m->joint_count++;
  km_pose frame = km_pose_product(&m->body[old], &here), moved = km_pose_product(&frame, &X);
  m->body[new] = km_pose_product(&moved, &back);
}

/* A joint between two bodies that are there, its child frame where the loop closes. */
static void close(maker *m) {
  int a = below(m->r, m->bodies), b = below(m->r, m->bodies - 1);
  b += b >= a;
  km_pose here = random_pose(m->r);
  km_pose X = add_joint(m, a, b, random_type(m, true));
  km_pose frame = km_pose_product(&m->body[a], &here), moved = km_pose_product(&frame, &X);
  km_pose back = km_pose_inverse(&m->body[b]), there = km_pose_product(&back, &moved);
  add_frame(m, a, "p", &here);
  add_frame(m, b, "c", &there);
  m->joint_count++;
}

/* A gear between two joints, now and then. */
static void couple(maker *m, km_text *out) {
  if (m->scalars < 2 || below(m->r, 2))
    return;
  int a = below(m->r, m->scalars), b = below(m->r, m->scalars - 1);
  b += b >= a;
  km_text_format(out,
                 ", \"couplings\": [{\"name\": \"gear\", \"joints\": [\"j%d\", \"j%d\"], \"ratios\": [%.17g, %.17g]}]",
                 m->scalar[a], m->scalar[b], uniform(m->r, 0.3, 2.0), uniform(m->r, -2.0, -0.3));
}

char *random_mechanism(randomness *r, bool gears) {
  maker m = {.r = r, .bodies = 1};
  km_text out = {0};
  int bodies = 3 + below(r, MOST_BODIES - 2), chords = 1 + below(r, 3);
  m.body[0] = km_pose_identity();
  while (m.bodies < bodies)
    grow(&m);
  for (int i = 0; i < chords; ++i)
    close(&m);
  km_text_format(&out, "{\"fixed\": {\"frames\": [%s]}, \"assemblies\": [{\"name\": \"a\", \"bodies\": [",
                 m.frames[0].data ? m.frames[0].data : "");
  for (int b = 1; b < m.bodies; ++b)
    km_text_format(&out, "%s{\"name\": \"b%d\", \"frames\": [%s]}", b > 1 ? ", " : "", b,
                   m.frames[b].data ? m.frames[b].data : "");
  km_text_format(&out, "], \"joints\": [%s]", m.joints.data);
  if (gears)
    couple(&m, &out);
  km_text_add(&out, "}]}");
  for (int b = 0; b < m.bodies; ++b)
    km_text_free(&m.frames[b]);
  km_text_free(&m.joints);
  return out.data;
}

fixture open_random_mechanism(randomness *r, bool gears) {
  char *text = random_mechanism(r, gears);
  fixture f = fixture_read(text);
  km_free(text);
  if (f.mechanism->coordinate_count)
    go_somewhere(&f, r);
  return f;
}
