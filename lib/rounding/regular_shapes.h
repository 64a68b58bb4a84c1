/* Relations that the numbers of a substructure have within rounding, and that a designer means exactly (docs/theory.md
 * 14.7).
 *
 *   parallel   u_f × u_g = 0        axes of two joints on one body
 *   right      u_f · u_g = 0
 *   equal      a_fg − a_hi = 0      a: distance of two joints on one body: of their axes, or of points of ball joints
 *
 * A relation is listed if its residual is below what half a last digit of all numbers of its frames can make. */
#ifndef KM_ROUNDING_REGULAR_SHAPES_H
#define KM_ROUNDING_REGULAR_SHAPES_H

#include "model/written_numbers.h"
#include "topology/mechanism.h"

typedef enum km_relation_kind { KM_PARALLEL_AXES, KM_RIGHT_ANGLE, KM_EQUAL_LENGTHS } km_relation_kind;

/* A joint's frame on a body; axis: 0 1 2, −1: a point alone. */
typedef struct km_joint_end {
  int frame, axis;
} km_joint_end;

typedef struct km_relation {
  km_relation_kind kind;
  km_joint_end end[4]; /* two of axes, four of lengths */
} km_relation;

typedef struct km_relations {
  int count;
  km_relation *relation; /* [count] */
  double size;           /* lengths are relative to it */
} km_relations;

enum { KM_MAX_RELATIONS = 400 }; /* further ones are left out */

/* Lists the relations of a substructure, of whose numbers number[count] may change by half[count]. False without
 * memory. */
bool km_relations_find(const km_mechanism *mechanism, int substructure, const km_written_number *number,
                       const double *half, int count, km_arena *arena, km_relations *out);
/* True if a number places a frame of the relation. */
bool km_relation_is_placed(const km_relation *relation, const km_written_number *number);
/* Number of rows of all relations. */
int km_relations_rows(const km_relations *relations);
/* Writes residuals c[rows] of the model's present frames, and their derivatives by the numbers times half, by
 * differences, into A[rows × count], column-major with the leading dimension `stride`; A may be NULL. */
void km_relations_compute(const km_relations *relations, km_model *model, const km_written_number *number,
                          const double *half, int count, double *c, double *A, size_t stride);

#endif
