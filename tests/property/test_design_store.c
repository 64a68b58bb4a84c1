/* The store of a study: stored designs aren't evaluated again, whatever ended the run that stored them. */
#include "support/designs.h"

#include <math.h>
#include <sqlite3.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

static const char *store_path(char out[64]) {
  snprintf(out, 64, "test_design_store.%d.sqlite", (int)getpid());
  unlink(out);
  return out;
}

static void a_store_is_asked_first(void **state) {
  (void)state;
  char path[64];
  designs d;
  store_path(path);
  designs_of_cranks(&d, 40);
  km_design_study *s = designs_run(&d, path, 1);
  km_design_result first = designs_result(s, 17);
  assert_int_equal(km_design_study_computed(s), 40);
  km_design_study_free(s);
  s = designs_run(&d, path, 1);
  assert_int_equal(km_design_study_computed(s), 0);
  assert_int_equal(km_design_study_found(s), 40);
  km_design_study_free(s);
  d.sample.count = 60; /* it grows */
  s = designs_run(&d, path, 2);
  assert_int_equal(km_design_study_computed(s), 20);
  km_design_result again = designs_result(s, 17);
  assert_memory_equal(&first, &again, sizeof first);
  km_design_study_free(s);
  d.figures[1].kind = KM_DESIGN_MAX; /* another question */
  s = designs_run(&d, path, 1);
  assert_int_equal(km_design_study_computed(s), 60);
  km_design_study_free(s);
  d.figures[1].low = 0.1; /* limits change no answer */
  s = designs_run(&d, path, 1);
  assert_int_equal(km_design_study_computed(s), 0);
  km_design_study_free(s);
  unlink(path);
}

/* A study in memory gives what one in a file gives: figures, outcomes and reasons. Its hash table grows several
 * times over so many designs. */
static void in_memory_as_in_a_file(void **state) {
  (void)state;
  enum { COUNT = 500 };
  char path[64];
  designs d;
  store_path(path);
  designs_of_cranks(&d, COUNT);
  km_design_study *memory = designs_run(&d, NULL, 2), *file = designs_run(&d, path, 1);
  int done = 0;
  assert_int_equal(km_design_study_computed(memory), COUNT);
  for (int i = 0; i < COUNT; ++i) {
    km_design_result a = designs_result(memory, i), b = designs_result(file, i);
    assert_int_equal(a.outcome, b.outcome);
    assert_string_equal(a.reason, b.reason);
    assert_memory_equal(a.figures, b.figures, sizeof a.figures);
    done += a.outcome == KM_DESIGN_DONE;
  }
  assert_true(done > 0 && done < COUNT);
  km_design_study_free(memory);
  km_design_study_free(file);
  unlink(path);
}

static void a_store_has_one_study_and_one_user(void **state) {
  (void)state;
  char path[64];
  designs d;
  km_design_study *s, *second;
  km_error error;
  store_path(path);
  designs_of_cranks(&d, 4);
  s = designs_run(&d, path, 1);
  assert_int_equal(km_design_study_open(&d.def, path, false, &second, &error), KM_IO);
  assert_non_null(strstr(error.text, "another run is using this store"));
  km_design_study_free(s);
  d.parameters[1].path = "slider_crank.rod.end.y";
  assert_int_equal(km_design_study_open(&d.def, path, false, &second, &error), KM_USAGE);
  assert_non_null(strstr(error.text, "another study"));
  assert_int_equal(km_design_study_open(&d.def, path, true, &second, &error), KM_OK);
  km_design_study_free(second);
  assert_int_equal(km_design_study_open(&d.def, "/no/such/folder/a.sqlite", false, &second, &error), KM_IO);
  assert_int_equal(km_design_study_open(&d.def, "/dev/null", false, &second, &error), KM_IO);
  unlink(path);
}

/* A database of another program is unchanged. */
static void a_database_of_others_is_no_store(void **state) {
  (void)state;
  char path[64];
  designs d;
  km_design_study *s;
  km_error error;
  sqlite3 *db;
  store_path(path);
  designs_of_cranks(&d, 4);
  assert_int_equal(sqlite3_open(path, &db), SQLITE_OK);
  assert_int_equal(sqlite3_exec(db, "CREATE TABLE recipes(name TEXT)", NULL, NULL, NULL), SQLITE_OK);
  sqlite3_close(db);
  assert_int_equal(km_design_study_open(&d.def, path, true, &s, &error), KM_IO);
  assert_non_null(strstr(error.text, "this is a database, but no store of a study"));
  assert_int_equal(sqlite3_open(path, &db), SQLITE_OK);
  assert_int_equal(sqlite3_exec(db, "INSERT INTO recipes VALUES('bread')", NULL, NULL, NULL), SQLITE_OK);
  sqlite3_close(db);
  unlink(path);
}

static int ask_number(const char *path, const char *sql) {
  sqlite3 *db;
  sqlite3_stmt *statement;
  assert_int_equal(sqlite3_open(path, &db), SQLITE_OK);
  assert_int_equal(sqlite3_prepare_v2(db, sql, -1, &statement, NULL), SQLITE_OK);
  assert_int_equal(sqlite3_step(statement), SQLITE_ROW);
  int number = sqlite3_column_int(statement, 0);
  sqlite3_finalize(statement);
  sqlite3_close(db);
  return number;
}

static void earlier_versions_had_fewer_tables(void **state) {
  (void)state;
  char path[64];
  designs d;
  sqlite3 *db;
  store_path(path);
  designs_of_cranks(&d, 40);
  km_design_study_free(designs_run(&d, path, 1));
  assert_int_equal(sqlite3_open(path, &db), SQLITE_OK);
  assert_int_equal(sqlite3_exec(db, "DROP TABLE appended", NULL, NULL, NULL), SQLITE_OK);
  sqlite3_close(db);
  km_design_study *s = designs_run(&d, path, 1);
  assert_int_equal(km_design_study_found(s), 40);
  km_design_study_free(s);
  unlink(path);
}

static void write_text(const char *name, const char *text) {
  FILE *file = fopen(name, "w");
  assert_non_null(file);
  fputs(text, file);
  assert_int_equal(fclose(file), 0);
}

/* A tetrahedron whose edges along the axes are so long. */
static void write_solid(const char *name, double a) {
  static const int faces[4][3] = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  FILE *file = fopen(name, "w");
  assert_non_null(file);
  fputs("solid s\n", file);
  for (int f = 0; f < 4; ++f) {
    fputs("facet normal 0 0 0\nouter loop\n", file);
    for (int k = 0; k < 3; ++k)
      fprintf(file, "vertex %g %g %g\n", faces[f][k] == 1 ? a : 0.0, faces[f][k] == 2 ? a : 0.0,
              faces[f][k] == 3 ? a : 0.0);
    fputs("endloop\nendfacet\n", file);
  }
  fputs("endsolid s\n", file);
  assert_int_equal(fclose(file), 0);
}

/* The only figure of the model as it is; so many designs are computed for it. */
static double only_figure(designs *d, const char *store, int computed) {
  static const double none[1];
  static const km_design_variant variant = {.name = "as it is", .values = none};
  d->def.variants = &variant;
  d->def.variant_count = 1;
  km_design_study *s = designs_run(d, store, 1);
  assert_int_equal(km_design_study_computed(s), computed);
  double figure = designs_result(s, 0).figures[0];
  km_design_study_free(s);
  return figure;
}

/* The torque that holds a pendulum which a mesh weighs. */
static double holding_torque(const char *model, const char *store, int computed) {
  static const double steps = 4.0;
  designs d;
  designs_of_model(&d, "fourbar", "forces");
  d.def.model = model;
  static const char *const actuator[] = {"A"};
  designs_set_number(&d, "steps", &steps);
  d.options[d.questions[0].option_count++] =
      (km_design_option){.name = "actuators", .texts = actuator, .text_count = 1};
  designs_add_figure(&d, "most", KM_DESIGN_MAX, "f.A");
  return only_figure(&d, store, computed);
}

/* A mesh that has changed changes the answers: eight times the volume twice as far from the axis. */
static void a_mesh_belongs_to_the_answer(void **state) {
  (void)state;
  char path[64];
  store_path(path);
  write_text(
      "test_design_store.json",
      "{\"model_parameters\": {\"gravity\": [0, -9.81, 0]}, \"assemblies\": [{\"name\": \"a\", \"bodies\": "
      "[{\"name\": \"b\", \"definition\": [\"test_design_store.stl\"], \"density\": 1000}], \"joints\": [{\"name\": "
      "\"A\", \"type\": \"Rz\", \"body_frame_pairs\": [\"fixed\", \"b\"]}]}], \"analysis\": {\"sweep\": "
      "{\"joint\": \"A\", \"range\": [0, 6]}}}");
  write_solid("test_design_store.stl", 0.1);
  double before = holding_torque("test_design_store.json", path, 1);
  assert_near(holding_torque("test_design_store.json", path, 0), before, 0.0);
  write_solid("test_design_store.stl", 0.2);
  assert_near(holding_torque("test_design_store.json", path, 1), 16.0 * before, 1e-12 * before);
  unlink("test_design_store.stl");
  unlink("test_design_store.json");
  unlink(path);
}

/* Least clearance of a slide's body, a mesh without a mass. */
static double least_clearance(const char *model, const char *store, int computed) {
  static const double steps = 4.0;
  designs d;
  designs_of_model(&d, "fourbar", "clearance");
  d.def.model = model;
  designs_set_number(&d, "steps", &steps);
  designs_add_figure(&d, "least", KM_DESIGN_MIN, "clearance");
  return only_figure(&d, store, computed);
}

/* So does its shape where it weighs nothing: its corner at x = a slides by 0.1 towards a face at x = 0.9. */
static void a_shape_belongs_to_the_answer(void **state) {
  (void)state;
  char path[64];
  store_path(path);
  write_text("test_design_store.json",
             "{\"assemblies\": [{\"name\": \"a\", \"bodies\": [{\"name\": \"b\", \"definition\": "
             "[\"test_design_store.stl\"]}, {\"name\": \"wall\", \"shapes\": [{\"box\": [0.2, 2, 2], \"T\": [1, 0, "
             "0]}]}], \"joints\": [{\"name\": \"A\", \"type\": \"Tx\", \"body_frame_pairs\": [\"fixed\", \"b\"]}, "
             "{\"name\": \"W\", \"type\": \"rigid\", \"body_frame_pairs\": [\"fixed\", \"wall\"]}]}], "
             "\"analysis\": {\"sweep\": {\"joint\": \"A\", \"range\": [0, 0.1]}}}");
  for (int k = 1; k <= 2; ++k) {
    const double a = 0.1 * k;
    write_solid("test_design_store.stl", a);
    assert_near(least_clearance("test_design_store.json", path, 1), 0.9 - a - 0.1, 1e-12);
    assert_near(least_clearance("test_design_store.json", path, 0), 0.9 - a - 0.1, 1e-12);
  }
  unlink("test_design_store.stl");
  unlink("test_design_store.json");
  unlink(path);
}

static void write_path(const char *name, double high) {
  FILE *file = fopen(name, "w");
  assert_non_null(file);
  fputs("x,y,z,qw,qx,qy,qz\n", file);
  for (int i = 0; i < 9; ++i)
    fprintf(file, "0.35,%.17g,%.17g,0,1,0,0\n", 0.01 * i, high);
  assert_int_equal(fclose(file), 0);
}

static double tracked_margin(const char *store, int computed) {
  static const char *const study[] = {"test_design_store.json"}, *const method[] = {"greedy"};
  designs d;
  designs_of_model(&d, "panda", "track");
  d.options[d.questions[0].option_count++] = (km_design_option){.name = "study", .texts = study, .text_count = 1};
  d.options[d.questions[0].option_count++] = (km_design_option){.name = "method", .texts = method, .text_count = 1};
  designs_add_figure(&d, "margin", KM_DESIGN_MIN, "limit_margin");
  return only_figure(&d, store, computed);
}

/* So does the table of poses that a path study names. */
static void a_table_of_poses_belongs_to_the_answer(void **state) {
  (void)state;
  char path[64];
  store_path(path);
  write_text("test_design_store.json",
             "{\"model\": \"" MODELS_DIR "/panda.json\", \"effector\": [\"flange\", \"tool\"], \"path\": {\"csv\": "
             "\"test_design_store.csv\"}}");
  write_path("test_design_store.csv", 0.45);
  double before = tracked_margin(path, 1);
  tracked_margin(path, 0);
  write_path("test_design_store.csv", 0.4);
  assert_true(fabs(tracked_margin(path, 1) - before) > 1e-3);
  unlink("test_design_store.csv");
  unlink("test_design_store.json");
  unlink(path);
}

/* A damaged answer in a store is not used: the design is evaluated again. */
static void damaged_answers_are_asked_again(void **state) {
  (void)state;
  static const char *const damage[] = {"outcome = -5",
                                       "outcome = 99",
                                       "outcome = 1000000",
                                       "outcome = 6",
                                       "outcome = 'done'",
                                       "outcome = 0.5",
                                       "figures = x'00'",
                                       "figures = zeroblob(8000)",
                                       "figures = hex(zeroblob(8))"};
  for (size_t i = 0; i < sizeof damage / sizeof *damage; ++i) {
    char path[64], sql[80];
    designs d;
    sqlite3 *db;
    km_design_study *s;
    store_path(path);
    designs_of_cranks(&d, 8);
    km_design_study_free(designs_run(&d, path, 1));
    snprintf(sql, sizeof sql, "UPDATE results SET %s", damage[i]);
    assert_int_equal(sqlite3_open(path, &db), SQLITE_OK);
    assert_int_equal(sqlite3_exec(db, sql, NULL, NULL, NULL), SQLITE_OK);
    sqlite3_close(db);
    assert_int_equal(km_design_study_open(&d.def, path, false, &s, NULL), KM_OK);
    assert_int_equal(km_design_study_lookup(s, NULL), KM_OK);
    assert_false(km_design_study_is_complete(s));
    for (int design = 0; design < 8; ++design) {
      km_design_result r = designs_result(s, design);
      assert_int_equal(r.outcome, KM_DESIGN_MISSING);
      assert_true(isnan(r.figures[0]));
    }
    km_design_study_free(s);
    s = designs_run(&d, path, 1);
    assert_int_equal(km_design_study_computed(s), 8);
    assert_true(km_design_study_is_complete(s));
    km_design_study_free(s);
    unlink(path);
  }
}

static void change(const char *path, const char *sql) {
  sqlite3 *db;
  assert_int_equal(sqlite3_open(path, &db), SQLITE_OK);
  assert_int_equal(sqlite3_exec(db, sql, NULL, NULL, NULL), SQLITE_OK);
  sqlite3_close(db);
}

static km_status turned(void *context, const double *x, double *f, km_error *error) {
  (void)context, (void)error;
  for (int i = 0; i < 4; ++i)
    f[i] = x[i] - 2.0 * x[(i + 1) % 4];
  return KM_OK;
}

static void sample_of_turned(designs *d, int count) {
  designs_of_function(d, turned, 4, 4);
  for (int p = 0; p < 4; ++p)
    d->spreads[p] = (km_design_spread){p, KM_UNIFORM, .low = -1.0, .high = 1.0};
  d->sample = (km_design_sample){.count = count, .seed = 1, .spreads = d->spreads, .spread_count = 4};
  d->def.sample = &d->sample;
}

static void assert_turned(const km_design_study *s, int count) {
  for (int i = 0; i < count; ++i) {
    double x[4], f[4];
    km_design_result r = designs_result(s, i);
    assert_int_equal(km_design_study_values(s, i, x, NULL), KM_OK);
    turned(NULL, x, f, NULL);
    assert_memory_equal(r.figures, f, sizeof f);
  }
}

/* Entries of 64 bytes: the buffer is sorted more than once. */
static void many_designs_are_sorted(void **state) {
  (void)state;
  enum { COUNT = 60000 };
  char path[64];
  designs d;
  store_path(path);
  sample_of_turned(&d, COUNT);
  km_design_study *s = designs_run(&d, path, 1);
  assert_int_equal(km_design_study_computed(s), COUNT);
  assert_turned(s, COUNT);
  km_design_study_free(s);
  assert_int_equal(ask_number(path, "SELECT count(*) FROM appended"), 0);
  s = designs_run(&d, path, 1);
  assert_int_equal(km_design_study_found(s), COUNT);
  km_design_study_free(s);
  unlink(path);
}

/* Long enough between batches for what was put to be made safe; then the process ends. */
static bool end_at_fourth_batch(void *context, double share) {
  int *batches = context;
  (void)share;
  usleep(150000);
  if (++*batches == 4)
    _exit(0);
  return true;
}

static void killed_runs_are_sorted_when_they_go_on(void **state) {
  (void)state;
  enum { COUNT = 2000 };
  char path[64];
  designs d;
  km_design_study *s;
  int batches = 0;
  store_path(path);
  sample_of_turned(&d, COUNT);
  pid_t run = fork();
  assert_true(run >= 0);
  if (run == 0) {
    if (km_design_study_open(&d.def, path, false, &s, NULL) == KM_OK)
      km_design_study_run(s, 1, end_at_fourth_batch, &batches, NULL);
    _exit(1);
  }
  int ended;
  assert_int_equal(waitpid(run, &ended, 0), run);
  assert_true(WIFEXITED(ended) && WEXITSTATUS(ended) == 0);
  int left = ask_number(path, "SELECT count(*) FROM appended");
  assert_true(left > 0 && left < COUNT);
  s = designs_run(&d, path, 1);
  assert_int_equal(km_design_study_found(s), left);
  assert_int_equal(km_design_study_computed(s), COUNT - left);
  assert_turned(s, COUNT);
  km_design_study_free(s);
  unlink(path);
}

/* Pages that are lost, at the end or in the middle, are seen when the store is opened. */
static void damaged_pages_are_seen(void **state) {
  (void)state;
  enum { COUNT = 2000, PAGE = 4096, PIECES = 8 };
  char path[64];
  designs d;
  int seen = 0;
  sample_of_turned(&d, COUNT);
  for (int piece = 0; piece < 2 * PIECES; ++piece) {
    static const char zeros[PAGE];
    km_design_study *s;
    km_error error;
    struct stat there;
    store_path(path);
    km_design_study_free(designs_run(&d, path, 1));
    assert_int_equal(stat(path, &there), 0);
    off_t pages = there.st_size / PAGE, at = (1 + (piece % PIECES) * (pages - 1) / PIECES) * PAGE;
    if (piece < PIECES) {
      assert_int_equal(truncate(path, at), 0);
    } else {
      FILE *file = fopen(path, "r+b");
      assert_true(file && fseek(file, at, SEEK_SET) == 0 && fwrite(zeros, PAGE, 1, file) == 1);
      fclose(file);
    }
    km_status status = km_design_study_open(&d.def, path, false, &s, &error);
    if (!status) /* a page that nothing uses */
      assert_turned(s, COUNT);
    else if (status != KM_IO || !strstr(error.text, "damaged"))
      fail_msg("piece %d, page %ld: %s", piece, (long)(at / PAGE), error.text);
    seen += status != KM_OK;
    km_design_study_free(s);
    unlink(path);
  }
  assert_true(seen >= PIECES);
}

/* An optimisation that is recalled from a store which lacks one of its answers ends there, and says so. */
static km_status bowl(void *context, const double *x, double *f, km_error *error) {
  (void)context, (void)error;
  f[0] = x[0] * x[0];
  return KM_OK;
}

static void optimisations_that_end_early_are_told(void **state) {
  (void)state;
  char path[64];
  designs d;
  km_design_study *s;
  store_path(path);
  designs_of_function(&d, bowl, 1, 1);
  d.variables[0] = (km_design_variable){0, -1.0, 1.5, nan("")};
  d.optimise = (km_design_optimise){.variables = d.variables,
                                    .variable_count = 1,
                                    .goals = {{"f0", false}},
                                    .goal_count = 1,
                                    .algorithm = km_design_algorithm(0),
                                    .evaluations = 200,
                                    .tolerance = 1e-3,
                                    .starts = 1,
                                    .seed = 1};
  d.def.optimise = &d.optimise;
  km_design_study_free(designs_run(&d, path, 1));
  for (int lost = 0; lost < 2; ++lost) {
    if (lost)
      change(path, "DELETE FROM results WHERE design = (SELECT max(design) FROM results)");
    assert_int_equal(km_design_study_open(&d.def, path, false, &s, NULL), KM_OK);
    assert_int_equal(km_design_study_lookup(s, NULL), KM_OK);
    assert_int_equal(km_design_study_is_complete(s), !lost);
    km_design_study_free(s);
  }
  unlink(path);
}

/* A user without write permission can read a complete store, also that of a killed run. */
static void stores_may_be_read_only(void **state) {
  (void)state;
  enum { COUNT = 50, NOBODY = 65534 };
  static const char *const before[] = {"SELECT 1", "DROP TABLE appended",
                                       "INSERT INTO appended SELECT * FROM results; DELETE FROM results"};
  char folder[] = "/tmp/kmech_store.XXXXXX", path[64];
  designs d;
  km_error error;
  assert_non_null(mkdtemp(folder));
  sample_of_turned(&d, COUNT);
  for (int i = 0; i < 3; ++i) {
    km_design_study *s;
    snprintf(path, sizeof path, "%s/a%%?#.sqlite", folder);
    chmod(folder, 0755);
    km_design_study_free(designs_run(&d, path, 1));
    change(path, before[i]);
    chmod(path, 0444);
    chmod(folder, 0555);
    uid_t user = geteuid();
    if (user == 0) /* root may write everywhere */
      assert_int_equal(seteuid(NOBODY), 0);
    if (km_design_study_open(&d.def, path, false, &s, &error))
      fail_msg("%s", error.text);
    assert_int_equal(km_design_study_lookup(s, &error), KM_OK);
    assert_true(km_design_study_is_complete(s));
    assert_turned(s, COUNT);
    assert_int_equal(km_design_study_run(s, 1, NULL, NULL, &error), KM_OK); /* everything is there */
    km_design_study_free(s);
    designs more = d;
    more.sample.count = COUNT + 1;
    more.def.sample = &more.sample;
    assert_int_equal(km_design_study_open(&more.def, path, false, &s, &error), KM_OK);
    assert_int_equal(km_design_study_lookup(s, &error), KM_OK);
    assert_false(km_design_study_is_complete(s));
    assert_int_equal(km_design_study_run(s, 1, NULL, NULL, &error), KM_IO);
    if (!strstr(error.text, "can't be written, only read"))
      fail_msg("%s", error.text);
    km_design_study_free(s);
    assert_int_equal(seteuid(user), 0);
    chmod(folder, 0755);
    unlink(path);
  }
  /* A part that waits in the log isn't passed over. */
  char log[80];
  km_design_study *s;
  km_design_study_free(designs_run(&d, path, 1));
  snprintf(log, sizeof log, "%s-wal", path);
  write_text(log, "something");
  chmod(path, 0444);
  chmod(folder, 0555);
  uid_t user = geteuid();
  if (user == 0)
    assert_int_equal(seteuid(NOBODY), 0);
  assert_int_equal(km_design_study_open(&d.def, path, false, &s, &error), KM_IO);
  assert_non_null(strstr(error.text, "a part of it waits in"));
  km_design_study_free(s);
  assert_int_equal(seteuid(user), 0);
  chmod(folder, 0755);
  unlink(log);
  unlink(path);
  rmdir(folder);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_store_is_asked_first),
      cmocka_unit_test(in_memory_as_in_a_file),
      cmocka_unit_test(a_store_has_one_study_and_one_user),
      cmocka_unit_test(a_database_of_others_is_no_store),
      cmocka_unit_test(earlier_versions_had_fewer_tables),
      cmocka_unit_test(a_mesh_belongs_to_the_answer),
      cmocka_unit_test(a_shape_belongs_to_the_answer),
      cmocka_unit_test(a_table_of_poses_belongs_to_the_answer),
      cmocka_unit_test(damaged_answers_are_asked_again),
      cmocka_unit_test(many_designs_are_sorted),
      cmocka_unit_test(killed_runs_are_sorted_when_they_go_on),
      cmocka_unit_test(damaged_pages_are_seen),
      cmocka_unit_test(optimisations_that_end_early_are_told),
      cmocka_unit_test(stores_may_be_read_only),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
