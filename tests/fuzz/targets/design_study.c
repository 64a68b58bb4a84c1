/* A study of designs on the brake: read, checked, opened in memory, first design evaluated. */
#include "target.h"

#include "kmech/study.h"

#include <stdio.h>
#include <stdlib.h>

static char model[1 << 16];
static size_t model_size;

static void open_model(void) {
  FILE *file = fopen(MODELS_DIR "/brake.json", "r");
  model_size = file ? fread(model, 1, sizeof model, file) : 0;
  if (!model_size)
    fuzz_fail("the brake can't be read");
  fclose(file);
}

static void refused(km_status status, const km_error *error) {
  if (!error->text[0] || (status != KM_MODEL && status != KM_USAGE && status != KM_IO))
    fuzz_fail("a study is refused without words, or by a status that no study may give");
}

static void open_study(km_design_study_def *def) {
  km_design_study *study = NULL;
  km_error error = {0};
  double values[KM_MAX_DESIGN_PARAMETERS];
  def->model = NULL;
  def->bytes = model;
  def->size = model_size;
  def->folder = "/nowhere";
  km_status status = km_design_study_open(def, NULL, false, &study, &error);
  if (status)
    refused(status, &error);
  else if (km_design_study_designs(study) < 0)
    fuzz_fail("a study has less than no designs");
  else if (km_design_study_designs(study) > 0 && km_design_study_values(study, 0, values, &error))
    fuzz_fail("the first design has no values");
  km_design_study_free(study);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  if (!model_size)
    open_model();
  km_error error = {0};
  km_design_study_def def = km_design_study_default();
  km_messages *messages = km_messages_create();
  char *exact = fuzz_exact(data, size);
  if (!messages)
    exit(2);
  km_status status = km_design_study_read(exact, size, messages, &def, &error);
  if (status)
    refused(status, &error);
  else if (!def.sample_file)
    open_study(&def);
  km_design_study_def_free(&def);
  km_messages_free(messages);
  free(exact);
  return 0;
}
