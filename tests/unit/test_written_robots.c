/* Contents of written robot descriptions, and notes about elements that a format can't hold. */
#include "support/robots.h"

#include "kmech/base.h"
#include "kmech/exchange.h"
#include "model/model.h"

#include <stdio.h>
#include <string.h>

static const km_model_format formats[3] = {KM_FORMAT_URDF, KM_FORMAT_MJCF, KM_FORMAT_SDF};

static km_bytes written(const km_model *model, km_model_format format, km_messages *messages) {
  km_bytes bytes;
  assert_int_equal(km_model_write_as(model, format, NULL, NULL, messages, &bytes, NULL), KM_OK);
  return bytes;
}

#define SLIDE(JOINT, MODULES) \
  "{\"assemblies\": [{\"name\": \"m\", \"bodies\": [{\"name\": \"b\", \"mass\": 2, \"frames\": [{\"name\": \"tool\", \"T\": " \
  "[0.1, 0.2, 0.3]}, {\"name\": \"S\", \"T\": [0, 0, 1]}]}], \"joints\": [{\"name\": \"S\", \"body_frame_pairs\": [\"fixed\", " \
  "\"b\"], " JOINT "}], \"force_modules\": [" MODULES "]}]}"
#define SPRING(NAME, LAW)                                                                                              \
  "{\"name\": \"" NAME                                                                                                 \
  "\", \"type\": \"stiffness\", \"input\": {\"type\": \"joint\", \"joint\": \"S\"}, \"knot_points\": [], "             \
  "\"coefficients\": [" LAW "]}"

/* Parallel springs are written as one: 100 and 20 N/m, the second one at rest at 0.25 m. */
static void springs_side_by_side_add_up(void **unused) {
  (void)unused;
  km_model *model =
      read_as(SLIDE("\"type\": \"Tx\"", SPRING("a", "[0, -100]") ", " SPRING("b", "[5, -20]")), false, NULL);
  for (int i = 1; i < 3; ++i) {
    km_bytes bytes = written(model, formats[i], NULL);
    km_model *back = read_as(bytes.data, false, NULL);
    assert_int_equal(back->module_count, 1);
    const km_law *law = &back->modules[0].law;
    assert_near(law->coefficients[law->start[0]], 5.0, 1e-14);
    assert_near(law->coefficients[law->start[0] + 1], -120.0, 1e-13);
    km_model_free(back);
    km_bytes_free(&bytes);
  }
  km_model_free(model);
}

/* A tool's frame keeps its name; "S", which is also a joint's name, is distinguished in the file and preserved. */
static void frames_come_back(void **unused) {
  (void)unused;
  km_model *model = read_as(SLIDE("\"type\": \"Tx\"", ""), false, NULL);
  for (int i = 0; i < 3; ++i) {
    km_bytes bytes = written(model, formats[i], NULL);
    fixture f = open_text(bytes.data);
    static const char *const names[2][2] = {{"tool", "S"}, {"tool", "b/S"}};
    for (int k = 0; k < 2; ++k) {
      bool link = formats[i] == KM_FORMAT_URDF;
      const char *place[2] = {link ? names[1][k] : "b", link ? "origin" : names[0][k]};
      const double at[2][3] = {{0.1, 0.2, 0.3}, {0, 0, 1}};
      int frame;
      km_frame_pose pose;
      assert_int_equal(km_model_find_frame(f.model, place, 2, &frame, NULL), KM_OK);
      km_poses_compute(f.mechanism, f.state);
      assert_int_equal(km_frame_place(f.mechanism, f.state, frame, &pose, NULL), KM_OK);
      for (int c = 0; c < 3; ++c)
        assert_near(pose.p[c], at[k][c], 1e-15);
    }
    fixture_close(&f);
    km_bytes_free(&bytes);
  }
  km_model_free(model);
}

/* Number of notes of this kind. */
static int told_in(const km_model *model, km_model_format format, const char *kind) {
  km_messages *messages = km_messages_create();
  km_bytes bytes = written(model, format, messages);
  int found = 0;
  for (size_t k = 0; k < km_messages_count(messages); ++k)
    found += strstr(km_messages_text(messages, k), kind) != NULL;
  km_bytes_free(&bytes);
  km_messages_free(messages);
  return found;
}

/* Formats that omit a kind: a bit for each of URDF, MJCF and SDF. */
static void assert_left_out(const char *text, const char *kind, unsigned expected) {
  km_model *model = read_as(text, false, NULL);
  for (int i = 0; i < 3; ++i)
    assert_int_equal(told_in(model, formats[i], kind), (expected >> i) & 1u);
  km_model_free(model);
}

static void losses_are_told(void **unused) {
  (void)unused;
  enum { URDF = 1, MJCF = 2, SDF = 4, ALL = 7 };
  static const char slide[] =
      SLIDE("\"type\": \"Tx\", \"limits\": [-1, 1], \"stop\": {\"stiffness\": 1000, \"damping\": 10}, "
            "\"initial_velocity\": 3, \"damping\": 2, \"max_rate\": 1, \"max_force\": 5, \"friction\": "
            "{\"constant\": 1}, \"armature\": 0.1",
            SPRING("a", "[2, -10]") ", " SPRING("b", "[1, 10]"));
  static const char ball[] =
      SLIDE("\"type\": \"spherical\", \"damping\": [1, 2, 3], \"armature\": [0.1, 0.1, 0.1]", "");
  static const char alike[] = SLIDE("\"type\": \"spherical\", \"damping\": [2, 2, 2]", "");
  static const char planar[] =
      SLIDE("\"type\": \"planar\", \"limits\": [[-1, 1], [-1, 1], [-1, 1]], \"damping\": [1, 1, 1]", "");
  static const char floating[] = SLIDE("\"type\": \"float\", \"damping\": [1, 1, 1, 1, 1, 1]", "");
  assert_left_out(slide, "stiffness and damping of stops not written", ALL);
  assert_left_out(slide, "initial velocities not written", ALL);
  assert_left_out(slide, "force modules not written", ALL); /* two springs whose sum is a constant force */
  assert_left_out(slide, "inertias of rotors not written", URDF | SDF);
  assert_left_out(slide, "largest rates not written", MJCF);
  assert_left_out(slide, "damping not written", 0);
  assert_left_out(slide, "limits not written", 0);
  assert_left_out(ball, "damping not written: 3", ALL);
  assert_left_out(ball, "inertias of rotors not written: 3", URDF | SDF);
  assert_left_out(alike, "damping not written: 3", URDF | SDF);
  assert_left_out(planar, "limits not written: 3", URDF);
  assert_left_out(planar, "damping not written: 3", URDF);
  assert_left_out(floating, "damping not written: 6", ALL);
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(springs_side_by_side_add_up), cmocka_unit_test(frames_come_back),
                                     cmocka_unit_test(losses_are_told)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
