/* All assembly modes of random 6-6 platforms, one line for each. Usage: platforms COUNT [SEED].
 *
 *   base and top points: six each, uniform in cubes of 2 and 1.4;   top turned by a random rotation, about 1.5 above
 *   legs: struts at their drawn lengths.   Generic ones have 40 complex modes (M. Raghavan 1993) */
#include "support/support.h"

#include "base/random.h"
#include "kmech/space.h"
#include "spatial/rotation.h"

#include <stdio.h>
#include <stdlib.h>
#include <time.h>

enum { LEGS = 6, COMPLEX_MODES = 40 };

static km_vec3 random_point(uint64_t *random, double half) {
  double x = km_uniform(random), y = km_uniform(random);
  return (km_vec3){half * x, half * y, half * km_uniform(random)};
}

/* The platform with a number, at its pose. */
static fixture random_platform(unsigned long seed) {
  uint64_t random = 2 * seed + 1;
  km_text text = {0}, top = {0};
  for (int i = 0; i < 20; ++i) /* the first numbers of near seeds are near */
    km_uniform(&random);
  km_pose pose = {.R = km_rotation_identity(), .p = random_point(&random, 0.5)};
  for (int k = 0; k < 3; ++k) {
    double angle = M_PI * km_uniform(&random);
    pose.R = km_rotation_about_axis(&pose.R, k, cos(angle), sin(angle));
  }
  pose.p.z += 1.5;
  km_text_add(&text, "{\"fixed\": {\"frames\": [");
  for (int k = 0; k < LEGS; ++k) {
    km_vec3 base = random_point(&random, 1.0), at = km_pose_point(&pose, random_point(&random, 0.7));
    km_text_format(&text, "%s{\"name\": \"f%d\", \"T\": [%.17g, %.17g, %.17g]}", k ? ", " : "", k, base.x, base.y,
                   base.z);
    km_text_format(&top, "%s{\"name\": \"e%d\", \"T\": [%.17g, %.17g, %.17g]}", k ? ", " : "", k, at.x, at.y, at.z);
  }
  km_text_format(&text,
                 "]}, \"assemblies\": [{\"name\": \"p\", \"drawn\": \"assembled\", \"bodies\": [{\"name\": \"top\", "
                 "\"frames\": [%s]}], \"struts\": [",
                 top.data);
  for (int k = 0; k < LEGS; ++k)
    km_text_format(&text, "%s{\"name\": \"L%d\", \"from\": \"fixed/f%d\", \"to\": \"top/e%d\"}", k ? ", " : "", k, k,
                   k);
  km_text_add(&text, "]}]}");
  fixture f = fixture_read(text.data);
  km_text_free(&text);
  km_text_free(&top);
  return f;
}

/* True if the list is complete, with 40 complex modes, each real one proved. */
static bool try_platform(unsigned long seed) {
  fixture f = random_platform(seed);
  int locked[LEGS];
  for (int k = 0; k < LEGS; ++k)
    locked[k] = fixture_coordinate(&f, (const char[]){'L', (char)('0' + k), '\0'});
  const km_all_modes_def def = {.locked = locked, .locked_count = LEGS, .seed = 1};
  km_all_modes modes;
  km_error error = {0};
  double start = (double)clock() / CLOCKS_PER_SEC;
  km_status status = km_all_modes_find(f.mechanism, f.state, &def, NULL, NULL, &modes, &error);
  double seconds = (double)clock() / CLOCKS_PER_SEC - start;
  int proved = 0;
  for (int i = 0; i < modes.count; ++i)
    proved += modes.evidence[i].is_certified;
  bool is_complete = !status && modes.is_complete && modes.complex_solutions == COMPLEX_MODES && proved == modes.count;
  printf("%lu: %s%s, %d complex, %d real, %d proved, trace %.1e, %.2f s\n", seed,
         status ? error.text : km_mode_gap_name(modes.gap), is_complete ? "" : " NOT AS IT SHOULD BE",
         modes.complex_solutions, modes.count, proved, modes.trace_difference, seconds);
  km_all_modes_free(&modes);
  fixture_close(&f);
  return is_complete;
}

int main(int argc, char **argv) {
  int count = argc > 1 ? atoi(argv[1]) : 1, complete = 0;
  unsigned long first = argc > 2 ? strtoul(argv[2], NULL, 10) : 1;
  double start = (double)clock() / CLOCKS_PER_SEC;
  for (int i = 0; i < count; ++i) {
    complete += try_platform(first + (unsigned long)i);
    fflush(stdout);
  }
  printf("%d of %d platforms have all 40 modes, each real one proved; %.2f s CPU each\n", complete, count,
         ((double)clock() / CLOCKS_PER_SEC - start) / count);
  return complete == count ? 0 : 1;
}
