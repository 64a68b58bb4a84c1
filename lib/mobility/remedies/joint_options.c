/* Joint types with more freedoms than a hinge or a slide (theory 7.5).
 *
 *   motions: bits T_x T_y T_z R_x R_y R_z of the joint's parent frame;   k: the joint's axis, a = k + 1, b = k + 2
 *
 *   hinge R_k        + T_k                 cylindrical      slide T_k  + R_k                 cylindrical
 *                    + R_a or R_b          universal                   + R_a T_b or R_b T_a  planar
 *                    + R_a R_b             spherical                   + R_a or R_b          pin-in-slot
 *                    + T_a or T_b          pin-in-slot                 + R_k R_a R_b         sphere-cylinder
 *                    + R_a R_b, one T      sphere-cylinder             + R_k R_a R_b, one T  sphere-plane
 *                    + R_a R_b, two T      sphere-plane
 *   cylindrical T_k R_k + R_a R_b  sphere-cylinder */
#include "mobility/remedies/joint_options.h"

#include <string.h>

/* Motions relative to the joint's axis. */
enum { TK = 1, TA = 2, TB = 4, RK = 8, RA = 16, RB = 32 };

typedef struct option_row {
  int own, added;
  const char *to;
  bool is_type;
} option_row;

static const option_row rows[] = {
    {RK, TK, "cylindrical", true},
    {RK, RA, "universal", true},
    {RK, RB, "universal", true},
    {RK, RA | RB, "spherical", true},
    {RK, TA, "pin-in-slot", false},
    {RK, TB, "pin-in-slot", false},
    {RK, TK | RA | RB, "sphere-cylinder", false},
    {RK, TA | RA | RB, "sphere-cylinder", false},
    {RK, TB | RA | RB, "sphere-cylinder", false},
    {RK, TK | TA | RA | RB, "sphere-plane", false},
    {RK, TK | TB | RA | RB, "sphere-plane", false},
    {RK, TA | TB | RA | RB, "sphere-plane", false},
    {TK, RK, "cylindrical", true},
    {TK, RA | TB, "planar", true},
    {TK, RB | TA, "planar", true},
    {TK, RA, "pin-in-slot", false},
    {TK, RB, "pin-in-slot", false},
    {TK, RK | RA | RB, "sphere-cylinder", false},
    {TK, RK | RA | RB | TA, "sphere-plane", false},
    {TK, RK | RA | RB | TB, "sphere-plane", false},
    {TK | RK, RA | RB, "sphere-cylinder", false},
};

/* Bits of the frame's axes x, y, z from those relative to axis k. */
static int motions_of_frame(int relative, int k) {
  int motions = 0;
  for (int i = 0; i < 3; ++i) {
    int axis = (k + i) % 3;
    motions |= (relative >> i & 1) << axis | (relative >> (3 + i) & 1) << (3 + axis);
  }
  return motions;
}

/* Own motions relative to the axis k; 0 if the joint is none of the three kinds. */
static int own_motions(const km_joint_kind *kind, int *k) {
  *k = kind->motion_count > 0 ? kind->motions[0].axis : 0;
  if (kind->motion_count == 1 && kind->motions[0].primitive == KM_REVOLUTE)
    return RK;
  if (kind->motion_count == 1 && kind->motions[0].primitive == KM_PRISMATIC)
    return TK;
  bool is_cylindrical = kind->motion_count == 2 && kind->motions[0].primitive == KM_PRISMATIC &&
                        kind->motions[1].primitive == KM_REVOLUTE && kind->motions[1].axis == *k;
  return is_cylindrical ? TK | RK : 0;
}

int km_joint_options(const km_model_joint *joint, km_joint_option out[KM_MAX_JOINT_OPTIONS]) {
  int k, own = own_motions(km_joint_kind_of(joint->type), &k), count = 0;
  for (size_t i = 0; i < sizeof rows / sizeof *rows; ++i)
    if (rows[i].own == own)
      out[count++] =
          (km_joint_option){rows[i].to, rows[i].is_type, motions_of_frame(own, k), motions_of_frame(rows[i].added, k)};
  return count;
}

bool km_joint_option_find(const km_model_joint *joint, const km_joint_change *change, km_joint_option *out) {
  km_joint_option options[KM_MAX_JOINT_OPTIONS];
  int count = km_joint_options(joint, options);
  for (int i = 0; i < count; ++i)
    if (options[i].added == change->motions && change->to && strcmp(options[i].to, change->to) == 0) {
      *out = options[i];
      return true;
    }
  return false;
}

int km_motion_count(int motions) {
  int count = 0;
  for (int bit = 0; bit < KM_JOINT_MOTIONS; ++bit)
    count += motions >> bit & 1;
  return count;
}
