/* kspace clearance: distances of bodies at a pose, or over a sweep. */
#include "common/sweep.h"
#include "kspace/kspace.h"

#include "kmech/clearance.h"
#include "kmech/report.h"

/* True if an option calls for a motion. */
static bool moves(const kt_sweep_options *o) {
  static const char *const names[] = {"joint", "range", "steps", "arclength", "direction", "cycle", "branch", "point"};
  bool given = o->models.count > 1 || o->vary.count > 0;
  for (size_t i = 0; i < sizeof names / sizeof *names; ++i)
    given = given || kt_question_given(&o->asked, names[i]);
  return given;
}

static kt_exit deliver(const kt_sweep_options *o, const kt_pose *pose, const km_clearance *clearance,
                       const km_pair_clearance *at) {
  const char *model = o->models.items[0];
  bool json = o->formats.wanted[KT_JSON];
  km_text out = {0};
  km_arena arena = {0};
  km_value *record = json ? km_clearance_record(pose->mechanism, clearance, at, model, &arena) : NULL;
  if (record)
    km_json_write(record, &out);
  else if (!json)
    km_clearance_print(pose->mechanism, clearance, at, model, &out);
  out.failed = out.failed || arena.failed;
  kt_exit result = out.failed ? KT_NO_MEMORY
                   : o->base  ? kt_write(&o->common, o->base, "clearance", json ? "json" : "txt", &out)
                              : kt_print(&o->common, &out);
  km_arena_free(&arena);
  km_text_free(&out);
  return result;
}

static kt_exit compute(const kt_sweep_options *o, const kt_pose *pose, km_arena *arena) {
  km_option_value between = {0};
  km_clearance *clearance = NULL;
  km_error error;
  kt_exit result = kt_question_read(&o->common, pose->model, &o->asked, "between", arena, &between);
  if (result != KT_DONE)
    return result;
  km_poses_compute(pose->mechanism, pose->state);
  km_status status =
      km_clearance_create(pose->mechanism, pose->state, between.pairs, between.count, &clearance, &error);
  km_pair_clearance *at = KM_ARENA_NEW(arena, km_pair_clearance, (size_t)km_clearance_pair_count(clearance) + 1);
  if (!status && at)
    status = km_clearance_compute(clearance, pose->state, at, NULL, &error);
  if (status)
    kt_print_message(&o->common, KM_ERROR, "%s: %s", o->models.items[0], error.text);
  result = status ? kt_exit_of(status) : at ? deliver(o, pose, clearance, at) : KT_NO_MEMORY;
  km_clearance_free(clearance);
  return result;
}

static kt_exit at_pose(kt_sweep_options *o) {
  kt_pose pose;
  km_arena arena = {0};
  if (o->format && !kt_formats_parse_among(&o->common, o->format, "json", &o->formats))
    return KT_USAGE;
  kt_exit result = kt_open(&o->common, o->models.items[0], &o->holds, &o->sets, &pose);
  if (result == KT_DONE)
    result = compute(o, &pose, &arena);
  kt_close(&pose);
  km_arena_free(&arena);
  return result;
}

kt_exit kspace_clearance(int argc, char **argv) {
  kt_sweep_options o = {.common = KT_COMMON("kspace")};
  kt_options all = {0};
  kt_sweep_options_several(&all, &o, "clearance", KT_SWEEP_BASE("clearance"));
  kt_options_read(
      &all,
      "The shortest distance between bodies by their shapes and meshes: at the pose, or with --joint, --range, --steps or "
      "--arclength over a motion, as a table with the places where bodies touch."
      "\vPairs that a joint connects, and pairs that overlap at the pose, are left out; --between takes any pair. A "
      "negative clearance is the depth of an overlap. Boxes, spheres, cylinders and capsules are exact; a mesh is the convex "
      "hulls of its connected parts, and the largest distance of a hull from its mesh is stated. Columns beside those of "
      "every sweep: clearance, the least one, and clearance.BODY/BODY. At the pose --format json lists pairs (bodies, "
      "clearance, error, points, normal), left_out and hulls.",
      argc, argv);
  return moves(&o) ? kt_sweep(&o) : at_pose(&o);
}
