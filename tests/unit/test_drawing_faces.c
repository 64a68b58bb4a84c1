/* Hidden faces: wherever faces overlap on the page, the nearest one is painted last. */
#include "support/support.h"

#include "report/drawing/drawing_parts.h"

enum { FACES = 60, PLACES = 4000 };

static km_spot random_spot(randomness *r) {
  return (km_spot){uniform(r, 0, 100), uniform(r, 0, 100), uniform(r, -50, 50)};
}

static km_face *random_face(randomness *r, int body, km_arena *arena) {
  km_face *face = KM_ARENA_NEW(arena, km_face, 1);
  face->spots = KM_ARENA_NEW(arena, km_spot, 3);
  km_spot *p = face->spots, n;
  double size;
  do {
    for (int k = 0; k < 3; ++k)
      p[k] = random_spot(r);
    km_spot a = {p[1].x - p[0].x, p[1].y - p[0].y, p[1].depth - p[0].depth};
    km_spot b = {p[2].x - p[0].x, p[2].y - p[0].y, p[2].depth - p[0].depth};
    n = (km_spot){a.y * b.depth - a.depth * b.y, a.depth * b.x - a.x * b.depth, a.x * b.y - a.y * b.x};
    size = (n.depth < 0.0 ? -1.0 : 1.0) * sqrt(n.x * n.x + n.y * n.y + n.depth * n.depth);
  } while (fabs(n.depth) < 0.05 * fabs(size)); /* edge-on faces have depths without digits */
  face->normal = (km_spot){n.x / size, n.y / size, n.depth / size};
  face->count = 3;
  face->body = body;
  face->shown = 7;
  return face;
}

static bool covers(const km_face *face, double x, double y) {
  int left = 0, right = 0;
  for (int i = 0; i < face->count; ++i) {
    km_spot a = face->spots[i], b = face->spots[(i + 1) % face->count];
    double turn = (b.x - a.x) * (y - a.y) - (b.y - a.y) * (x - a.x);
    left += turn > 0.0;
    right += turn < 0.0;
  }
  return left == 0 || right == 0;
}

static double depth_at(const km_face *face, double x, double y) {
  const km_spot *p = face->spots, *n = &face->normal;
  return p->depth - (n->x * (x - p->x) + n->y * (y - p->y)) / n->depth;
}

static void the_nearest_face_is_painted_last(void **state) {
  (void)state;
  randomness r = {11};
  km_arena arena = {0};
  km_face *list = NULL, *whole[FACES];
  for (int i = 0; i < FACES; ++i) {
    km_face *face = random_face(&r, i, &arena);
    whole[i] = KM_ARENA_NEW(&arena, km_face, 1);
    *whole[i] = *face;
    face->next = list;
    list = face;
  }
  const km_face *ordered = km_faces_order(list, &arena);
  assert_false(arena.failed);
  int compared = 0;
  for (int k = 0; k < PLACES; ++k) {
    double x = uniform(&r, 0, 100), y = uniform(&r, 0, 100), nearest = -HUGE_VAL, second = -HUGE_VAL;
    int body = -1, painted = -1;
    for (int i = 0; i < FACES; ++i) {
      double depth = covers(whole[i], x, y) ? depth_at(whole[i], x, y) : -HUGE_VAL;
      second = depth > nearest ? nearest : fmax(second, depth);
      if (depth > nearest) {
        nearest = depth;
        body = i;
      }
    }
    for (const km_face *face = ordered; face; face = face->next)
      if (covers(face, x, y))
        painted = face->body;
    if (nearest - second < 1e-2) /* a hundred times what counts as one plane */
      continue;
    assert_int_equal(painted, body);
    ++compared;
  }
  assert_true(compared > PLACES / 2);
  km_arena_free(&arena);
}

/* A cut adds no edge that shows, and takes none away. */
static void cuts_do_not_show(void **state) {
  (void)state;
  km_arena arena = {0};
  km_spot wall[3] = {{50, -10, -50}, {50, 110, -50}, {50, 50, 80}}, floor[3] = {{0, 0, 0}, {100, 0, 0}, {50, 100, 0}};
  /* Leans a little, so that it is seen. */
  wall[0].x -= 1.0;
  wall[1].x -= 1.0;
  km_face faces[2] = {{.next = &faces[1], .spots = wall, .count = 3, .body = 0, .shown = 7},
                      {.spots = floor, .count = 3, .body = 1, .shown = 7, .normal = {0, 0, 1}}};
  double lean = 1.0 / 130.0, size = sqrt(1.0 + lean * lean);
  faces[0].normal = (km_spot){-1.0 / size, 0.0, lean / size};
  double length[2] = {0, 0};
  int pieces = 0;
  for (const km_face *face = km_faces_order(faces, &arena); face; face = face->next, ++pieces)
    for (int i = 0; i < face->count; ++i)
      if (face->shown >> i & 1U) {
        km_spot a = face->spots[i], b = face->spots[(i + 1) % face->count];
        length[face->body] += sqrt(pow(b.x - a.x, 2) + pow(b.y - a.y, 2) + pow(b.depth - a.depth, 2));
      }
  assert_int_equal(pieces, 3);
  double edge = sqrt(50.0 * 50.0 + 100.0 * 100.0);
  assert_near(length[1], 100.0 + 2.0 * edge, 1e-9);
  assert_near(length[0], 120.0 + 2.0 * sqrt(1.0 + 60.0 * 60.0 + 130.0 * 130.0), 1e-9);
  km_arena_free(&arena);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(the_nearest_face_is_painted_last),
      cmocka_unit_test(cuts_do_not_show),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
