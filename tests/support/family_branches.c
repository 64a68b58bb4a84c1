/* Random mechanisms where branches cross, touch or end in cusps, whose motions are known by construction; and loops
 * whose start is straight or folded. */
#include "support/linkages.h"
#include "support/motion_families.h"

#include "kmech/mobility.h"

#include <stdio.h>
#include <string.h>

static bool last_is_undecided;

bool family_is_undecided(void) {
  bool undecided = last_is_undecided;
  last_is_undecided = false;
  return undecided;
}

/* Finite mobility and number of motions (0: any) that meet at the pose; an undecided answer counts as such. */
static bool has_motions(fixture *f, int mobility, int motions, const char *what, uint64_t seed) {
  km_finite_mobility found;
  assert_int_equal(km_finite_mobility_find(f->mechanism, f->state, NULL, NULL, &found, NULL), KM_OK);
  int branches = km_finite_mobility_branches(&found);
  bool agrees = found.mobility == mobility && (motions == 0 || branches == motions);
  last_is_undecided = found.undecided || (found.truncated && found.mobility == mobility);
  if (!agrees && !last_is_undecided)
    fprintf(stderr, "%s of seed %llu: finite mobility %d with %d motions, expected %d with %d\n", what,
            (unsigned long long)seed, found.mobility, branches, mobility, motions);
  km_finite_mobility_free(&found);
  return agrees || last_is_undecided;
}

static bool linkage_has_motions(const linkage *l, randomness *r, int mobility, int motions, const char *what,
                                uint64_t seed) {
  char *json = linkage_text(l, (writing){.own_frames = below(r, 2)}, r);
  fixture f = fixture_read(json);
  bool agrees = has_motions(&f, mobility, motions, what, seed);
  km_free(json);
  fixture_close(&f);
  return agrees;
}

static const km_vec3 z_axis = {0, 0, 1};

static void add_hinge(linkage *l, int parent, int child, double x, double y) {
  l->joint[l->joints++] = (axis_joint){parent, child, false, {x, y, 0}, z_axis};
  int last = parent > child ? parent : child;
  l->bodies = last > l->bodies ? last : l->bodies;
}

static int greatest_common_divisor(int a, int b) {
  return b ? greatest_common_divisor(b, a % b) : a;
}

/* Slides s, t, z with the couplings z = a s^m and z = b t^k: s^m = (b/a) t^k has g = gcd(m, k) complex branches. One is
 * real for odd g; for even g two are if b/a > 0, and none if b/a < 0. */
bool family_powers(uint64_t seed) {
  randomness r = {seed};
  int power[2] = {2 + below(&r, 3), 2 + below(&r, 3)}, g = greatest_common_divisor(power[0], power[1]);
  double a[2] = {uniform(&r, 0.3, 3.0), uniform(&r, 0.3, 3.0) * (below(&r, 2) ? 1.0 : -1.0)};
  int motions = g % 2 ? 1 : a[1] > 0.0 ? 2 : 0;
  km_text text = {0};
  km_text_add(
      &text,
      "{\"assemblies\": [{\"name\": \"a\", \"bodies\": [{\"name\": \"s\"}, {\"name\": \"t\"}, {\"name\": \"z\"}], \"joints\": [");
  for (int i = 0; i < 3; ++i)
    km_text_format(&text, "%s{\"name\": \"%c\", \"type\": \"T%c\", \"body_frame_pairs\": [\"fixed\", \"%c\"]}",
                   i ? ", " : "", "STZ"[i], 'x' + i, "stz"[i]);
  km_text_add(&text, "], \"couplings\": [");
  for (int i = 0; i < 2; ++i) {
    km_text_format(&text, "%s{\"name\": \"c%d\", \"joints\": [\"Z\", \"%c\"], \"polynomial\": [0", i ? ", " : "", i,
                   "ST"[i]);
    for (int k = 1; k <= power[i]; ++k)
      km_text_format(&text, ", %.17g", k == power[i] ? a[i] : 0.0);
    km_text_add(&text, "]}");
  }
  km_text_add(&text, "]}]}");
  fixture f = fixture_read(text.data);
  char what[64];
  snprintf(what, sizeof what, "%.2g s^%d = %.2g t^%d", a[0], power[0], a[1], power[1]);
  bool agrees = has_motions(&f, motions > 0, motions > 1 ? motions : 0, what, seed);
  km_text_free(&text);
  fixture_close(&f);
  return agrees;
}

/* A four-bar on a base of length `base` at x: bodies first … first + 2. Places of the moving pins go to `pin`. */
static bool add_four_bar(linkage *l, int first, double x, double crank, double coupler, double rocker, double base,
                         double angle, double pin[2]) {
  double px = crank * cos(angle), py = crank * sin(angle), dx = base - px, dy = -py, reach = hypot(dx, dy);
  double along = (coupler * coupler - rocker * rocker + reach * reach) / (2.0 * reach);
  double across = sqrt(coupler * coupler - along * along);
  if (!(across > 0.2))
    return false;
  add_hinge(l, 0, first, x, 0.0);
  add_hinge(l, first, first + 1, x + px, py);
  add_hinge(l, first + 1, first + 2, x + px + (along * dx - across * dy) / reach,
            py + (along * dy + across * dx) / reach);
  add_hinge(l, 0, first + 2, x + base, 0.0);
  pin[0] = x + px;
  pin[1] = py;
  return true;
}

/* Equal four-bars in a row whose cranks' pins are tied by rods: the cranks are parallelograms, which have a
 * second branch each where they lie along the rods. */
bool family_twins(uint64_t seed) {
  randomness r = {seed};
  int count = 2 + below(&r, 2);
  bool at_change_point = below(&r, 2);
  double crank = uniform(&r, 0.4, 0.6), coupler = uniform(&r, 1.7, 2.2), rocker = uniform(&r, 1.2, 1.6);
  double angle = at_change_point ? (below(&r, 2) ? M_PI : 0.0) : uniform(&r, 0.3, 2.8), pin[3][2];
  linkage l = {0};
  for (int i = 0; i < count; ++i)
    if (!add_four_bar(&l, 3 * i + 1, i * 4.5, crank, coupler, rocker, 2.0, angle, pin[i]))
      return true;
  for (int i = 0; i + 1 < count; ++i) {
    add_hinge(&l, 3 * i + 1, 3 * count + 1 + i, pin[i][0], pin[i][1]);
    add_hinge(&l, 3 * count + 1 + i, 3 * i + 4, pin[i + 1][0], pin[i + 1][1]);
  }
  return linkage_has_motions(&l, &r, 1, at_change_point ? 1 << (count - 1) : 0, "tied twins", seed);
}

/* A parallelogram with stretched chains of two or three bars between points of its cranks at a constant distance: each
 * chain is shaky all along and hinders nothing. */
bool family_stretched(uint64_t seed) {
  randomness r = {seed};
  double x = uniform(&r, 0.2, 0.8), y = uniform(&r, 0.8, 1.4), width = uniform(&r, 1.5, 2.5);
  linkage l = {0};
  add_hinge(&l, 0, 1, 0.0, 0.0);
  add_hinge(&l, 1, 2, x, y);
  add_hinge(&l, 2, 3, x + width, y);
  add_hinge(&l, 0, 3, width, 0.0);
  for (int chain = below(&r, 2); chain >= 0; --chain) {
    double part = uniform(&r, 0.2, 0.8), at = part * x;
    int bars = 2 + below(&r, 2), body = 1;
    for (int i = 1; i <= bars; ++i) {
      int next = l.bodies + 1;
      add_hinge(&l, body, next, at, part * y);
      at += i < bars ? uniform(&r, 0.2, 0.4) * width : 0.0;
      body = next;
    }
    add_hinge(&l, body, 3, part * x + width, part * y);
  }
  return linkage_has_motions(&l, &r, 1, 0, "stretched chains", seed);
}

/* A flat parallelogram (a branch point of two motions) with two bars from its coupler to the ground: they add no
 * freedom, however near they are to being stretched. */
bool family_change_beside_toggle(uint64_t seed) {
  randomness r = {seed};
  double crank = uniform(&r, 0.3, 0.8), base = uniform(&r, 1.2, 2.0), u = uniform(&r, 0.2, 0.8) * base;
  double bent = pow(10.0, uniform(&r, -2.5, 0.0)), bar = uniform(&r, 0.8, 1.2);
  double at[2] = {crank + u, 0.0}, side = below(&r, 2) ? 1.0 : -1.0;
  linkage l = {0};
  add_hinge(&l, 0, 1, 0.0, 0.0);
  add_hinge(&l, 1, 2, crank, 0.0);
  add_hinge(&l, 2, 3, crank + base, 0.0);
  add_hinge(&l, 0, 3, base, 0.0);
  double tilt = uniform(&r, 0.4, 1.2), first = tilt + bent, second = tilt - bent;
  add_hinge(&l, 2, 4, at[0], at[1]);
  add_hinge(&l, 4, 5, at[0] + bar * cos(first), at[1] + side * bar * sin(first));
  add_hinge(&l, 0, 5, at[0] + bar * (cos(first) + cos(second)), at[1] + side * bar * (sin(first) + sin(second)));
  return linkage_has_motions(&l, &r, 1, 2, "change point beside a toggle", seed);
}

/* A loop of hinges drawn straight or folded: it closes if and only if its longest link is at most as long as the
 * others together. */
bool family_straight_start(uint64_t seed) {
  randomness r = {seed};
  int count = 3 + below(&r, 5);
  bool is_folded = below(&r, 2);
  double length[8], longest = 0.0, sum = 0.0;
  km_text text = {0};
  for (int i = 0; i < count; ++i) {
    length[i] = uniform(&r, 0.1, below(&r, 3) ? 2.0 : 5.0);
    longest = fmax(longest, length[i]);
    sum += length[i];
  }
  double over = 2.0 * longest - sum;
  if (fabs(over) < 1e-6)
    return true;
  km_text_format(&text,
                 "{\"fixed\": {\"frames\": [{\"name\": \"pin\", \"T\": [%.17g, 0, 0]}]}, \"assemblies\": [{"
                 "\"name\": \"a\", \"bodies\": [",
                 length[count - 1]);
  for (int i = 0; i + 1 < count; ++i)
    km_text_format(&text, "%s{\"name\": \"b%d\", \"frames\": [{\"name\": \"end\", \"T\": [%.17g, 0, 0]}]}",
                   i ? ", " : "", i, is_folded && below(&r, 2) ? -length[i] : length[i]);
  km_text_add(&text, "], \"joints\": [");
  for (int i = 0; i + 1 < count; ++i) {
    char parent[32] = "fixed";
    if (i > 0)
      snprintf(parent, sizeof parent, "b%d/end", i - 1);
    km_text_format(&text, "{\"name\": \"J%d\", \"type\": \"Rz\", \"body_frame_pairs\": [\"%s\", \"b%d\"]}, ", i, parent,
                   i);
  }
  km_text_format(&text,
                 "{\"name\": \"last\", \"type\": \"%s\", \"body_frame_pairs\": [\"b%d/end\", \"fixed/pin\"]}]}]}",
                 below(&r, 3) ? "Rz" : "spherical", count - 2);
  fixture f = {0};
  km_error error;
  km_status status = fixture_try(text.data, &f, &error);
  bool agrees = status == (over > 0.0 ? KM_MODEL : KM_OK);
  if (!agrees)
    fprintf(stderr, "straight start %llu: %d links, longest %g over the others: %s\n", (unsigned long long)seed, count,
            over, status ? error.text : "it closes");
  km_text_free(&text);
  fixture_close(&f);
  return agrees;
}

/* A platform on two mirror-image legs of two bars and a central slide: both legs have equal mobility numbers, whatever
 * the frames, however near they are to being stretched. */
bool family_mirrored_legs(uint64_t seed) {
  randomness r = {seed};
  double half = uniform(&r, 0.3, 0.8), height = uniform(&r, 1.0, 1.6), foot = uniform(&r, 0.8, 1.6);
  double bend = pow(10.0, uniform(&r, -3.0, -0.3)), part = uniform(&r, 0.35, 0.65);
  linkage l = {0};
  for (int side = 0; side < 2; ++side) {
    double sign = side ? -1.0 : 1.0, dx = foot - half, dy = -height, reach = hypot(dx, dy);
    double knee[2] = {half + part * dx + bend * dy / reach, height + part * dy - bend * dx / reach};
    add_hinge(&l, 0, 2 * side + 2, sign * foot, 0.0);
    add_hinge(&l, 2 * side + 2, 2 * side + 3, sign * knee[0], knee[1]);
    add_hinge(&l, 2 * side + 3, 1, sign * half, height);
  }
  l.joint[l.joints++] = (axis_joint){0, 1, true, {0, 0, 0}, {0, 1, 0}};
  char *json = linkage_text(&l, (writing){.own_frames = below(&r, 2)}, &r);
  fixture f = fixture_read(json);
  km_mobility at;
  km_mobility_compute(f.mechanism, f.state, &at);
  bool agrees = at.mobility == 1;
  for (int k = 0; k < 3; ++k)
    agrees = agrees && fabs(km_mobility_number(f.state, k) - km_mobility_number(f.state, 3 + k)) <= 1e-9;
  if (!agrees)
    fprintf(stderr, "mirrored legs %llu: mobility %d, numbers %.12g and %.12g\n", (unsigned long long)seed, at.mobility,
            km_mobility_number(f.state, 1), km_mobility_number(f.state, 4));
  km_free(json);
  fixture_close(&f);
  return agrees;
}
