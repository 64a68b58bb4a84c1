/* Records the numbers that place frames (model/written_numbers.h). A number that a formula gives is exact.
 *
 *   R, entry (r, c)       turn = ½ a_c × e_r           a_c: column c of R; nearest rotation of R + dp e_r e_cᵀ
 *   quaternion, entry k   turn = 2 vec(dq q⁻¹)         dq = (e_k − q q_k) / |q|, q normalised
 *   Euler angle k         turn = R_1 … R_{k−1} e_k
 *   rotation vector       turn = difference of the rotations for a small change
 *   axis, entry k         turn = u × e_k / |axis|      u: unit vector along the axis */
#include "exchange/json/read/reader.h"
#include "model/written_numbers.h"

#include <string.h>

static km_vec3 unit_vector(int k) {
  return (km_vec3){k == 0, k == 1, k == 2};
}

static void record(km_reader *reader, const km_written_number *number, const km_value *value) {
  km_written_number written = *number;
  written.value = value->number;
  if (!value->string)
    km_model_add_written(reader->model, &written);
}

/* A list [x, y, z] whose numbers move the frame. */
static void record_point(km_reader *reader, const km_value *list, km_written_number number) {
  int k = 0;
  for (const km_value *v = list ? list->first : NULL; v && k < 3; v = v->next, ++k) {
    number.index = k;
    number.move = unit_vector(k);
    record(reader, &number, v);
  }
}

static void record_matrix(km_reader *reader, const km_value *rows, const km_rotation *R, km_written_number number) {
  int r = 0;
  for (const km_value *row = rows->first; row && r < 3; row = row->next, ++r) {
    int c = 0;
    for (const km_value *entry = row->first; entry && c < 3; entry = entry->next, ++c) {
      number.index = 3 * r + c;
      number.turn = km_vec3_scale(0.5, km_vec3_cross(R->axis[c], unit_vector(r)));
      record(reader, &number, entry);
    }
  }
}

static void record_quaternion(km_reader *reader, const km_value *list, km_written_number number) {
  double q[4] = {0}, length = 0.0;
  int k = 0;
  for (const km_value *v = list->first; v && k < 4; v = v->next, ++k) {
    q[k] = v->number;
    length += q[k] * q[k];
  }
  length = sqrt(length);
  if (!(length > 0.0))
    return;
  k = 0;
  for (const km_value *v = list->first; v && k < 4; v = v->next, ++k) {
    double d[4];
    for (int i = 0; i < 4; ++i)
      d[i] = ((i == k) - q[i] * q[k] / (length * length)) / length;
    /* vec(d q*) = −d_0 v + q_0 d_v − d_v × v, with q = (q_0, v) of length 1 */
    km_vec3 v0 = {q[1] / length, q[2] / length, q[3] / length}, dv = {d[1], d[2], d[3]};
    km_vec3 turn = km_vec3_sub(km_vec3_scale(q[0] / length, dv), km_vec3_scale(d[0], v0));
    number.index = k;
    number.turn = km_vec3_scale(2.0, km_vec3_sub(turn, km_vec3_cross(dv, v0)));
    record(reader, &number, v);
  }
}

static void record_euler(km_reader *reader, const km_value *euler, km_written_number number) {
  const char *order = km_reader_string(euler, "order");
  double unit = reader->model->units.angle->si;
  km_rotation R = km_rotation_identity();
  const km_value *angle = km_value_get(euler, "angles")->first;
  for (int k = 0; k < 3 && order[k] >= 'x' && order[k] <= 'z' && angle; ++k, angle = angle->next) {
    number.index = k;
    number.turn = km_vec3_scale(unit, R.axis[order[k] - 'x']);
    record(reader, &number, angle);
    R = km_rotation_about_axis(&R, order[k] - 'x', cos(angle->number * unit), sin(angle->number * unit));
  }
}

static void record_rotation_vector(km_reader *reader, const km_value *list, km_written_number number) {
  static const double change = 1e-6; /* radians */
  double unit = reader->model->units.angle->si, v[3] = {0};
  int k = 0;
  for (const km_value *at = list->first; at && k < 3; at = at->next, ++k)
    v[k] = unit * at->number;
  k = 0;
  for (const km_value *at = list->first; at && k < 3; at = at->next, ++k) {
    km_vec3 step = km_vec3_scale(change, unit_vector(k)), whole = {v[0], v[1], v[2]};
    km_rotation plus = km_quaternion_rotation(km_quaternion_exp(km_vec3_add(whole, step)));
    km_rotation minus = km_quaternion_rotation(km_quaternion_exp(km_vec3_sub(whole, step)));
    km_rotation back = km_rotation_inverse(&minus), turn = km_rotation_product(&plus, &back);
    number.index = k;
    number.turn = km_vec3_scale(0.5 * unit / change, km_quaternion_log(km_rotation_quaternion(&turn)));
    record(reader, &number, at);
  }
}

void km_reader_record_pose(km_reader *reader, const km_value *object, int frame) {
  km_written_number number = {.frame = {frame, -1}, .key = "T"};
  const km_rotation *R = &reader->model->frames[frame].pose.R;
  const km_value *value;
  record_point(reader, km_value_get(object, "T"), number);
  if ((value = km_value_get(object, number.key = "R")) != NULL)
    record_matrix(reader, value, R, number);
  else if ((value = km_value_get(object, number.key = "quaternion")) != NULL)
    record_quaternion(reader, value, number);
  else if ((value = km_value_get(object, number.key = "euler")) != NULL)
    record_euler(reader, value, number);
  else if ((value = km_value_get(object, number.key = "rotation_vector")) != NULL)
    record_rotation_vector(reader, value, number);
}

void km_reader_record_drawn(km_reader *reader, const km_value *joint, const int frame[2]) {
  km_written_number number = {.frame = {frame[0], frame[1]}, .key = "at"};
  const km_value *axis = km_value_get(joint, "axis");
  record_point(reader, km_value_get(joint, "at"), number);
  if (!axis)
    return;
  km_vec3 a = km_reader_vector(joint, "axis");
  double length = km_vec3_norm(a);
  int k = 0;
  number.key = "axis";
  for (const km_value *v = axis->first; v && k < 3 && length > 0.0; v = v->next, ++k) {
    number.index = k;
    number.turn = km_vec3_scale(1.0 / (length * length), km_vec3_cross(a, unit_vector(k)));
    record(reader, &number, v);
  }
}
