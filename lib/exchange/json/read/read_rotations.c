/* Orientations: a matrix, a quaternion, Euler angles or a rotation vector, and what rounding leaves of them.
 *
 *   R        the rotation nearest to the matrix (validation.h)
 *   q / |q|  of a quaternion, where ||q| - 1| <= KM_ROTATION_ROUNDING
 *   R_1(a) R_2(b) R_3(c)  of Euler angles: each turn about an axis of the frame that the turns before it gave */
#include "exchange/json/read/reader.h"

#include <string.h>

/* Rounding error of a matrix written with all digits of a double; a larger change is reported. */
static const double unrounded = 1e-12;

void km_reader_needs(km_reader *reader, const char *version) {
  if (strcmp(reader->origin->version, version) < 0)
    reader->origin->version = version;
}

static void store_rounding(km_reader *reader, double change, double misfit, const km_place *at) {
  reader->rotation_misfit = fmax(reader->rotation_misfit, misfit);
  if (change <= unrounded)
    return;
  if (reader->rounded_count++ == 0)
    km_place_text(at, reader->rounded_first);
  reader->rounded_most = fmax(reader->rounded_most, change);
}

void km_reader_report_rotations(km_reader *reader) {
  if (reader->rounded_count > 0)
    km_messages_add(reader->messages, KM_NOTE,
                    "rotations that are rounded: %d, the first is %s; each is replaced by the nearest one, which "
                    "changes its entries by at most %.2g",
                    reader->rounded_count, reader->rounded_first, reader->rounded_most);
}

km_rotation km_reader_rotation(km_reader *reader, const km_value *frame, const char *key, const km_place *place) {
  const km_value *rows = km_value_get(frame, key);
  if (!rows)
    return km_rotation_identity();
  double m[9]; /* matrix by rows */
  int n = 0;
  for (const km_value *row = rows->first; row; row = row->next)
    for (const km_value *entry = row->first; entry; entry = entry->next)
      m[n++] = entry->number;
  km_rotation R, given = {{{m[0], m[3], m[6]}, {m[1], m[4], m[7]}, {m[2], m[5], m[8]}}};
  double misfit;
  km_error error;
  km_place at = {place, key, 0};
  if (km_model_rotation(m, &R, &misfit, &error))
    km_reader_error(reader, &at, "%s", error.text);
  else
    store_rounding(reader, km_rotation_distance(&R, &given), misfit, &at);
  return R;
}

static km_rotation read_quaternion(km_reader *reader, const km_value *list, const km_place *at) {
  double q[4] = {0};
  int n = 0;
  for (const km_value *v = list->first; v && n < 4; v = v->next)
    q[n++] = v->number;
  double length = sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]), off = fabs(length - 1.0);
  if (list->count != 4) {
    km_reader_error(reader, at, "found a list of %zu; expected [w, x, y, z]", list->count);
    return km_rotation_identity();
  }
  if (!(off <= KM_ROTATION_ROUNDING)) {
    km_reader_error(reader, at, "found a quaternion of the length %s; expected 1, within %g", KM_SHOWN(length),
                    KM_ROTATION_ROUNDING);
    return km_rotation_identity();
  }
  store_rounding(reader, off, 2.0 * off, at);
  return km_quaternion_rotation(km_quaternion_normalised((km_quaternion){q[0], q[1], q[2], q[3]}));
}

static km_rotation read_euler(km_reader *reader, const km_value *euler, const km_place *place) {
  const char *order = km_reader_string(euler, "order");
  km_place at = {place, "order", 0};
  const km_value *angle = km_value_get(euler, "angles")->first;
  km_rotation R = km_rotation_identity();
  if (strlen(order) != 3 || strspn(order, "xyz") != 3 || order[0] == order[1] || order[1] == order[2]) {
    km_reader_error(reader, &at, "found \"%.40s\"; expected three of x, y, z, no two alike side by side", order);
    return R;
  }
  for (int k = 0; k < 3; ++k, angle = angle->next) {
    double turn = angle->number * reader->model->units.angle->si;
    R = km_rotation_about_axis(&R, order[k] - 'x', cos(turn), sin(turn));
  }
  return R;
}

static const char *const ways[] = {"R", "quaternion", "euler", "rotation_vector"};

bool km_is_orientation(const char *key) {
  for (size_t i = 0; i < sizeof ways / sizeof *ways; ++i)
    if (strcmp(key, ways[i]) == 0)
      return true;
  return false;
}

km_rotation km_reader_orientation(km_reader *reader, const km_value *object, const km_place *place) {
  const char *first = NULL;
  for (size_t i = 0; i < sizeof ways / sizeof *ways; ++i) {
    if (!km_value_get(object, ways[i]))
      continue;
    if (first)
      km_reader_error(reader, place, "found both \"%s\" and \"%s\"; expected one of them", first, ways[i]);
    else
      first = ways[i];
  }
  if (!first || strcmp(first, "R") == 0)
    return km_reader_rotation(reader, object, "R", place);
  const km_value *value = km_value_get(object, first);
  km_place at = {place, first, 0};
  km_reader_needs(reader, "1.2");
  if (strcmp(first, "quaternion") == 0)
    return read_quaternion(reader, value, &at);
  if (strcmp(first, "euler") == 0)
    return read_euler(reader, value, &at);
  km_vec3 turn = km_vec3_scale(reader->model->units.angle->si, km_reader_vector(object, first));
  return km_quaternion_rotation(km_quaternion_exp(turn));
}
