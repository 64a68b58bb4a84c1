/* Opens a world of a linkage, of one whose state was never assembled, or of an arm on its path. */
#define _GNU_SOURCE /* mkdtemp */
#include "interface/world.h"

#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static int faults;
static char last[200];

static void need(km_status status, const km_error *error) {
  if (!status)
    return;
  fprintf(stderr, "%s\n", error->text);
  exit(1);
}

static void open_model(world *w, const char *file, km_model **model, km_mechanism **mechanism) {
  need(km_model_read_file(file, w->messages, model, &w->error), &w->error);
  need(km_mechanism_compile(*model, NULL, 0, mechanism, &w->error), &w->error);
}

static void open_study(world *w) {
  static char text[20000];
  FILE *file = fopen(STUDIES_DIR "/panda_circle/study.json", "r");
  size_t size = file ? fread(text, 1, sizeof text, file) : 0;
  if (file)
    fclose(file);
  need(km_study_read(text, size, STUDIES_DIR "/panda_circle", w->messages, &w->study_def, &w->error), &w->error);
  need(km_study_bind(w->mechanism, w->state, &w->study_def, 1, w->messages, &w->study, &w->error), &w->error);
  w->arm = km_study_arm(w->study);
  w->track_plan = km_study_plan(w->study, 0);
  w->track_plan.method = km_method_default(KM_GREEDY);
  km_path_pose(w->track_plan.path, 0, &w->pose);
  w->segment = km_path_segment_default(KM_PATH_LINE);
  w->path_plan = km_path_plan_default();
  w->path_plan.start = w->pose;
  w->path_plan.segments = &w->segment;
  w->path_plan.segment_count = 1;
  need(km_track_run(w->arm, &w->track_plan, &w->track, &w->error), &w->error);
  for (int k = 0; k < km_arm_coordinates(w->arm); ++k)
    w->numbers[k] = w->track_plan.start[k];
}

/* Objects that can't be created in this setting stay NULL, which is a further invalid value. */
static void open_handles(world *w) {
  int last_coordinate = km_model_coordinate_count(w->model) - 1;
  w->input = (km_port){.kind = KM_PORT_JOINT, .coordinate = 0, .name = "in"};
  w->output = (km_port){.kind = KM_PORT_JOINT, .coordinate = last_coordinate, .name = "out"};
  if (km_port_default(w->model, false, &w->input))
    km_port_default(w->model, true, &w->output);
  w->plan = km_sweep_plan_default(w->model);
  w->plan.steps = 3;
  if (w->plan.coordinate < 0)
    w->plan = (km_sweep_plan){.coordinate = 0, .to = 0.1, .steps = 3, .direction = -1, .sign = 1.0};
  km_forces_create(w->mechanism, NULL, NULL, 0, &w->forces, NULL);
  km_forces_create(w->mechanism, NULL, NULL, 0, &w->moving_forces, NULL);
  km_dynamics_create(w->mechanism, w->moving_forces, &w->dynamics, NULL);
  km_linearise(w->dynamics, w->state, &w->linear, NULL);
  w->simulation_def = km_simulation_default();
  w->history_def = km_history_default(w->model);
  w->rates[0] = (km_constant_rate){0, 0.1};
  w->all_modes_def = (km_all_modes_def){.seed = 1};
  w->one_mode = (km_all_modes){.count = 1, .coordinates = w->numbers};
  w->map_def = (km_space_map_def){{{0, -1.0, 1.0, 2}, {km_model_coordinate_count(w->model) - 1, -1.0, 1.0, 2}}};
  w->path_def = (km_space_path_def){.drivers = &w->path_driver, .driver_count = 1, .to = w->numbers};
  w->volume_def = (km_space_volume_def){.frame = 1, .point_name = "A", .samples = KM_MIN_VOLUME_SAMPLES};
  w->turning_def = (km_turning_def){.file = "missing.json", .path = "missing", .from = 0.0, .to = 1.0};
  w->inverse_def = (km_inverse_def){.rates = w->rates, .rate_count = 1, .until = 0.1, .steps = 2};
  w->history_def.until = 0.1;
  w->history_def.every = 0.05;
  km_simulation_create(w->dynamics, w->state, &w->simulation_def, &w->simulation, NULL);
  w->session_def = km_session_default(w->model);
  km_session_create(w->mechanism, w->state, &w->session_def, &w->session, NULL);
  km_statics_create(w->mechanism, NULL, 0, KM_AXES_JOINT, &w->statics, NULL);
  km_transfer_create(w->mechanism, &w->input, &w->output, &w->lever, NULL);
  km_losses_create(w->mechanism, &w->input, &w->output, &w->losses, NULL);
  km_transmission_create(w->mechanism, &w->input, &w->output, &w->transmission, NULL);
  km_driver_motion_create(w->mechanism, w->state, w->plan.coordinate, false, &w->drive, NULL);
  km_question_create(w->mechanism, "mobility", &w->question, NULL);
  km_arc_motion_create(w->mechanism, w->state, -1, 1.0, false, &w->follow, NULL);
  km_manipulation_create(w->mechanism, w->state, &w->hand, NULL);
  w->body_pairs[0] = (km_body_pair){.body = {1, 3}};
  km_poses_compute(w->mechanism, w->state);
  km_clearance_create(w->mechanism, w->state, w->body_pairs, 1, &w->clearance, NULL);
  km_map_store_open(":memory:", w->mechanism, w->state, &w->map_def, 1, false, &w->map_store, NULL);
  w->grip = (km_manipulation_point){.body = 1};
}

/* A builder with a body and a joint, and a definition of each kind. */
static void open_builder(world *w) {
  km_body_id body;
  need(km_builder_create(&w->builder, &w->error), &w->error);
  w->assignment = (km_assignment){"mass", 1.0};
  w->read_def = (km_read_def){0};
  w->settings = km_settings_default();
  w->frame = km_frame_default();
  w->body = km_body_default();
  w->shape = km_shape_default();
  w->shape.size[0] = 0.1;
  w->joint = km_joint_default();
  w->force = km_force_default();
  w->sweep_def = km_sweep_default();
  w->body.name = "first";
  need(km_model_add_body(w->builder, &w->body, &body, &w->error), &w->error);
  w->joint.name = "hinge";
  w->joint.parent = km_builder_origin(w->builder, km_builder_fixed(w->builder));
  w->joint.child = km_builder_origin(w->builder, body);
  need(km_model_add_joint(w->builder, &w->joint, NULL, &w->error), &w->error);
}

static km_status parabola(void *context, const double *values, double *figures, km_error *error) {
  (void)context, (void)error;
  figures[0] = values[0] * values[0];
  return KM_OK;
}

/* Workers without processes. */
static bool send_nothing(void *context, int member, const void *bytes, size_t size) {
  (void)context, (void)member, (void)bytes, (void)size;
  return false;
}

static int receive_nothing(void *context, bool wait, const void **bytes, size_t *size) {
  (void)context, (void)wait, (void)bytes, (void)size;
  return -1;
}

/* A study of a function, whose store is in memory. */
static void open_designs(world *w) {
  static const km_design_parameter parameter = {"x", "x"};
  static const double values[2] = {1.0, 2.0};
  static const km_design_variant variants[2] = {{"one", &values[0]}, {"two", &values[1]}};
  static const char *const bands[1] = {"none"};
  static km_design_question question = {.name = "parabola", .figure_count = 1, .bands = bands};
  w->crew = (km_design_workers){.send = send_nothing, .receive = receive_nothing};
  w->figure = km_design_figure_default();
  w->figure.name = "y";
  question.figures = &w->figure;
  w->designs_def = km_design_study_default();
  w->designs_def.function = parabola;
  w->designs_def.parameters = &parameter;
  w->designs_def.parameter_count = 1;
  w->designs_def.variants = variants;
  w->designs_def.variant_count = 2;
  w->designs_def.questions = &question;
  w->designs_def.question_count = 1;
  need(km_design_study_open(&w->designs_def, NULL, false, &w->designs, &w->error), &w->error);
}

/* Inputs of pictures. */
static void open_pictures(world *w) {
  w->answered = (km_answered){.question = w->question, .name = "model"};
  w->comparison = (km_comparison){&w->answered, 1, false};
  w->plotted = (km_plotted_table){w->table, "table", 0, w->columns};
  w->history_shown = (km_plotted_history){.mechanism = w->mechanism, .table = w->sweep.motion.table, .name = "model"};
  need(km_table_chart(&w->plotted, 1, 1, &w->chart, &w->error), &w->error);
  need(km_drawing_create(w->mechanism, &w->drawing, &w->error), &w->error);
  km_poses_compute(w->mechanism, w->state);
  need(km_drawing_add_pose(w->drawing, w->mechanism, w->state, &w->error), &w->error);
  w->page = (km_motion_page){.quantity = "way", .values = w->numbers, .seconds = 1.0};
  w->tracks = (km_tracks){w->study, "study", "model", &w->track, w->track ? 1 : 0};
}

void world_open(world *w, world_kind kind) {
  *w = (world){.names = {"fixed", "origin"}, .loads = {{.frame = 1, .force = {1, 0, 0}}}, .holds = {{0, 0.0}}};
  w->messages = km_messages_create();
  w->record = km_value_add(&w->arena, NULL, NULL, KM_OBJECT);
  w->nearest.wanted = "a";
  w->units = km_units_default();
  w->table = km_table_create();
  km_table_add_column(w->table, "a", "mm");
  km_table_add_row(w->table);
  w->objective = km_objective_of(KM_MANIPULABILITY);
  w->study_def = w->other_study_def = km_study_def_default();
  w->place = (km_study_place){"path", false};
  w->pose = (km_frame_pose){{1, 0, 0, 0, 1, 0, 0, 0, 1}, {0, 0, 0}};
  open_model(w, kind == WORLD_ARM ? MODELS_DIR "/panda.json" : MODELS_DIR "/brake.json", &w->model, &w->mechanism);
  open_model(w, MODELS_DIR "/stewart.json", &w->other_model, &w->other_mechanism);
  need(km_state_create(w->mechanism, &w->state, &w->error), &w->error);
  need(km_state_create(w->mechanism, &w->fresh, &w->error), &w->error);
  need(km_state_create(w->other_mechanism, &w->other_state, &w->error), &w->error);
  if (kind != WORLD_UNASSEMBLED) {
    km_mobility mobility;
    need(km_assemble(w->mechanism, w->state, NULL, &w->error), &w->error);
    km_mobility_compute(w->mechanism, w->state, &mobility);
  }
  if (kind == WORLD_ARM)
    open_study(w);
  open_handles(w);
  open_builder(w);
  open_designs(w);
  if (kind == WORLD_LOOPS)
    need(km_mobility_sweep_run(w->mechanism, w->state, &w->plan, &w->sweep, &w->error), &w->error);
  open_pictures(w);
}

void world_close(world *w) {
  km_chart_free(w->chart);
  km_drawing_free(w->drawing);
  km_mobility_sweep_free(&w->sweep);
  km_track_free(w->track);
  km_design_study_free(w->designs);
  km_design_study_def_free(&w->other_designs_def);
  km_study_free(w->study);
  km_study_def_free(&w->study_def);
  km_study_def_free(&w->other_study_def);
  km_builder_free(w->builder);
  km_question_free(w->question);
  km_driver_motion_free(w->drive);
  km_arc_motion_free(w->follow);
  km_manipulation_free(w->hand);
  km_clearance_free(w->clearance);
  km_map_store_free(w->map_store);
  km_transfer_free(w->lever);
  km_losses_free(w->losses);
  km_transmission_free(w->transmission);
  km_linear_free(&w->linear);
  km_simulation_free(w->simulation);
  km_session_free(w->session);
  km_dynamics_free(w->dynamics);
  km_forces_free(w->moving_forces);
  km_forces_free(w->forces);
  km_statics_free(&w->statics);
  km_state_free(w->state);
  km_state_free(w->fresh);
  km_state_free(w->other_state);
  km_mechanism_free(w->mechanism);
  km_mechanism_free(w->other_mechanism);
  km_model_free(w->model);
  km_text_free(&w->text);
  km_arena_free(&w->arena);
  km_model_free(w->other_model);
  km_table_free(w->table);
  km_messages_free(w->messages);
}

void world_begin(const char *function, const char *with) {
  int size = snprintf(last, sizeof last, "at %s with %s\n", function, with);
  alarm(60);
  if (getenv("KMECH_CALLS"))
    fwrite(last, 1, (size_t)size, stderr);
}

void world_refused(km_status status, const char *function, const char *with) {
  if (status != KM_OK)
    return;
  printf("%s with %s: expected a status, found KM_OK\n", function, with);
  ++faults;
}

static char folder[] = "/tmp/kmech-calls-XXXXXX";

void world_enter(void) {
  if (mkdtemp(folder) && chdir(folder) == 0)
    return;
  fputs("can't make a folder\n", stderr);
  exit(1);
}

void world_leave(void) {
  DIR *list = opendir(folder);
  for (struct dirent *entry = list ? readdir(list) : NULL; entry; entry = readdir(list))
    unlink(entry->d_name); /* folders among them stay, and are none of ours */
  if (list)
    closedir(list);
  rmdir(folder);
}

int world_faults(void) {
  return faults;
}
