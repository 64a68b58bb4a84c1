/* Labels of joints and coordinates. */
#include "base/text.h"
#include "model/validation.h"

typedef struct labeller {
  km_model *model;
  km_names *labels;
  km_messages *messages;
} labeller;

/* Recursion depth: the parser's nesting limit. */
static void add_assembly_path(const km_model *model, int assembly, km_text *text) {
  if (assembly == KM_NO_ASSEMBLY)
    return;
  add_assembly_path(model, model->assemblies[assembly].parent, text);
  km_text_format(text, "%s/", model->assemblies[assembly].name);
}

static const char *full_path(km_model *model, const km_model_joint *joint) {
  km_text text = {0};
  add_assembly_path(model, joint->assembly, &text);
  km_text_add(&text, joint->name);
  const char *label = text.failed ? NULL : km_arena_string(&model->arena, text.data);
  km_text_free(&text);
  return label;
}

/* Enters a label in a table; a second joint with the same label is an error. */
static void enter_label(labeller *l, int scope, const char *label, int index, int joint) {
  km_model *model = l->model;
  if (km_names_get(l->labels, scope, label) >= 0 && km_messages_errors(l->messages) == 0)
    km_messages_add(l->messages, KM_ERROR, "%s: the label \"%.80s\" is that of another joint; expected another name",
                    model->joints[joint].where, label);
  if (!km_names_set(l->labels, scope, label, index))
    model->arena.failed = true;
}

static void label_coordinates(labeller *l, int index) {
  km_model *model = l->model;
  const km_model_joint *joint = &model->joints[index];
  int freedom = km_model_freedom(model, index);
  for (int k = 0; k < freedom && !model->arena.failed; ++k) {
    km_text text = {0};
    km_text_format(&text, freedom == 1 ? "%s" : "%s[%d]", joint->label, k);
    int coordinate = joint->first_coordinate + k;
    const char *label = text.failed ? NULL : km_arena_string(&model->arena, text.data);
    km_text_free(&text);
    model->coordinates[coordinate].label = label;
    if (label)
      enter_label(l, KM_LABEL_COORDINATE, label, coordinate, index);
    else
      model->arena.failed = true;
  }
}

/* Creates the labels of a joint that differ from its name: a path, and those of several coordinates. */
static void reserve_labels(labeller *l, int index) {
  km_model *model = l->model;
  const km_model_joint *joint = &model->joints[index];
  int freedom = km_model_freedom(model, index);
  if (joint->label != joint->name && !km_names_set(l->labels, KM_LABEL_TAKEN, joint->label, index))
    model->arena.failed = true;
  for (int k = 0; k < freedom && freedom > 1; ++k) {
    km_text text = {0};
    km_text_format(&text, "%s[%d]", joint->label, k);
    const char *label = text.failed ? NULL : km_arena_string(&model->arena, text.data);
    km_text_free(&text);
    if (!label || !km_names_set(l->labels, KM_LABEL_TAKEN, label, index))
      model->arena.failed = true;
  }
}

/* The label of a joint is its name if no other joint has that name or label, otherwise its full path. */
void km_model_assign_labels(km_model *model, km_names *labels, km_messages *messages) {
  labeller own = {model, labels, messages}, *l = &own;
  for (int j = 0; j < model->joint_count; ++j) {
    int seen = km_names_get(l->labels, KM_LABEL_COUNT, model->joints[j].name);
    if (!km_names_set(l->labels, KM_LABEL_COUNT, model->joints[j].name, seen < 0 ? 1 : seen + 1))
      model->arena.failed = true;
  }
  for (int j = 0; j < model->joint_count && !model->arena.failed; ++j) {
    km_model_joint *joint = &model->joints[j];
    bool unique = km_names_get(l->labels, KM_LABEL_COUNT, joint->name) == 1;
    joint->label = unique ? joint->name : full_path(model, joint);
    if (joint->label)
      reserve_labels(l, j);
    else
      model->arena.failed = true;
  }
  for (int j = 0; j < model->joint_count && !model->arena.failed; ++j) {
    km_model_joint *joint = &model->joints[j];
    if (joint->label == joint->name && km_names_get(l->labels, KM_LABEL_TAKEN, joint->name) >= 0)
      joint->label = full_path(model, joint);
    if (!joint->label) {
      model->arena.failed = true;
      return;
    }
    enter_label(l, KM_LABEL_JOINT, joint->label, j, j);
    label_coordinates(l, j);
  }
}
