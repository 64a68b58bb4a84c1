/* Lattices with many loops. */
#include "support/lattices.h"

#include "spatial/vec3.h"

/* A drawing: bodies with frames at places of the whole, and joints between frames of the same place. */
typedef struct drawing {
  km_text *text;
  km_vec3 away;
  int bodies, joints;
  km_text joint_text;
} drawing;

static void begin(drawing *d, km_text *text, double away) {
  *d = (drawing){.text = text, .away = {away, away, away}};
  km_text_add(text, "{\"assemblies\": [{\"name\": \"a\", \"bodies\": [");
}

static void finish(drawing *d) {
  km_text_format(d->text, "], \"joints\": [%s]}]}", d->joint_text.data);
  km_text_free(&d->joint_text);
}

static void begin_body(drawing *d, const char *name, int i, int k) {
  km_text_format(d->text, "%s{\"name\": \"%s%d_%d\", \"frames\": [", d->bodies++ ? ", " : "", name, i, k);
}

static void end_body(drawing *d) {
  km_text_add(d->text, "]}");
}

/* A frame whose z is the axis. */
static void add_frame(drawing *d, bool first, const char *name, int i, int k, km_vec3 at, km_vec3 axis) {
  km_vec3 p = km_vec3_add(at, d->away), z = km_vec3_scale(1.0 / km_vec3_norm(axis), axis);
  km_vec3 x = km_vec3_perpendicular(z), y = km_vec3_cross(z, x);
  km_text_format(d->text,
                 "%s{\"name\": \"%s%d_%d\", \"T\": [%.17g, %.17g, %.17g], \"R\": [[%.17g, %.17g, %.17g], [%.17g, "
                 "%.17g, %.17g], [%.17g, %.17g, %.17g]]}",
                 first ? "" : ", ", name, i, k, p.x, p.y, p.z, x.x, y.x, z.x, x.y, y.y, z.y, x.z, y.z, z.z);
}

/* A joint between the frames of one name on two bodies. */
static void add_joint(drawing *d, const char *type, const char *name, int i, int k, const char *body1, int i1, int k1,
                      const char *body2, int i2, int k2) {
  km_text_format(&d->joint_text,
                 "%s{\"name\": \"%s%d_%d\", \"type\": \"%s\", \"body_frame_pairs\": [[\"%s%d_%d\", \"%s%d_%d\"], "
                 "[\"%s%d_%d\", \"%s%d_%d\"]]}",
                 d->joints++ ? ", " : "", name, i, k, type, body1, i1, k1, name, i, k, body2, i2, k2, name, i, k);
}

/* The body stands still. */
static void add_ground(drawing *d, const char *body, int i, int k) {
  km_text_format(&d->joint_text,
                 "%s{\"name\": \"ground\", \"type\": \"rigid\", \"body_frame_pairs\": [\"fixed\", \"%s%d_%d\"]}",
                 d->joints++ ? ", " : "", body, i, k);
}

static const km_vec3 up = {0.0, 0.0, 1.0};

/* A base with a pin at every second unit of length, standing still. */
static void add_base(drawing *d, int n) {
  begin_body(d, "base", 0, 0);
  for (int i = 0; i <= n; ++i)
    add_frame(d, i == 0, "P", i, 0, (km_vec3){2.0 * i, 0, 0}, up);
  end_body(d);
  add_ground(d, "base", 0, 0);
}

/* The crank on pin i of the base, whose end belongs to the loop before it and to the one behind it. */
static void add_crank(drawing *d, const char *name, int i, int n, km_vec3 end) {
  begin_body(d, name, i, 0);
  add_frame(d, true, "P", i, 0, (km_vec3){2.0 * i, 0, 0}, up);
  if (i < n)
    add_frame(d, false, "Q", i, 0, end, up);
  if (i > 0)
    add_frame(d, false, "R", i - 1, 0, end, up);
  end_body(d);
  add_joint(d, "Rz", "P", i, 0, "base", 0, 0, name, i, 0);
}

void write_drawn_chain(km_text *text, int n, double away) {
  drawing d;
  begin(&d, text, away);
  add_base(&d, n);
  for (int i = 0; i <= n; ++i) {
    km_vec3 top = {2.0 * i + 0.6, 0.8, 0}, next = {2.0 * i + 2.6, 0.8, 0};
    add_crank(&d, "b", i, n, top);
    if (i == n)
      break;
    begin_body(&d, "c", i, 0);
    add_frame(&d, true, "Q", i, 0, top, up);
    add_frame(&d, false, "R", i, 0, next, up);
    end_body(&d);
    add_joint(&d, "Rz", "Q", i, 0, "b", i, 0, "c", i, 0);
    add_joint(&d, "Rz", "R", i, 0, "c", i, 0, "b", i + 1, 0);
  }
  finish(&d);
}

/* Their pins above the ground by `height` times as much. */
static void lay_five_bars(km_text *text, int n, double away, double height) {
  drawing d;
  begin(&d, text, away);
  add_base(&d, n);
  for (int i = 0; i <= n; ++i) {
    km_vec3 left = {2.0 * i + 0.3, height, 0}, top = {2.0 * i + 1.1, 1.7 * height, 0},
            right = {2.0 * i + 2.3, height, 0};
    add_crank(&d, "crank", i, n, left);
    if (i == n)
      break;
    begin_body(&d, "c", i, 0);
    add_frame(&d, true, "Q", i, 0, left, up);
    add_frame(&d, false, "S", i, 0, top, up);
    end_body(&d);
    begin_body(&d, "e", i, 0);
    add_frame(&d, true, "S", i, 0, top, up);
    add_frame(&d, false, "R", i, 0, right, up);
    end_body(&d);
    add_joint(&d, "Rz", "Q", i, 0, "crank", i, 0, "c", i, 0);
    add_joint(&d, "Rz", "S", i, 0, "c", i, 0, "e", i, 0);
    add_joint(&d, "Rz", "R", i, 0, "e", i, 0, "crank", i + 1, 0);
  }
  finish(&d);
}

void write_five_bars(km_text *text, int n, double away) {
  lay_five_bars(text, n, away, 1.0);
}

void write_flat_five_bars(km_text *text, int n) {
  lay_five_bars(text, n, 0.0, 0.0);
}

void write_bars(km_text *text, int n, double away) {
  drawing d;
  begin(&d, text, away);
  for (int side = 0; side < 2; ++side) {
    begin_body(&d, side ? "top" : "base", 0, 0);
    for (int i = 0; i < n; ++i) {
      double w = 2.0 * M_PI * i / n;
      km_vec3 foot = {3.0 * cos(w), 3.0 * sin(w), 0.0}, head = {cos(w + 0.5), sin(w + 0.5), 2.0 + 0.1 * sin(7.0 * w)};
      add_frame(&d, i == 0, side ? "B" : "A", i, 0, side ? head : foot, up);
    }
    end_body(&d);
  }
  add_ground(&d, "base", 0, 0);
  for (int i = 0; i < n; ++i) {
    double w = 2.0 * M_PI * i / n;
    km_vec3 foot = {3.0 * cos(w), 3.0 * sin(w), 0.0}, head = {cos(w + 0.5), sin(w + 0.5), 2.0 + 0.1 * sin(7.0 * w)};
    begin_body(&d, "bar", i, 0);
    add_frame(&d, true, "A", i, 0, foot, up);
    add_frame(&d, false, "B", i, 0, head, up);
    end_body(&d);
    add_joint(&d, "spherical", "A", i, 0, "base", 0, 0, "bar", i, 0);
    add_joint(&d, "spherical", "B", i, 0, "bar", i, 0, "top", 0, 0);
  }
  finish(&d);
}

void write_trellis(km_text *text, int rows, int columns, double away) {
  const km_vec3 along = {1.0, 0.0, 0.0}, across = {0.3, 1.1, 0.0};
  drawing d;
  begin(&d, text, away);
  for (int side = 0; side < 2; ++side) {
    int bars = side ? columns : rows, crossings = side ? rows : columns;
    for (int i = 0; i <= bars; ++i) {
      begin_body(&d, side ? "column" : "row", i, 0);
      for (int k = 0; k <= crossings; ++k) {
        int row = side ? k : i, column = side ? i : k;
        km_vec3 at = km_vec3_add(km_vec3_scale(column, along), km_vec3_scale(row, across));
        add_frame(&d, k == 0, "J", row, column, at, up);
      }
      end_body(&d);
    }
  }
  add_ground(&d, "row", 0, 0);
  for (int i = 0; i <= rows; ++i)
    for (int k = 0; k <= columns; ++k)
      add_joint(&d, "Rz", "J", i, k, "row", i, 0, "column", k, 0);
  finish(&d);
}

/* The corner of row i and column k: sides 1, angle 60 degrees, half folded. */
static km_vec3 corner(int i, int k) {
  const double angle = M_PI / 3.0, fold = 0.9;
  double t = cos(fold) * tan(angle), root = sqrt(1.0 + t * t), s = sin(fold) * sin(angle);
  return (km_vec3){k * t / root, i * sqrt(1.0 - s * s) + (k % 2) / root, (i % 2) * s};
}

static void add_crease(drawing *d, bool first, const char *name, int i, int k) {
  km_vec3 from = corner(i, k), to = name[0] == 'E' ? corner(i, k + 1) : corner(i + 1, k);
  add_frame(d, first, name, i, k, from, km_vec3_sub(to, from));
}

/* Crease E i,k is the side from corner i,k to i,k+1; crease S i,k that to i+1,k. */
void write_miura(km_text *text, int rows, int columns, double away) {
  drawing d;
  begin(&d, text, away);
  for (int i = 0; i < rows; ++i)
    for (int k = 0; k < columns; ++k) {
      begin_body(&d, "p", i, k);
      add_crease(&d, true, "E", i, k);
      add_crease(&d, false, "E", i + 1, k);
      add_crease(&d, false, "S", i, k);
      add_crease(&d, false, "S", i, k + 1);
      end_body(&d);
      if (i > 0)
        add_joint(&d, "Rz", "E", i, k, "p", i - 1, k, "p", i, k);
      if (k > 0)
        add_joint(&d, "Rz", "S", i, k, "p", i, k - 1, "p", i, k);
    }
  add_ground(&d, "p", 0, 0);
  finish(&d);
}
