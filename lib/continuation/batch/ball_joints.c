/* Rotation vectors and displacements of ball joints at the end of a batch's step. */
#include "continuation/batch/batch_arrays.h"

void km_batch_finish_ball_joints(km_batch *l, unsigned ended) {
  const km_mechanism *m = l->m;
  for (int b = 0; b < m->ball_count; ++b) {
    const int c = m->ball_coordinate[b], k = m->column_of[c];
    if (k < 0 || m->substructure_of[c] != l->drives[0]->c.substructure)
      continue;
    const km_batch_number *start = l->from + k;
    km_batch_number *q = l->q + c, *move = l->move + k;
    for (unsigned left = ended; left; left &= left - 1) {
      const int i = __builtin_ctz(left);
      km_quaternion now = km_lane_ball(&l->ball[b], i), from = km_lane_ball(&l->from_ball[b], i);
      km_vec3 rotation = km_quaternion_log(km_quaternion_product(now, km_quaternion_conjugate(from)));
      km_vec3 vector = km_quaternion_log_near(now, (km_vec3){start[0].of[i], start[1].of[i], start[2].of[i]});
      for (int a = 0; a < 3; ++a) {
        move[a].of[i] = (const double[]){rotation.x, rotation.y, rotation.z}[a];
        q[a].of[i] = (const double[]){vector.x, vector.y, vector.z}[a];
      }
    }
  }
}
