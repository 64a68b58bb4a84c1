/* Rounded numbers: random overconstrained loops written with 2 to 8 digits move again, their numbers change by at most
 * half a last digit, and their loops close along the motion; a dimension that is off by 30 digits isn't called rounded;
 * trusses with short numbers stay; the derivatives of the gaps equal differences.
 *
 *   Bennett              spatial isogram: vertices A, B and their images under a half turn; axes normal to both links
 *   line-symmetric 6R    three lines and their images under a half turn about z (R. Bricard 1897)
 *   plane-symmetric 6R   two lines in a plane, two others and their mirror images (R. Bricard 1897)
 *   parallelograms       three equal parallel cranks in a plane that is turned at random */
#include "support/support.h"

#include "kmech/mobility.h"
#include "kmech/rounding.h"
#include "rounding/loop_gaps.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { MOST_LINES = 6 };

/* Hinges along lines, each between two bodies; body 0 is fixed. */
typedef struct hinges {
  int count, bodies;
  double at[MOST_LINES][3], axis[MOST_LINES][3];
  int body[MOST_LINES][2];
} hinges;

static void cross(const double a[3], const double b[3], double out[3]) {
  for (int k = 0; k < 3; ++k)
    out[k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
}

static void normalise(double v[3]) {
  double length = sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
  for (int k = 0; k < 3; ++k)
    v[k] /= length;
}

static void random_vector(randomness *r, double most, double out[3]) {
  for (int k = 0; k < 3; ++k)
    out[k] = uniform(r, -most, most);
}

static void close_ring(hinges *h) {
  h->bodies = h->count;
  for (int i = 0; i < h->count; ++i) {
    h->body[i][0] = (i + h->count - 1) % h->count;
    h->body[i][1] = i;
  }
}

static void half_turn(const double from[3], double to[3]) {
  to[0] = -from[0];
  to[1] = -from[1];
  to[2] = from[2];
}

static hinges bennett(randomness *r) {
  hinges h = {.count = 4};
  random_vector(r, 1.0, h.at[0]);
  random_vector(r, 1.0, h.at[1]);
  h.at[0][2] = 0.5 + 0.3 * h.at[0][2];
  h.at[1][2] = -h.at[0][2];
  half_turn(h.at[0], h.at[2]);
  half_turn(h.at[1], h.at[3]);
  for (int i = 0; i < 4; ++i) {
    double before[3], after[3];
    for (int k = 0; k < 3; ++k) {
      before[k] = h.at[i][k] - h.at[(i + 3) % 4][k];
      after[k] = h.at[(i + 1) % 4][k] - h.at[i][k];
    }
    cross(before, after, h.axis[i]);
    normalise(h.axis[i]);
  }
  close_ring(&h);
  return h;
}

static hinges line_symmetric(randomness *r) {
  hinges h = {.count = 6};
  for (int i = 0; i < 3; ++i) {
    random_vector(r, 1.0, h.at[i]);
    random_vector(r, 1.0, h.axis[i]);
    normalise(h.axis[i]);
    half_turn(h.at[i], h.at[i + 3]);
    half_turn(h.axis[i], h.axis[i + 3]);
  }
  close_ring(&h);
  return h;
}

static hinges plane_symmetric(randomness *r) {
  hinges h = {.count = 6};
  for (int i = 0; i < 4; ++i) {
    random_vector(r, 1.0, h.at[i]);
    random_vector(r, 1.0, h.axis[i]);
    if (i % 3 == 0) /* a hinge in the plane y = 0 */
      h.at[i][1] = h.axis[i][1] = 0.0;
    normalise(h.axis[i]);
  }
  for (int i = 1; i < 3; ++i)
    for (int k = 0; k < 3; ++k) { /* the mirror image of a hinge's line */
      h.at[6 - i][k] = k == 1 ? -h.at[i][k] : h.at[i][k];
      h.axis[6 - i][k] = k == 1 ? -h.axis[i][k] : h.axis[i][k];
    }
  close_ring(&h);
  return h;
}

static hinges parallelograms(randomness *r) {
  hinges h = {.count = 6, .bodies = 5};
  double n[3], x[3], y[3], origin[3], crank[2] = {uniform(r, 0.3, 0.6), uniform(r, 0.5, 0.9)};
  random_vector(r, 1.0, n);
  random_vector(r, 1.0, x);
  random_vector(r, 1.0, origin);
  normalise(n);
  cross(n, x, y);
  normalise(y);
  cross(y, n, x);
  for (int i = 0; i < 3; ++i) {
    double foot[2] = {0.8 * i + uniform(r, -0.1, 0.1), uniform(r, -0.1, 0.1)};
    for (int end = 0; end < 2; ++end) {
      int j = 2 * i + end;
      for (int k = 0; k < 3; ++k) {
        h.at[j][k] = origin[k] + (foot[0] + end * crank[0]) * x[k] + (foot[1] + end * crank[1]) * y[k];
        h.axis[j][k] = n[k];
      }
      h.body[j][0] = end == 0 ? 0 : i + 1;
      h.body[j][1] = end == 0 ? i + 1 : 4;
    }
  }
  return h;
}

typedef hinges (*family)(randomness *r);
static const family families[] = {bennett, line_symmetric, plane_symmetric, parallelograms};
enum { FAMILIES = sizeof families / sizeof *families };

static void append_list(char *text, size_t size, const char *key, const double v[3], int digits) {
  size_t length = strlen(text);
  snprintf(text + length, size - length, ", \"%s\": [%.*f, %.*f, %.*f]", key, digits, v[0], digits, v[1], digits, v[2]);
}

static void append(char *text, size_t size, const char *more) {
  size_t length = strlen(text);
  snprintf(text + length, size - length, "%s", more);
}

static void body_name(int body, char out[16]) {
  if (body == 0)
    snprintf(out, 16, "fixed");
  else
    snprintf(out, 16, "b%d", body);
}

/* The hinges as points and axes of a drawing. */
static void write_drawn(const hinges *h, int digits, char *text, size_t size) {
  snprintf(text, size, "{\"assemblies\": [{\"name\": \"l\", \"drawn\": \"assembled\", \"bodies\": [");
  for (int b = 1; b < h->bodies; ++b) {
    char part[40];
    snprintf(part, sizeof part, "%s{\"name\": \"b%d\"}", b > 1 ? ", " : "", b);
    append(text, size, part);
  }
  append(text, size, "], \"joints\": [");
  for (int i = 0; i < h->count; ++i) {
    char part[120], one[16], two[16];
    body_name(h->body[i][0], one);
    body_name(h->body[i][1], two);
    snprintf(part, sizeof part, "%s{\"name\": \"J%d\", \"type\": \"revolute\", \"bodies\": [\"%s\", \"%s\"]",
             i ? ", " : "", i, one, two);
    append(text, size, part);
    append_list(text, size, "at", h->at[i], digits);
    append_list(text, size, "axis", h->axis[i], digits);
    append(text, size, "}");
  }
  append(text, size, "]}]}");
}

/* A frame on a body at hinge `i`, seen from hinge `base` of the body, as T and R. */
static void append_frame(const hinges *h, int i, int base, int digits, char *text, size_t size) {
  double R[2][3][3], T[3]; /* [base or own][column] */
  for (int which = 0; which < 2; ++which) {
    const double *z = h->axis[which ? i : base];
    double side[3] = {fabs(z[0]) < 0.7, fabs(z[0]) >= 0.7, 0.0};
    memcpy(R[which][2], z, sizeof R[which][2]);
    cross(side, z, R[which][0]);
    normalise(R[which][0]);
    cross(z, R[which][0], R[which][1]);
  }
  char part[200];
  snprintf(part, sizeof part, "{\"name\": \"J%d\"", i);
  append(text, size, part);
  for (int a = 0; a < 3; ++a) {
    T[a] = 0.0;
    for (int k = 0; k < 3; ++k)
      T[a] += R[0][a][k] * (h->at[i][k] - h->at[base][k]);
  }
  append_list(text, size, "T", T, digits);
  append(text, size, ", \"R\": [");
  for (int a = 0; a < 3; ++a) {
    double row[3] = {0};
    for (int c = 0; c < 3; ++c)
      for (int k = 0; k < 3; ++k)
        row[c] += R[0][a][k] * R[1][c][k];
    snprintf(part, sizeof part, "%s[%.*f, %.*f, %.*f]", a ? ", " : "", digits, row[0], digits, row[1], digits, row[2]);
    append(text, size, part);
  }
  append(text, size, "]}");
}

/* Each body's own frame is that of its first hinge, so that the loops keep a gap as written. */
static void write_local(const hinges *h, int digits, char *text, size_t size) {
  char fixed[4000] = "", bodies[8000] = "", joints[3000] = "";
  for (int b = 0; b < h->bodies; ++b) {
    char part[60], *out = b == 0 ? fixed : bodies;
    size_t room = b == 0 ? sizeof fixed : sizeof bodies;
    int base = -1;
    snprintf(part, sizeof part, "%s{\"name\": \"b%d\", \"frames\": [", b > 1 ? ", " : "", b);
    append(out, room, b == 0 ? "" : part);
    for (int i = 0; i < h->count; ++i) {
      if (h->body[i][0] != b && h->body[i][1] != b)
        continue;
      append(out, room, base < 0 ? "" : ", ");
      base = base < 0 ? i : base;
      append_frame(h, i, base, digits, out, room);
    }
    append(out, room, b == 0 ? "" : "]}");
  }
  for (int i = 0; i < h->count; ++i) {
    char part[200], one[16], two[16];
    body_name(h->body[i][0], one);
    body_name(h->body[i][1], two);
    snprintf(part, sizeof part,
             "%s{\"name\": \"J%d\", \"type\": \"Rz\", \"body_frame_pairs\": [[\"%s\", \"J%d\"], [\"%s\", \"J%d\"]]}",
             i ? ", " : "", i, one, i, two, i);
    append(joints, sizeof joints, part);
  }
  snprintf(text, size,
           "{\"fixed\": {\"frames\": [%s]}, \"assemblies\": [{\"name\": \"l\", \"bodies\": [%s], \"joints\": [%s]}]}",
           fixed, bodies, joints);
}

typedef void (*writer)(const hinges *h, int digits, char *text, size_t size);
static const writer writers[] = {write_drawn, write_local};

static km_model *read_text(const char *text) {
  km_model *model = NULL;
  km_error error;
  if (km_model_read(text, strlen(text), NULL, &model, &error))
    fail_msg("%s", error.text);
  return model;
}

/* Compiles, assembles and returns the finite mobility; -1 if the loops don't close. */
static int finite_mobility(const km_model *model, double *residual) {
  km_mechanism *m = NULL;
  km_state *s = NULL;
  km_assembly evidence;
  km_mobility numbers;
  km_finite_mobility found = {0};
  int mobility = -1;
  assert_int_equal(km_mechanism_compile(model, NULL, 0, &m, NULL), KM_OK);
  assert_int_equal(km_state_create(m, &s, NULL), KM_OK);
  if (!km_assemble(m, s, &evidence, NULL)) {
    assert_int_equal(km_mobility_compute(m, s, &numbers), KM_OK);
    assert_int_equal(km_finite_mobility_find(m, s, NULL, NULL, &found, NULL), KM_OK);
    mobility = found.undecided ? -2 : found.mobility;
    *residual = evidence.residual;
  }
  km_finite_mobility_free(&found);
  km_state_free(s);
  km_mechanism_free(m);
  return mobility;
}

/* Reads the hinges as written with `digits` decimals, idealises, and returns the verdict. */
static km_rounding idealise(const hinges *h, writer write, int digits, km_model **model) {
  static char text[20000];
  km_idealisation found;
  km_error error;
  write(h, digits, text, sizeof text);
  *model = read_text(text);
  if (km_model_idealise(*model, false, NULL, &found, &error))
    fail_msg("%s", error.text);
  assert_int_equal(found.count, 1);
  km_rounding verdict = found.verdict[0];
  for (int i = 0; i < found.change_count; ++i) {
    assert_true(fabs(found.change[i].digits) <= 1.001 * verdict.largest_change);
    assert_true(found.change[i].place[0] != '\0');
  }
  km_idealisation_free(&found);
  return verdict;
}

/* True if the unrounded loop moves by itself; random loops of a family may be rigid in other assembly modes. */
static bool moves_exactly(const hinges *h) {
  static char text[20000];
  double residual;
  write_drawn(h, 17, text, sizeof text);
  km_model *model = read_text(text);
  int mobility = finite_mobility(model, &residual);
  km_model_free(model);
  return mobility == 1;
}

static void rounded_families(void **unused) {
  (void)unused;
  randomness r = {.state = 48};
  int tried = 0, missed = 0;
  for (int f = 0; f < FAMILIES; ++f)
    for (int n = 0; n < 10; ++n) {
      hinges h = families[f](&r);
      if (!moves_exactly(&h))
        continue;
      for (int digits = 3; digits <= 8; ++digits)
        for (int w = 0; w < 2; ++w) {
          km_model *model;
          double residual = nan("");
          km_rounding verdict = idealise(&h, writers[w], digits, &model);
          int mobility = finite_mobility(model, &residual);
          tried++;
          missed += mobility != 1;
          if (mobility == 1 && verdict.verdict == KM_ROUNDING_FOUND) {
            assert_int_equal(verdict.mobility, 1);
            assert_true(verdict.largest_change <= 1.0); /* an entry of R follows its neighbours too */
            assert_true(residual <= 1e-12);
          }
          km_model_free(model);
        }
    }
  assert_true(tried >= 300);
  assert_true(missed <= tried / 200); /* rounding to 3 digits can hide a motion */
}

static void off_by_thirty_digits(void **unused) {
  (void)unused;
  randomness r = {.state = 30};
  int tried = 0, called_movable = 0;
  for (int f = 0; f < FAMILIES; ++f)
    for (int n = 0; n < 20; ++n) {
      hinges h = families[f](&r);
      if (!moves_exactly(&h))
        continue;
      int digits = 3 + n % 4;
      h.at[n % h.count][n % 3] += 30.0 * pow(10.0, -digits);
      if (moves_exactly(&h)) /* an inessential direction: along the axis, or in the plane */
        continue;
      km_model *model;
      km_rounding verdict = idealise(&h, write_local, digits, &model);
      tried++;
      called_movable += verdict.verdict == KM_ROUNDING_FOUND && verdict.mobility > 0;
      km_model_free(model);
    }
  assert_true(tried >= 40);
  assert_true(called_movable <= tried / 25);
}

/* Bars between joints of a triangle strip at points of a coarse grid: exact, however few the digits. */
static void trusses_stay(void **unused) {
  (void)unused;
  randomness r = {.state = 3};
  for (int n = 0; n < 30; ++n) {
    char text[3000];
    double p[4][2] = {{0, 0}, {2, 0}, {1, 1}, {3, 1}};
    for (int i = 0; i < 4; ++i)
      for (int k = 0; k < 2; ++k)
        p[i][k] += floor(uniform(&r, 0.0, 4.0)) / 4.0;
    snprintf(text, sizeof text,
             "{\"assemblies\": [{\"name\": \"t\", \"drawn\": \"assembled\", \"bodies\": [{\"name\": \"a\"}, "
             "{\"name\": \"b\"}], \"joints\": [");
    const char *const bodies[3][2] = {{"fixed", "a"}, {"a", "b"}, {"b", "fixed"}};
    for (int i = 0; i < 3; ++i) {
      char part[200];
      snprintf(part, sizeof part,
               "%s{\"name\": \"J%d\", \"type\": \"revolute\", \"bodies\": [\"%s\", \"%s\"], \"at\": [%g, %g]}",
               i ? ", " : "", i, bodies[i][0], bodies[i][1], p[i][0], p[i][1]);
      append(text, sizeof text, part);
    }
    append(text, sizeof text, "]}]}");
    km_model *model = read_text(text);
    km_idealisation found;
    assert_int_equal(km_model_idealise(model, false, NULL, &found, NULL), KM_OK);
    assert_int_equal(found.count, 1);
    assert_int_equal(found.verdict[0].verdict, KM_ROUNDING_EXACT);
    assert_int_equal(found.change_count, 0);
    km_idealisation_free(&found);
    km_model_free(model);
  }
}

/* The gaps, at the state's configuration, of the model with one number's frame changed by `step` units. */
static void gaps_after(km_model *model, const km_written_number *number, double step, double *e, double *J) {
  km_mechanism *m;
  km_state *s;
  km_loop_gaps gaps;
  km_arena arena = {0};
  double T[3], R[9];
  km_pose written = model->frames[number->frame[0]].pose;
  km_rotation turn = km_quaternion_rotation(km_quaternion_exp(km_vec3_scale(step, number->turn)));
  km_rotation turned = km_rotation_product(&turn, &written.R);
  km_vec3 moved = km_vec3_axpy(step, number->move, written.p);
  km_rotation_rows(&turned, R);
  T[0] = moved.x;
  T[1] = moved.y;
  T[2] = moved.z;
  assert_int_equal(km_model_set_frame(model, number->frame[0], T, R, NULL), KM_OK);
  assert_int_equal(km_mechanism_compile(model, NULL, 0, &m, NULL), KM_OK);
  assert_int_equal(km_state_create(m, &s, NULL), KM_OK);
  km_poses_compute(m, s);
  assert_true(km_loop_gaps_create(m, s, 0, &arena, &gaps));
  km_loop_gaps_compute(&gaps, e, J);
  km_state_free(s);
  km_mechanism_free(m);
  km_arena_free(&arena);
  model->frames[number->frame[0]].pose = written;
}

static void derivatives_by_numbers(void **unused) {
  (void)unused;
  randomness r = {.state = 5};
  for (int f = 0; f < 3; ++f) {
    static char text[20000];
    hinges h = families[f](&r);
    write_local(&h, 4, text, sizeof text);
    km_model *model = read_text(text);
    km_mechanism *m;
    km_state *s;
    km_loop_gaps gaps;
    km_arena arena = {0};
    double e[6], J[36], E[6], plus[6], minus[6], one = 1.0;
    assert_int_equal(km_mechanism_compile(model, NULL, 0, &m, NULL), KM_OK);
    assert_int_equal(km_state_create(m, &s, NULL), KM_OK);
    km_poses_compute(m, s);
    assert_true(km_loop_gaps_create(m, s, 0, &arena, &gaps));
    assert_true(model->written_count >= 40);
    for (int k = 0; k < model->written_count; ++k) {
      const double step = 1e-5;
      km_loop_gaps_compute(&gaps, e, J);
      km_loop_gaps_number_columns(&gaps, &model->written[k], &one, 1, E);
      gaps_after(model, &model->written[k], step, plus, J);
      gaps_after(model, &model->written[k], -step, minus, J);
      for (int i = 0; i < 6; ++i) /* E is that of closed loops: their gap is about 1e-4 here */
        assert_near((plus[i] - minus[i]) / (2.0 * step), E[i], 1e-3);
    }
    km_state_free(s);
    km_mechanism_free(m);
    km_arena_free(&arena);
    km_model_free(model);
  }
}

/* Largest sine between two axes of one body, of hinges about z of their frames. */
static double largest_sine(const km_model *model) {
  double most = 0.0;
  for (int i = 0; i < model->frame_count; ++i)
    for (int k = 0; k < i; ++k)
      if (model->frames[i].body == model->frames[k].body && model->frames[i].name[0] == 'J' &&
          model->frames[k].name[0] == 'J')
        most =
            fmax(most, km_vec3_norm(km_vec3_cross(model->frames[i].pose.R.axis[2], model->frames[k].pose.R.axis[2])));
  return most;
}

/* Regular shapes: three parallel cranks get parallel axes and equal lengths, a Bennett linkage gets equal links. */
static void regular_shapes(void **state) {
  (void)state;
  static char text[20000];
  randomness r = {23};
  for (int i = 0; i < 12; ++i) {
    const bool planar = i % 2 == 0;
    const hinges h = planar ? parallelograms(&r) : bennett(&r);
    const int digits = 3 + i % 4;
    (i % 3 == 0 ? write_drawn : write_local)(&h, digits, text, sizeof text);
    km_model *model = read_text(text);
    km_idealisation found;
    double residual;
    assert_int_equal(km_model_idealise(model, true, NULL, &found, NULL), KM_OK);
    assert_int_equal(finite_mobility(model, &residual), 1);
    assert_at_most(residual, 1e-12);
    if (planar) {
      assert_at_most(largest_sine(model), 1e-13);
      assert_true(found.parallel_axes >= 9 && found.equal_lengths >= 3);
    } else {
      assert_true(found.equal_lengths >= 2 && found.parallel_axes == 0);
    }
    for (int k = 0; k < found.change_count; ++k)
      assert_at_most(found.change[k].digits, 0.6); /* within half a digit, to first order */
    km_idealisation_free(&found);
    km_model_free(model);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(rounded_families),       cmocka_unit_test(off_by_thirty_digits), cmocka_unit_test(trusses_stay),
      cmocka_unit_test(derivatives_by_numbers), cmocka_unit_test(regular_shapes),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
