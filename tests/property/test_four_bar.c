/* Types of four-bars: random links against the definition by counting turns, and every assignment of the shortest link;
 * the type doesn't depend on units. */
#include "support/support.h"

#include "kmech/mobility.h"

#include <math.h>
#include <stdio.h>

/* A four-bar of ground g, crank a, coupler b, rocker c, drawn at crank angle 1. */
static bool open_linkage(const double link[4], fixture *f) {
  const double g = link[0], a = link[1], b = link[2], c = link[3];
  double Bx = a * cos(1.0), By = a * sin(1.0), x = g - Bx, y = -By, d = hypot(x, y);
  if (d >= b + c || d <= fabs(b - c))
    return false;
  double along = (d * d + b * b - c * c) / (2.0 * d), across = sqrt(b * b - along * along);
  double Cx = Bx + (along * x - across * y) / d, Cy = By + (along * y + across * x) / d;
  char text[1200];
  snprintf(
      text, sizeof text,
      "{\"assemblies\": [{\"name\": \"l\", \"drawn\": \"assembled\", \"bodies\": [{\"name\": \"a\"}, {\"name\": \"b\"}, "
      "{\"name\": \"c\"}], \"joints\": [{\"name\": \"A\", \"type\": \"revolute\", \"bodies\": [\"fixed\", \"a\"], \"at\": "
      "[0, 0]}, {\"name\": \"B\", \"type\": \"revolute\", \"bodies\": [\"a\", \"b\"], \"at\": [%.17g, %.17g]}, {\"name\": "
      "\"C\", \"type\": \"revolute\", \"bodies\": [\"b\", \"c\"], \"at\": [%.17g, %.17g]}, {\"name\": \"D\", \"type\": "
      "\"revolute\", \"bodies\": [\"fixed\", \"c\"], \"at\": [%.17g, 0]}]}]}",
      Bx, By, Cx, Cy, g);
  *f = fixture_read(text);
  return true;
}

/* True if the crank can take every angle: |b − c| ≤ distance of B and D ≤ b + c over the turn. */
static bool turns(double g, double a, double b, double c) {
  return fabs(g - a) >= fabs(b - c) && g + a <= b + c;
}

static km_four_bar_kind expected(const double l[4]) {
  bool A = turns(l[0], l[1], l[2], l[3]), D = turns(l[0], l[3], l[2], l[1]);
  bool B = turns(l[1], l[2], l[3], l[0]);
  return A && D   ? KM_FOUR_BAR_DOUBLE_CRANK
         : A || D ? KM_FOUR_BAR_CRANK_ROCKER
         : B      ? KM_FOUR_BAR_DOUBLE_ROCKER
                  : KM_FOUR_BAR_TRIPLE_ROCKER;
}

static void random_links(void **unused) {
  (void)unused;
  randomness r = {.state = 7};
  int seen[5] = {0};
  for (int n = 0; n < 400; ++n) {
    double link[4];
    fixture f;
    km_four_bar found;
    for (int i = 0; i < 4; ++i)
      link[i] = uniform(&r, 0.5, 3.0);
    if (!open_linkage(link, &f))
      continue;
    km_poses_compute(f.mechanism, f.state);
    assert_true(km_four_bar_find(f.mechanism, f.state, 0, &found));
    assert_int_equal(found.kind, expected(link));
    for (int i = 0; i < 4; ++i)
      assert_near(found.lengths[i], link[found.joints[0] == 0 ? i : (4 - i) % 4], 1e-12);
    seen[found.kind]++;
    fixture_close(&f);
  }
  for (int kind = 0; kind < KM_FOUR_BAR_CHANGE_POINT; ++kind)
    assert_true(seen[kind] > 3);
}

static void parallelogram_and_others(void **unused) {
  (void)unused;
  static const double links[4] = {2.0, 1.0, 2.0, 1.0};
  fixture f;
  km_four_bar found;
  assert_true(open_linkage(links, &f));
  km_poses_compute(f.mechanism, f.state);
  assert_true(km_four_bar_find(f.mechanism, f.state, 0, &found));
  assert_int_equal(found.kind, KM_FOUR_BAR_CHANGE_POINT);
  assert_string_equal(km_four_bar_name(found.kind), "change point");
  assert_false(km_four_bar_find(f.mechanism, f.state, 1, &found));
  fixture_close(&f);
  static const char *const others[] = {"bennett", "slider_crank"};
  for (int i = 0; i < 2; ++i) {
    f = fixture_open(others[i]);
    km_poses_compute(f.mechanism, f.state);
    assert_false(km_four_bar_find(f.mechanism, f.state, 0, &found));
    fixture_close(&f);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(random_links), cmocka_unit_test(parallelogram_and_others)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
