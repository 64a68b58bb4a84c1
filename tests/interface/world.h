/* Arguments of the generated calls: one object of each kind that the library creates. */
#ifndef KM_TESTS_WORLD_H
#define KM_TESTS_WORLD_H

#include <kmech/kmech.h>

enum { WORLD_NUMBERS = 4096 };

typedef enum world_kind { WORLD_LOOPS, WORLD_UNASSEMBLED, WORLD_ARM, WORLD_KINDS } world_kind;

typedef struct world {
  km_model *model, *other_model;
  km_mechanism *mechanism, *other_mechanism;
  km_state *state, *fresh, *other_state;
  km_driver_motion *drive;
  km_arc_motion *follow;
  km_manipulation *hand;
  km_manipulation_point grip;
  km_transfer *lever;
  km_losses_workspace *losses;
  km_transmission_workspace *transmission;
  km_forces *forces, *moving_forces;
  km_dynamics *dynamics;
  km_simulation *simulation;
  km_session *session;
  km_session_def session_def;
  km_user_forces user_forces;
  km_linear linear;
  km_simulation_def simulation_def;
  km_history_def history_def;
  km_constant_rate rates[1];
  km_inverse_def inverse_def;
  km_all_modes_def all_modes_def;
  km_all_modes one_mode;
  km_space_map_def map_def;
  km_map_store *map_store;
  km_turning_def turning_def;
  km_space_path_def path_def;
  km_space_volume_def volume_def;
  km_space_map map;
  km_space_volume volume;
  km_map_look map_look;
  int path_driver;
  km_gallery_caption captions[400]; /* the most poses of a grid */
  km_statics statics;
  km_study_def study_def, other_study_def;
  km_study_place place;
  km_study *study;
  const km_arm *arm;
  km_track *track;
  km_table *table;
  km_question *question;
  km_design_study_def designs_def, other_designs_def;
  km_design_study *designs;
  km_design_figure figure;
  km_design_result result;
  km_evaluated_design asked;
  km_design_workers crew;
  km_option_value value;
  km_builder *builder;
  km_assignment assignment;
  km_read_def read_def;
  km_settings_def settings;
  km_frame_def frame;
  km_body_def body;
  km_joint_def joint;
  km_shape_def shape;
  km_coupling_def coupling;
  km_force_def force;
  km_load_def load;
  km_sweep_def sweep_def;
  km_end_def end;
  km_messages *messages;
  km_text text;
  km_units units;
  km_arena arena;
  km_value *record;
  km_nearest nearest;
  char buffer[KM_NEAREST_TEXT];
  km_mobility_sweep sweep;
  km_port input, output;
  km_sweep_plan plan;
  km_track_plan track_plan;
  km_path_plan path_plan;
  km_path_segment segment;
  km_frame_pose pose;
  km_objective objective;
  km_hold holds[2];
  km_load loads[1];
  km_answered answered;
  km_comparison comparison;
  km_plotted_table plotted;
  km_chart_words chart_words;
  km_plotted_history history_shown;
  size_t columns[3];
  km_chart *chart;
  km_drawing *drawing;
  km_drawing_look look;
  km_motion_page page;
  km_tracks tracks;
  km_selfmotion selfmotion;
  km_clearance *clearance;
  km_body_pair body_pairs[1];
  km_pair_clearance pair_clearance, pair_clearances[WORLD_NUMBERS];
  km_ik_solutions solutions;
  km_error error;
  const char *names[2];
  double numbers[WORLD_NUMBERS];
  bool marks[WORLD_NUMBERS];
} world;

void world_open(world *w, world_kind kind);
void world_close(world *w);

/* Says which call comes next, so that a crash has a name, and ends the test where one hangs. */
void world_begin(const char *function, const char *with);
/* A status of a call that had to be refused, or of one that may do. */
void world_refused(km_status status, const char *function, const char *with);
int world_faults(void);
/* A folder of its own for files that calls write, as the current one; and gone again. */
void world_enter(void);
void world_leave(void);

#endif
