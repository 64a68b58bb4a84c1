/* A path study, on the Panda: read, bound, and, where it is short, tracked by the greedy method. */
#include "target.h"

#include "kmech/arm.h"

#include <math.h>
#include <stdlib.h>

enum { MOST_STEPS = 60 };

static km_mechanism *mechanism;
static km_state *state;

static void open_arm(void) {
  km_model *model;
  km_error error;
  if (km_model_read_file(MODELS_DIR "/panda.json", NULL, &model, &error) ||
      km_mechanism_compile(model, NULL, 0, &mechanism, &error) || km_state_create(mechanism, &state, &error) ||
      km_assemble(mechanism, state, NULL, &error))
    fuzz_fail(error.text);
}

static int steps_of(const km_study_def *def) {
  int steps = 0;
  for (int i = 0; i < def->path.plan.segment_count && steps <= MOST_STEPS; ++i) {
    const km_path_segment *s = &def->path.plan.segments[i];
    steps += s->at_points ? s->point_count : s->steps;
    steps += s->point_count > MOST_STEPS ? MOST_STEPS + 1 : 0;
  }
  return steps;
}

/* A track has finite numbers, or says where it ends. */
static void check_track(km_track *track) {
  const km_table *table = km_track_rows(track);
  km_span q = km_table_span(table, "q.");
  for (size_t r = 0; r < km_table_rows(table); ++r)
    for (size_t c = 0; c < q.count; ++c)
      if (!isfinite(km_table_row(table, r)[q.first + c]))
        fuzz_fail("a joint of a track isn't finite");
  if (km_track_ending(track).stop == KM_TRACK_COMPLETE && km_table_rows(table) != (size_t)km_track_samples(track))
    fuzz_fail("a complete track has other rows than samples");
}

static void track(const km_study *study) {
  km_track_plan plan = km_study_plan(study, 0);
  km_track *made = NULL;
  km_error error = {0};
  plan.method = km_method_default(KM_GREEDY);
  if (!plan.path || km_study_start(study, NULL, NULL, NULL))
    return;
  km_status status = km_track_run(km_study_arm(study), &plan, &made, &error);
  if (made)
    check_track(made);
  else if (!status || !error.text[0])
    fuzz_fail("neither a track nor a reason");
  km_track_free(made);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  if (!mechanism)
    open_arm();
  km_error error = {0};
  km_study *study = NULL;
  km_study_def def = km_study_def_default();
  km_messages *messages = km_messages_create();
  char *exact = fuzz_exact(data, size);
  if (!messages)
    exit(2);
  km_status status = km_study_read(exact, size, "", messages, &def, &error);
  if (!status && steps_of(&def) <= MOST_STEPS)
    status = km_study_bind(mechanism, state, &def, 1, messages, &study, &error);
  if (status && (!error.text[0] || (status != KM_MODEL && status != KM_USAGE && status != KM_IO &&
                                    status != KM_NO_RESULT && status != KM_DIVERGED)))
    fuzz_fail("a study is refused without words, or by a status that no study may give");
  if (!status && study)
    track(study);
  km_study_free(study);
  km_study_def_free(&def);
  km_messages_free(messages);
  free(exact);
  return 0;
}
