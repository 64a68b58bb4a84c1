/* Rows of loops. */
#include "support/lattices.h"

#include "support/hinges.h"

/* The tops of the rockers are above the ground by `height`, and the rockers 1 long. */
static void lay_chain(km_text *out, int n, double away, double height) {
  hinges h = {0};
  double along = sqrt(1.0 - height * height);
  for (int i = 0; i <= n; ++i)
    hinges_pin(&h, 0, 1 + i, 2.0 * i, 0.0);
  for (int i = 0; i < n; ++i) {
    hinges_pin(&h, 1 + i, 2 + n + i, 2.0 * i + along, height);
    hinges_pin(&h, 2 + n + i, 2 + i, 2.0 * i + 2.0 + along, height);
  }
  hinges_write(&h, out, away);
}

void write_drawn_chain(km_text *out, int n, double away) {
  lay_chain(out, n, away, 0.8);
}

void write_folded_chain(km_text *out, int n) {
  lay_chain(out, n, 0.0, 0.0);
}

/* Pivots of the cranks on the ground. */
static km_vec3 foot(int i, double bend) {
  return (km_vec3){2.0 * i, bend * (i % 3 == 1), 0.0};
}

/* A place on the way from one foot to the next and above it. */
static km_vec3 beside(int i, double bend, double along, double above) {
  km_vec3 from = foot(i, bend), way = km_vec3_sub(foot(i + 1, bend), from);
  return (km_vec3){from.x + along * way.x, from.y + along * way.y + above, 0.0};
}

/* Pins above the rails by `height` times their distance, every third foot displaced by `bend`. */
static void lay_five_bars(km_text *out, int n, double away, double height, double bend) {
  hinges h = {0};
  for (int i = 0; i <= n; ++i)
    hinges_pin(&h, 0, 1 + i, foot(i, bend).x, foot(i, bend).y);
  for (int i = 0; i < n; ++i) {
    km_vec3 left = beside(i, bend, 0.15, height), top = beside(i, bend, 0.55, 1.7 * height),
            right = beside(i, bend, 1.15, height);
    int link = 2 + n + 2 * i;
    hinges_pin(&h, 1 + i, link, left.x, left.y);
    hinges_pin(&h, link, link + 1, top.x, top.y);
    hinges_pin(&h, link + 1, 2 + i, right.x, right.y);
  }
  hinges_write(&h, out, away);
}

void write_five_bars(km_text *out, int n, double away) {
  lay_five_bars(out, n, away, 1.0, 0.0);
}

void write_flat_five_bars(km_text *out, int n) {
  lay_five_bars(out, n, 0.0, 0.0, 0.0);
}

void write_stretched_five_bars(km_text *out, int n) {
  lay_five_bars(out, n, 0.0, 0.0, 0.5);
}

/* The cranks' joints with the ground are of the type that is given. A crank turns the next one about as far as it
 * turns itself, else the last one of many would hardly turn at all. */
static void lay_ball_couplers(km_text *out, int n, const char *type) {
  hinges h = {0};
  for (int i = 0; i <= n; ++i)
    hinges_add(&h, type, 0, 1 + i, (km_vec3){2.0 * i, 0.0, 0.0}, (km_vec3){0.3 * sin(i), 0.4 * cos(2.0 * i), 1.0});
  for (int i = 0; i < n; ++i) {
    km_vec3 from = {2.0 * i + 0.6, 0.8, 0.2 * sin(3.0 * i)}, to = {2.0 * i + 2.6, 0.8, 0.2 * cos(5.0 * i)};
    hinges_add(&h, "spherical", 1 + i, 2 + n + i, from, (km_vec3){0.0, 0.0, 1.0});
    hinges_add(&h, "spherical", 2 + n + i, 2 + i, to, (km_vec3){0.0, 0.0, 1.0});
  }
  hinges_write(&h, out, 0.0);
}

void write_ball_couplers(km_text *out, int n) {
  lay_ball_couplers(out, n, "Rz");
}

void write_balls(km_text *out, int n) {
  lay_ball_couplers(out, n, "spherical");
}

void write_bars(km_text *out, int n, double away) {
  const km_vec3 up = {0.0, 0.0, 1.0};
  hinges h = {0};
  for (int i = 0; i < n; ++i) {
    double w = 2.0 * M_PI * i / n;
    hinges_add(&h, "spherical", 0, 2 + i, (km_vec3){3.0 * cos(w), 3.0 * sin(w), 0.0}, up);
    hinges_add(&h, "spherical", 2 + i, 1, (km_vec3){cos(w + 0.5), sin(w + 0.5), 2.0 + 0.1 * sin(7.0 * w)}, up);
  }
  hinges_write(&h, out, away);
}
