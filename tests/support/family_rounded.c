/* Random overconstrained linkages as CAD rounds them: what a refusal promises comes true. */
#include "support/linkages.h"
#include "support/motion_families.h"

#include "kmech/mobility.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* True if a linkage with one freedom is reported as movable or undecided. */
static bool may_move(fixture *f) {
  km_finite_mobility found;
  assert_int_equal(km_finite_mobility_find(f->mechanism, f->state, NULL, NULL, &found, NULL), KM_OK);
  bool agrees = found.undecided || found.mobility == 1;
  km_finite_mobility_free(&found);
  return agrees;
}

/* True if the tolerance named by a refusal or note gives the stated mobility. */
static bool keeps_promise(const linkage *l, writing how, uint64_t seed, const char *words) {
  const char *named = strstr(words, "\"closure_tolerance\": "), *promise = strstr(words, "mobility ");
  if (!named || !promise)
    return true;
  randomness again = {seed};
  fixture f;
  km_error error = {0};
  km_mobility mobility = {0};
  how.tolerance = strtod(named + strlen("\"closure_tolerance\": "), NULL);
  char *json = linkage_text(l, how, &again);
  bool kept = !fixture_try(json, &f, &error);
  if (kept)
    km_mobility_compute(f.mechanism, f.state, &mobility);
  kept = kept && mobility.mobility == atoi(promise + strlen("mobility ")) && (mobility.mobility != 1 || may_move(&f));
  if (!kept)
    fprintf(stderr, "promised: %s\n  found: mobility %d %s\n", words, mobility.mobility, error.text);
  km_free(json);
  fixture_close(&f);
  return kept;
}

bool family_rounded(uint64_t seed) {
  randomness r = {seed};
  int kind = below(&r, MOVING_KINDS);
  writing how = {.own_frames = true, .digits = 3 + below(&r, 7)};
  linkage l = nearly_singular_loop(kind, below(&r, 2) ? 60 : 1, &r);
  uint64_t writing_seed = r.state;
  char *json = linkage_text(&l, how, &r);
  fixture f;
  km_error error = {0};
  bool agrees = true;
  if (fixture_try(json, &f, &error)) {
    agrees = keeps_promise(&l, how, writing_seed, error.text);
  } else { /* accepted models move, or a note states the tolerance with which they do */
    char *notes = fixture_notes(&f);
    bool promises = notes && strstr(notes, "\"closure_tolerance\": ");
    agrees = promises ? keeps_promise(&l, how, writing_seed, notes) : how.digits < 7 || may_move(&f);
    km_free(notes);
  }
  if (!agrees)
    fprintf(stderr, "%s of seed %llu, %d digits\n", moving_names[kind], (unsigned long long)seed, how.digits);
  km_free(json);
  fixture_close(&f);
  return agrees;
}

/* A triangle of two long bars and a short link, all exact: rigid. A further bar makes it movable. */
bool family_short_link(uint64_t seed) {
  randomness r = {seed};
  int bars = 3 + below(&r, 2);
  double link = pow(10.0, uniform(&r, -6, -3)), side = uniform(&r, 5, 10), turn = uniform(&r, -3, 3);
  double lean = uniform(&r, 0.5, 2.6); /* angle of the short link to the next bar */
  km_vec3 z = {0, 0, 1}, along[4] = {z, z, z, z}, at[4];
  at[0] = random_point(&r);
  at[1] = km_vec3_add(at[0], (km_vec3){link * cos(turn), link * sin(turn), 0});
  at[2] = km_vec3_add(at[1], (km_vec3){side * cos(turn + lean), side * sin(turn + lean), 0});
  at[3] = km_vec3_add(at[0], (km_vec3){0.5 * side * cos(turn + 2), 0.5 * side * sin(turn + 2), 0});
  linkage l = hinged_loop(at, along, bars);
  char *json = linkage_text(&l, (writing){.own_frames = below(&r, 2)}, &r);
  fixture f;
  km_error error = {0};
  km_mobility mobility = {0};
  bool agrees = !fixture_try(json, &f, &error);
  if (agrees)
    km_mobility_compute(f.mechanism, f.state, &mobility);
  agrees = agrees && mobility.mobility == bars - 3;
  if (!agrees)
    fprintf(stderr, "short link of seed %llu: %g beside %g: mobility %d %s\n", (unsigned long long)seed, link, side,
            mobility.mobility, error.text);
  km_free(json);
  fixture_close(&f);
  return agrees;
}
