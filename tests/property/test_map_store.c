/* The store of a map: whatever ended the runs before, a map has the bits of one that was computed without a stop. */
#include "support/support.h"

#include "kmech/clearance.h"
#include "kmech/space.h"
#include "model/model.h"

#include <limits.h>
#include <signal.h>
#include <sqlite3.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

enum { STOPS = 12, KILLS = 4, RUNS = 100 };

/* A map of a model, with all that it needs. */
typedef struct mapped {
  fixture f;
  km_clearance *clearance;
  km_map_figures figures;
  const char *unit, *name;
  km_space_map_def def;
  int asked; /* configurations for which the figure was computed */
} mapped;

/* A figure: the third coordinate. */
static bool compute_figure(void *context, const km_mechanism *m, km_state *s, double *values) {
  mapped *of = context;
  (void)m;
  ++of->asked;
  values[0] = s->q[2];
  return true;
}

/* A five-bar. `type`: of the joints C and D; with "spherical" the rod between them can spin. `driven`: the body that the
 * crank moves; `shape`: of the point's body; `bodies` and `joints`: further ones. */
#define FIVE_BAR(type, driven, shape, bodies, joints)                                                                  \
  "{\"assemblies\": [{\"name\": \"a\", \"drawn\": \"assembled\", \"bodies\": [{\"name\": \"b1\"}, {\"name\": "         \
  "\"b2\", \"frames\": [{\"name\": \"P\", \"T\": [0.5, 1.15, 0]}]" shape                                               \
  "}, {\"name\": \"b3\"}, {\"name\": \"b4\"}" bodies "], \"joints\": ["                                                \
  "{\"name\": \"A\", \"type\": \"revolute\", \"bodies\": [\"fixed\", \"b1\"], \"at\": [0, 0]},"                        \
  "{\"name\": \"B\", \"type\": \"revolute\", \"bodies\": [\"" driven "\", \"b2\"], \"at\": [-0.2, 0.6]},"              \
  "{\"name\": \"C\", \"type\": \"" type "\", \"bodies\": [\"b2\", \"b3\"], \"at\": [0.5, 1.15]},"                      \
  "{\"name\": \"D\", \"type\": \"" type "\", \"bodies\": [\"b4\", \"b3\"], \"at\": [1.2, 0.7]},"                       \
  "{\"name\": \"E\", \"type\": \"revolute\", \"bodies\": [\"fixed\", \"b4\"], \"at\": [1, 0]}" joints "]}]}"
/* Redundant constraints: the crank is one of three that stay parallel. */
static const char redundant[] =
    FIVE_BAR("revolute", "bar", "", ", {\"name\": \"bar\"}, {\"name\": \"p\"}, {\"name\": \"q\"}",
             ", {\"name\": \"F\", \"type\": \"revolute\", \"bodies\": [\"b1\", \"bar\"], \"at\": [-0.2, 0.6]},"
             "{\"name\": \"G\", \"type\": \"revolute\", \"bodies\": [\"fixed\", \"p\"], \"at\": [-0.5, -0.18]},"
             "{\"name\": \"H\", \"type\": \"revolute\", \"bodies\": [\"p\", \"bar\"], \"at\": [-0.7, 0.42]},"
             "{\"name\": \"I\", \"type\": \"revolute\", \"bodies\": [\"q\", \"fixed\"], \"at\": [-0.3, 0.1]},"
             "{\"name\": \"J\", \"type\": \"revolute\", \"bodies\": [\"q\", \"bar\"], \"at\": [-0.5, 0.7]}"),
                  spun[] = FIVE_BAR("spherical", "b1", "", "", ""),
                  with_post[] =
                      FIVE_BAR("revolute", "b1", ", \"shapes\": [{\"sphere\": 0.05, \"T\": [0.5, 1.15, 0]}]",
                               ", {\"name\": \"post\", \"shapes\": [{\"sphere\": 0.05, \"T\": [0.6, 0.8, 0]}]}",
                               ", {\"name\": \"Z\", \"type\": \"rigid\", \"body_frame_pairs\": [\"fixed\", \"post\"]}");

/* Over joints `first` and `second` from −range to range, with the place of a frame, and a figure. */
static void begin(mapped *out, fixture f, const char *first, const char *second, double range, int steps,
                  const char *body) {
  *out = (mapped){.f = f, .unit = "", .name = "third"};
  out->figures = (km_map_figures){1, &out->name, &out->unit, compute_figure, out};
  out->def = (km_space_map_def){.axis = {{fixture_coordinate(&f, first), -range, range, steps},
                                         {fixture_coordinate(&f, second), -range, range, steps}},
                                .has_point = true,
                                .point_name = "P",
                                .figures = &out->figures};
  if (km_model_find_frame(f.model, (const char *const[]){body, "P"}, 2, &out->def.frame, NULL))
    fail_msg("no frame %s/P", body);
}

static void end(mapped *of) {
  km_clearance_free(of->clearance);
  fixture_close(&of->f);
}

/* Mechanism number i: with a point, with redundant constraints, with a rod that can spin, with limits and clearance. */
enum { MECHANISMS = 4 };
static void mechanism(mapped *out, int i) {
  if (i == 0)
    begin(out, fixture_open("five_bar"), "A", "E", M_PI, 24, "rod1");
  else
    begin(out, fixture_read(i == 1 ? redundant : i == 2 ? spun : with_post), "A", "E", i == 1 ? M_PI : 1.5, 20, "b2");
  if (i == 3) {
    km_error error;
    out->def.within_limits = true;
    out->def.least_clearance = 0.01;
    km_poses_compute(out->f.mechanism, out->f.state);
    if (km_clearance_create(out->f.mechanism, out->f.state, NULL, 0, &out->clearance, &error))
      fail_msg("%s", error.text);
    out->def.clearance = out->clearance;
  }
}

static const char *store_path(char out[64]) {
  snprintf(out, 64, "test_map_store.%d.sqlite", (int)getpid());
  unlink(out);
  return out;
}

/* Computes the map, with a store unless `path` is NULL. */
static km_status compute(mapped *of, const char *path, km_progress progress, void *context, km_space_map *map,
                         km_error *error) {
  const fixture *f = &of->f;
  km_all_modes modes = {0};
  km_space_map_def def = of->def;
  *map = (km_space_map){0};
  km_status status = path ? km_map_store_open(path, f->mechanism, f->state, &def, 1, false, &def.store, error) : KM_OK;
  if (!status)
    status = km_space_map_find(f->mechanism, f->state, &def, 1, progress, context, &modes, map, error);
  km_all_modes_free(&modes);
  km_map_store_free(def.store);
  return status;
}

/* Computes the map with an empty store. */
static void fill_store(mapped *of, char path[64]) {
  km_space_map map;
  km_error error;
  store_path(path);
  assert_int_equal(compute(of, path, NULL, NULL, &map, &error), KM_OK);
  km_space_map_free(&map);
}

static void assert_same_table(const km_table *a, const km_table *b) {
  size_t rows = km_table_rows(a), width = km_table_columns(a);
  assert_int_equal(km_table_rows(b), rows);
  assert_int_equal(km_table_columns(b), width);
  for (size_t i = 0; i < rows; ++i)
    assert_memory_equal(km_table_row(a, i), km_table_row(b, i), width * sizeof(double));
}

static void assert_same_map(const km_space_map *a, const km_space_map *b) {
  assert_same_table(a->cells, b->cells);
  assert_same_table(a->curves, b->curves);
  if (a->boundary)
    assert_same_table(a->boundary, b->boundary);
  assert_int_equal(a->sheet_count, b->sheet_count);
  assert_int_equal(a->aspect_count, b->aspect_count);
  assert_int_equal(a->curve_count, b->curve_count);
  assert_int_equal(a->hole_count, b->hole_count);
  assert_memory_equal(&a->workspace_area, &b->workspace_area, sizeof a->workspace_area);
  assert_int_equal(a->workspace_count, b->workspace_count);
  for (int i = 0; i < a->workspace_count; ++i) {
    assert_int_equal(a->workspaces[i].aspect, b->workspaces[i].aspect);
    assert_memory_equal(&a->workspaces[i].area, &b->workspaces[i].area, sizeof a->workspaces[i].area);
    assert_memory_equal(&a->workspaces[i].radius, &b->workspaces[i].radius, sizeof a->workspaces[i].radius);
  }
}

/* Reports so far, and the one that ends the run: by false, or by SIGKILL. */
typedef struct stop {
  int calls, last;
  bool is_kill;
} stop;

static bool stop_at(void *context, double done) {
  stop *s = context;
  (void)done;
  if (++s->calls != s->last)
    return s->calls < s->last;
  if (s->is_kill)
    raise(SIGKILL);
  return false;
}

/* The map without a store; *reports: of its progress. */
static km_space_map reference(mapped *of, int *reports) {
  km_space_map map;
  km_error error;
  stop never = {.last = INT_MAX};
  if (compute(of, NULL, stop_at, &never, &map, &error))
    fail_msg("%s", error.text);
  *reports = never.calls;
  return map;
}

/* One store, whose runs are stopped at one place after the other. */
static void stopped_runs_go_on(void **state) {
  (void)state;
  for (int i = 0; i < MECHANISMS; ++i) {
    mapped of;
    mechanism(&of, i);
    char path[64];
    km_error error;
    int reports;
    km_space_map expected = reference(&of, &reports), map;
    assert_true(km_table_rows(expected.cells) > 100 && reports > STOPS);
    store_path(path);
    for (int k = 0; k < STOPS; ++k) { /* a run without the search for modes has fewer reports */
      stop at = {.last = 1 + (reports - 1) * k / STOPS};
      km_status status = compute(&of, path, stop_at, &at, &map, &error);
      assert_true(status == KM_CANCELLED || (k > STOPS / 2 && !status));
      km_space_map_free(&map);
    }
    for (int k = 0; k < 2; ++k) {
      int before = of.asked;
      if (compute(&of, path, NULL, NULL, &map, &error))
        fail_msg("%s", error.text);
      assert_same_map(&expected, &map);
      assert_true(k == 0 || (of.asked - before <= RUNS && before > 10 * RUNS));
      km_space_map_free(&map);
    }
    km_space_map_free(&expected);
    unlink(path);
    end(&of);
  }
}

/* Runs the map in another process until SIGKILL ends it: it kills itself at its `last` report; if that is INT_MAX, this
 * process kills it after `microseconds`. */
static void kill_run(mapped *of, const char *path, int last, unsigned microseconds) {
  pid_t run = fork();
  assert_true(run >= 0);
  if (run == 0) {
    stop at = {.last = last, .is_kill = true};
    km_space_map map;
    for (;;)
      compute(of, path, stop_at, &at, &map, NULL);
  }
  if (last == INT_MAX) {
    usleep(microseconds);
    kill(run, SIGKILL);
  }
  int ended;
  assert_int_equal(waitpid(run, &ended, 0), run);
  assert_true(WIFSIGNALED(ended) && WTERMSIG(ended) == SIGKILL);
}

static void killed_runs_go_on(void **state) {
  (void)state;
  for (int i = 0; i < MECHANISMS; i += 2) {
    mapped of;
    mechanism(&of, i);
    char path[64];
    km_error error;
    int reports;
    km_space_map expected = reference(&of, &reports), map;
    store_path(path);
    for (int k = 1; k <= KILLS; ++k) {
      kill_run(&of, path, 1 + (reports - 1) * k / KILLS, 0);
      kill_run(&of, path, INT_MAX, 40000u * (unsigned)k);
    }
    if (compute(&of, path, NULL, NULL, &map, &error))
      fail_msg("%s", error.text);
    assert_same_map(&expected, &map);
    km_space_map_free(&map);
    km_space_map_free(&expected);
    unlink(path);
    end(&of);
  }
}

/* The store of another map is refused, unless it is replaced; the refused run leaves it as it was. */
static void other_maps_are_refused(void **state) {
  (void)state;
  mapped of, other;
  char path[64];
  km_error error;
  km_space_map map;
  mechanism(&of, 1);
  fill_store(&of, path);
  for (int change = 0; change < 6; ++change) {
    mechanism(&other, change == 0 ? 2 : 1);
    if (change == 1)
      ++other.def.axis[1].steps;
    if (change == 2)
      other.def.axis[0].to += 1e-15;
    if (change == 3)
      other.def.own_sheet = true;
    if (change == 4)
      other.name = "fourth";
    if (change == 5)
      other.f.state->q[0] += 1e-15;
    assert_int_equal(compute(&other, path, NULL, NULL, &map, &error), KM_USAGE);
    assert_non_null(strstr(error.text, "the store holds the results of another map: the model"));
    end(&other);
  }
  int before = of.asked;
  assert_int_equal(compute(&of, path, NULL, NULL, &map, &error), KM_OK);
  assert_true(of.asked - before <= RUNS);
  km_space_map_free(&map);
  unlink(path);
  end(&of);
}

static void run_sql(const char *path, const char *sql) {
  sqlite3 *db;
  assert_int_equal(sqlite3_open(path, &db), SQLITE_OK);
  assert_int_equal(sqlite3_exec(db, sql, NULL, NULL, NULL), SQLITE_OK);
  sqlite3_close(db);
}

/* A piece that isn't what was written ends the map with a message. */
static void damaged_pieces_are_refused(void **state) {
  (void)state;
  static const char *const damages[] = {"UPDATE pieces SET results = zeroblob(length(results)) WHERE number = 3",
                                        "UPDATE pieces SET hash = '' WHERE number = 0",
                                        "UPDATE pieces SET results = (SELECT results FROM pieces WHERE number = 0), "
                                        "hash = (SELECT hash FROM pieces WHERE number = 0) WHERE number = 2"};
  for (size_t i = 0; i < sizeof damages / sizeof *damages; ++i) {
    mapped of;
    char path[64];
    km_error error;
    km_space_map map;
    mechanism(&of, 0);
    fill_store(&of, path);
    run_sql(path, damages[i]);
    assert_int_equal(compute(&of, path, NULL, NULL, &map, &error), KM_IO);
    assert_non_null(strstr(error.text, "the store is damaged (piece "));
    km_space_map_free(&map);
    unlink(path);
    end(&of);
  }
}

/* A store begins with the modes of its map, and is used for one map. */
static void stores_have_their_modes(void **state) {
  (void)state;
  mapped of;
  const fixture *f = &of.f;
  char path[64];
  km_error error;
  km_all_modes modes;
  km_space_map map;
  mechanism(&of, 0);
  km_space_map_def def = of.def;
  fill_store(&of, path);
  assert_int_equal(km_map_store_open(path, f->mechanism, f->state, &def, 1, false, &def.store, &error), KM_OK);
  assert_int_equal(km_map_modes_find(f->mechanism, f->state, def.axis[0].coordinate, def.axis[1].coordinate, 1, NULL,
                                     NULL, &modes, &error),
                   KM_OK);
  modes.coordinates[f->mechanism->coordinate_count] += 0.1;
  assert_int_equal(km_space_map_compute(f->mechanism, f->state, &def, &modes, NULL, NULL, &map, &error), KM_USAGE);
  assert_non_null(strstr(error.text, "from other assembly modes"));
  km_space_map_free(&map);
  modes.coordinates[f->mechanism->coordinate_count] -= 0.1;
  modes.count = 1;
  assert_int_equal(km_space_map_compute(f->mechanism, f->state, &def, &modes, NULL, NULL, &map, &error), KM_USAGE);
  assert_non_null(strstr(error.text, "has been used"));
  km_space_map_free(&map);
  km_all_modes_free(&modes);
  km_map_store_free(def.store);
  unlink(path);
  end(&of);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(stopped_runs_go_on),      cmocka_unit_test(killed_runs_go_on),
      cmocka_unit_test(other_maps_are_refused),  cmocka_unit_test(damaged_pieces_are_refused),
      cmocka_unit_test(stores_have_their_modes),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
