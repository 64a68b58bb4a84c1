/* The model of a session as JSON: all that the page needs to show it, but for the pose. */
#include "kview/messages.h"

#include "kmech/mechanism.h"
#include "kmech/model.h"
#include "kmech/statics.h"
#include "kmech/transfer.h"
#include "kmech/version.h"

#include <string.h>

static void add_assemblies(const km_model *m, km_text *out) {
  km_text_add(out, ",\"assemblies\":[");
  for (int a = 0; a < km_model_assembly_count(m); ++a) {
    kv_add_comma(out);
    km_text_add(out, "{\"name\":");
    kv_add_string(out, km_model_assembly_name(m, a));
    km_text_format(out, ",\"parent\":%d}", km_model_assembly_parent(m, a));
  }
  km_text_add(out, "]");
}

static void add_bodies(const km_model *m, km_text *out) {
  km_text_add(out, ",\"bodies\":[");
  for (int b = 0; b <= km_model_body_count(m); ++b) {
    double center[3], mass = km_model_body_mass(m, b, center);
    kv_add_comma(out);
    km_text_add(out, "{\"name\":");
    kv_add_string(out, km_model_body_name(m, b));
    km_text_format(out, ",\"assembly\":%d,\"patches\":%d,\"mass\":", km_model_body_assembly(m, b),
                   km_body_patch_count(m, b));
    kv_add_number(out, mass);
    km_text_add(out, ",\"center\":");
    kv_add_numbers(out, center, 3);
    km_text_add(out, "}");
  }
  km_text_add(out, "]");
}

/* `file`: where the file has it, if that is elsewhere. */
static void add_frames(const kv_session *s, km_text *out) {
  const km_model *m = s->model;
  km_text_add(out, ",\"frames\":[");
  for (int f = 0; f < km_model_frame_count(m); ++f) {
    double R[9], T[3];
    km_error error;
    if (km_model_frame_pose(m, f, R, T, &error))
      continue;
    kv_add_comma(out);
    km_text_add(out, "{\"name\":");
    kv_add_string(out, km_model_frame_name(m, f));
    km_text_format(out, ",\"body\":%d,\"R\":", km_model_frame_body(m, f));
    kv_add_numbers(out, R, 9);
    km_text_add(out, ",\"T\":");
    kv_add_numbers(out, T, 3);
    if (memcmp(T, s->file_places + 3 * f, sizeof T) != 0) {
      km_text_add(out, ",\"file\":");
      kv_add_numbers(out, s->file_places + 3 * f, 3);
    }
    km_text_add(out, "}");
  }
  km_text_add(out, "]");
}

static void add_joints(const km_model *m, km_text *out) {
  km_text_add(out, ",\"joints\":[");
  for (int j = 0; j < km_model_joint_count(m); ++j) {
    int first = 0, freedom = km_model_joint_freedom(m, j, &first);
    kv_add_comma(out);
    km_text_add(out, "{\"label\":");
    kv_add_string(out, km_model_joint_label(m, j));
    km_text_add(out, ",\"type\":");
    kv_add_string(out, km_joint_type_word((km_joint_type)km_model_joint_type(m, j)));
    km_text_format(out, ",\"frames\":[%d,%d],\"first\":%d,\"count\":%d}", km_model_joint_frame(m, j, false),
                   km_model_joint_frame(m, j, true), first, freedom);
  }
  km_text_add(out, "]");
}

/* The unit of a force or torque in a coordinate. */
static void add_push_unit(const km_model *m, int coordinate, km_text *out) {
  const km_port end = {.kind = KM_PORT_JOINT, .coordinate = coordinate};
  km_text unit = {0};
  km_push_unit(m, &end, &unit);
  kv_add_string(out, unit.data ? unit.data : "");
  out->failed = out->failed || unit.failed;
  km_text_free(&unit);
}

static void add_coordinates(const kv_session *s, km_text *out) {
  const km_model *m = s->model;
  km_text_add(out, ",\"coordinates\":[");
  for (int c = 0; c < km_model_coordinate_count(m); ++c) {
    double low, high;
    km_model_coordinate_limits(m, c, &low, &high);
    kv_add_comma(out);
    km_text_add(out, "{\"label\":");
    kv_add_string(out, km_model_coordinate_label(m, c));
    km_text_add(out, ",\"unit\":");
    kv_add_string(out, km_model_coordinate_unit(m, c));
    km_text_add(out, ",\"push\":");
    add_push_unit(m, c, out);
    km_text_format(out, ",\"joint\":%d,\"substructure\":%d,\"held\":%s,\"low\":", km_model_coordinate_joint(m, c),
                   km_coordinate_substructure(s->mechanism, c),
                   km_coordinate_is_held(s->mechanism, c) ? "true" : "false");
    kv_add_number(out, low);
    km_text_add(out, ",\"high\":");
    kv_add_number(out, high);
    km_text_add(out, "}");
  }
  km_text_add(out, "]");
}

static void add_substructures(const kv_session *s, km_text *out) {
  km_text_add(out, ",\"substructures\":[");
  for (int i = 0; i < km_substructure_count(s->mechanism); ++i) {
    km_substructure_mobility e;
    km_substructure_evidence(s->mechanism, s->state, i, &e);
    kv_add_comma(out);
    km_text_format(out, "{\"loops\":%d,\"rank\":%d,\"mobility\":%d,\"coordinates\":%d}", e.loops, e.rank, e.mobility,
                   e.coordinates);
  }
  km_text_add(out, "]");
}

static void add_end(const km_model *m, bool output, km_text *out) {
  km_port end;
  bool joint = km_port_default(m, output, &end) && end.kind == KM_PORT_JOINT;
  km_text_format(out, "%d", joint ? end.coordinate : -1);
}

/* Default analyses of the file. */
static void add_defaults(const km_model *m, km_text *out) {
  km_sweep_plan plan = km_sweep_plan_default(m);
  km_text_format(out, ",\"sweep\":{\"driver\":%d,\"from\":", plan.coordinate);
  kv_add_number(out, plan.from);
  km_text_add(out, ",\"to\":");
  kv_add_number(out, plan.to);
  km_text_format(out, ",\"steps\":%d,\"arclength\":", plan.steps);
  kv_add_number(out, plan.arclength);
  km_text_add(out, "},\"input\":");
  add_end(m, false, out);
  km_text_add(out, ",\"output\":");
  add_end(m, true, out);
  km_text_format(out, ",\"loads\":%d,\"actuators\":[", km_model_load_count(m));
  for (int i = 0; i < km_model_actuator_count(m); ++i) {
    kv_add_comma(out);
    km_text_format(out, "%d", km_model_actuator(m, i));
  }
  km_text_add(out, "],\"poses\":[");
  for (int i = 0; i < km_model_pose_count(m); ++i) {
    kv_add_comma(out);
    kv_add_string(out, km_model_pose_name(m, i));
  }
  km_text_add(out, "]");
}

static void add_questions(const kv_session *s, km_text *out) {
  km_text_add(out, ",\"questions\":[");
  for (int k = 0; kv_question_kind(s, k) >= 0; ++k) {
    kv_add_comma(out);
    kv_add_string(out, km_question_kind_name(kv_question_kind(s, k)));
  }
  km_text_add(out, "]");
}

static void add_parameters(const kv_session *s, km_text *out) {
  km_text_add(out, ",\"parameters\":[");
  for (int i = 0; i < s->parameters.count; ++i) {
    const kv_parameter *p = &s->parameters.items[i];
    kv_add_comma(out);
    km_text_add(out, "{\"name\":");
    kv_add_string(out, p->name);
    km_text_add(out, ",\"note\":");
    kv_add_string(out, p->note);
    km_text_add(out, ",\"value\":");
    kv_add_number(out, p->value);
    km_text_add(out, ",\"file\":");
    kv_add_number(out, p->file);
    km_text_add(out, ",\"low\":");
    kv_add_number(out, p->low);
    km_text_add(out, ",\"high\":");
    kv_add_number(out, p->high);
    km_text_add(out, "}");
  }
  km_text_add(out, "]");
}

static void add_notes(const kv_session *s, km_text *out) {
  km_text_add(out, ",\"notes\":[");
  for (size_t i = 0; i < km_messages_count(s->messages); ++i) {
    kv_add_comma(out);
    kv_add_string(out, km_messages_text(s->messages, i));
  }
  km_text_add(out, "]");
}

static const char *name_of(const char *path) {
  const char *slash = strrchr(path, '/');
  return slash ? slash + 1 : path;
}

void kv_describe(const kv_session *s, unsigned request, km_text *out) {
  const km_mobility *mobility = &s->mobility;
  km_length_source source;
  double normal[3], length = km_mechanism_characteristic_length(s->mechanism, &source);
  km_text_format(out, "{\"kind\":\"model\",\"request\":%u,\"protocol\":%d,\"version\":", request, KV_PROTOCOL);
  kv_add_string(out, KM_VERSION);
  km_text_add(out, ",\"name\":");
  kv_add_string(out, name_of(s->opening.path));
  km_text_add(out, ",\"meters\":");
  kv_add_number(out, km_model_length_unit(s->model));
  km_text_add(out, ",\"force\":");
  kv_add_string(out, km_model_units(s->model).force->suffix);
  km_text_add(out, ",\"length\":");
  kv_add_number(out, length);
  km_text_format(out, ",\"kutzbach\":%d,\"kutzbachPlanar\":%d,\"kutzbachExtended\":%d,\"redundant\":%d,\"edited\":%s",
                 mobility->kutzbach, mobility->kutzbach_planar, mobility->kutzbach_extended,
                 mobility->redundant_constraints, s->edited ? "true" : "false");
  if (km_mechanism_plane(s->mechanism, s->state, normal)) {
    km_text_add(out, ",\"normal\":");
    kv_add_numbers(out, normal, 3);
  }
  add_assemblies(s->model, out);
  add_bodies(s->model, out);
  add_frames(s, out);
  add_joints(s->model, out);
  add_coordinates(s, out);
  add_substructures(s, out);
  add_defaults(s->model, out);
  add_questions(s, out);
  add_parameters(s, out);
  add_notes(s, out);
  km_text_add(out, "}");
}
