/* Checks of a model: suspicious units, masses, geometry, ranks, redundancies, limits, force laws. */
#include "base/number/tolerances.h"
#include "kmech/mobility.h"

#include "base/arguments.h"
#include "diagnosis/finding_texts.h"
#include "kinematics/body_poses.h"
#include "kmech/inspect.h"
#include "mobility/geometry_notes.h"
#include "mobility/massless_motions.h"
#include "mobility/mobility_numbers.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

struct km_findings_store {
  km_arena arena;
  size_t capacity;
  bool failed;
};

static void add_finding(km_findings *f, km_finding_severity severity, const char *kind, const char *advice,
                        const char *format, ...) __attribute__((format(printf, 5, 6)));

static void add_finding(km_findings *f, km_finding_severity severity, const char *kind, const char *advice,
                        const char *format, ...) {
  char text[KM_ERROR_TEXT];
  void *items = f->items;
  va_list arguments;
  va_start(arguments, format);
  vsnprintf(text, sizeof text, format, arguments);
  va_end(arguments);
  if (!km_reserve(&items, &f->store->capacity, f->count + 1, sizeof *f->items)) {
    f->store->failed = true;
    return;
  }
  f->items = items;
  const char *statement = km_arena_string(&f->store->arena, text),
             *stored_advice = km_arena_string(&f->store->arena, advice);
  f->store->failed = f->store->failed || f->store->arena.failed;
  f->counts[severity]++;
  f->items[f->count++] = (km_finding){severity, kind, statement ? statement : "", stored_advice ? stored_advice : ""};
}

static void check_reader(const km_model *model, const km_messages *messages, km_findings *f) {
  for (size_t i = 0; i < km_messages_count(messages); ++i) {
    const char *text = km_messages_text(messages, i);
    const bool is_rounding = strstr(text, "--idealise") != NULL && model->digits && model->digits[0];
    add_finding(f, km_messages_severity(messages, i) == KM_NOTE ? KM_FINDING_HINT : KM_FINDING_WARNING, "reader",
                is_rounding ? "write the numbers that are used into a file: kmob convert MODEL --idealise -o FILE"
                            : "correct the file, or remove what it doesn't need",
                "%s", text);
  }
}

/* Adds messages as findings of one kind, and frees them. */
static void add_messages(km_messages *messages, km_finding_severity severity, const char *kind, const char *advice,
                         km_findings *f) {
  for (size_t i = 0; i < km_messages_count(messages); ++i)
    add_finding(f, severity, kind, advice, "%s", km_messages_text(messages, i));
  f->store->failed = f->store->failed || !messages;
  km_messages_free(messages);
}

static void check_geometry(const km_mechanism *m, km_state *s, km_findings *f) {
  km_messages *offsets = km_messages_create(), *rigid = km_messages_create();
  km_pin_offset_notes(m, offsets);
  km_nearly_movable_notes(m, s, rigid);
  add_messages(offsets, KM_FINDING_HINT, "geometry",
               "harmless for the motion; move a frame along its axis to state one point", f);
  add_messages(rigid, KM_FINDING_HINT, "geometry",
               "compare its numbers with the drawing; kmob info MODEL --closure-tolerance X shows how it moves", f);
}

/* Moves a text into the findings' arena; "" without memory. */
static const char *keep_text(km_text *text, km_findings *f) {
  const char *words = km_text_move_to_arena(text, &f->store->arena);
  return words ? words : "";
}

/* Adds one hint per substructure for the redundancies that planar loops have by nature. */
static void check_planar(const km_mechanism *m, const km_redundancies *redundancies, km_findings *f) {
  for (int i = 0; i < m->topology.substructure_count; ++i) {
    int count = km_redundancies_out_of_plane(redundancies, i);
    if (count)
      add_finding(f, KM_FINDING_HINT, "redundant",
                  "harmless where parts are exact or soft; kmob info --verbose names them",
                  "%d constraint%s out of the plane of the planar loops of substructure %d %s redundant by nature",
                  count, count == 1 ? "" : "s", i + 1, count == 1 ? "is" : "are");
  }
}

static void check_redundancies(const km_mechanism *m, const km_redundancies *redundancies, km_findings *f) {
  for (int i = 0; i < redundancies->count; ++i) {
    const km_redundancy *r = &redundancies->items[i];
    if (r->out_of_plane)
      continue;
    km_text text = {0}, advice = {0};
    km_redundancy_statement(m, r, &text);
    if (r->remedy_count)
      km_text_format(&advice, "harmless where parts are exact or soft; else make joint %s %s",
                     m->model->joints[r->remedies[0].joint].label, r->remedies[0].to);
    else
      km_text_add(&advice, "harmless where parts are exact or soft; else loosen a joint of the loop");
    add_finding(f, KM_FINDING_HINT, "redundant", keep_text(&advice, f), "%s", keep_text(&text, f));
  }
}

static void check_passive(const km_mechanism *m, const km_passive_freedoms *passive, km_findings *f) {
  for (int i = 0; i < passive->count; ++i) {
    km_text text = {0};
    km_passive_freedom_statement(m, &passive->items[i], &text);
    add_finding(f, KM_FINDING_HINT, "idle", "harmless; a universal joint instead of a ball takes the freedom away",
                "%s", keep_text(&text, f));
  }
}

static void check_finite(const km_mobility *mobility, const km_finite_mobility *finite, km_findings *f) {
  int branches = 0, shaky = 0;
  for (int i = 0; i < finite->motion_count; ++i) {
    branches += finite->motions[i].kind == KM_MOTION_BRANCH;
    shaky += finite->motions[i].kind == KM_MOTION_SHAKY;
  }
  if (finite->undecided && finite->truncated)
    add_finding(f, KM_FINDING_WARNING, "undecided", "try a pose nearby (kmob at --set)",
                "the finite mobility is undecided: first order allows %d, and only some of its directions were tried",
                mobility->mobility);
  else if (finite->undecided)
    add_finding(
        f, KM_FINDING_WARNING, "undecided",
        "try a pose nearby (kmob at --set); for rounded data kmob convert --idealise, or a closure_tolerance",
        "the finite mobility is undecided: first order allows %d, and of some directions only a short way is confirmed",
        mobility->mobility);
  branches = branches ? km_finite_mobility_branches(finite) : 0;
  bool one = branches == 1 && !finite->truncated;
  if (shaky || one)
    add_finding(
        f, KM_FINDING_FAULT, "shaky",
        finite->mobility
            ? "change a length or an angle so that the parts don't line up, or hold the joint that shakes (--hold)"
            : "change a length or an angle so that the parts don't line up",
        "the %s shakes: first order allows mobility %d, but only %d is real",
        finite->mobility ? "mechanism" : "structure", mobility->mobility, finite->mobility);
  char number[16] = "several";
  if (!finite->truncated)
    snprintf(number, sizeof number, "%d", branches);
  if (branches && !one)
    add_finding(f, KM_FINDING_WARNING, "branch",
                "start from another pose, or follow one motion through it with kmob sweep --arclength",
                "the pose is a branch point: %s motions meet, mobility %d there", number, mobility->mobility);
}

static km_status check_ranks(const km_mechanism *m, km_state *s, km_findings *f, km_error *error) {
  km_messages *doubts = km_messages_create();
  km_status status = doubts ? km_rank_doubts(m, s, doubts, error) : KM_OK;
  add_messages(doubts, KM_FINDING_WARNING, "doubtful-rank",
               "compare with a pose nearby (kmob at --set); for rounded data try kmob convert --idealise, or state a "
               "closure_tolerance",
               f);
  return status;
}

static int by_size(const void *a, const void *b) {
  double x = *(const double *)a, y = *(const double *)b;
  return (x > y) - (x < y);
}

/* Warns of frames 300 times further from, or nearer to, their body's origin than most: some lengths are in another
 * unit. Distances at rounding level are ignored. */
static void check_lengths(const km_model *model, km_findings *f) {
  double *sizes = KM_ARENA_NEW(&f->store->arena, double, (size_t)model->frame_count);
  size_t count = 0;
  for (int i = 0; sizes && i < model->frame_count; ++i)
    if (model->frames[i].body != 0 && km_vec3_norm(model->frames[i].pose.p) > 0.0)
      sizes[count++] = km_vec3_norm(model->frames[i].pose.p);
  if (count < 2)
    return;
  qsort(sizes, count, sizeof *sizes, by_size);
  double middle = sizes[count / 2];
  for (int i = 0; i < model->frame_count; ++i) {
    double size = km_vec3_norm(model->frames[i].pose.p);
    if (model->frames[i].body != 0 && size > km_relative_zero * middle &&
        (size > 300.0 * middle || size < middle / 300.0))
      add_finding(f, KM_FINDING_WARNING, "units", "check its unit",
                  "frame %s of body %s is %.4g %s from its body's origin, where most are about %.2g",
                  model->frames[i].name, model->bodies[model->frames[i].body].name, size, model->units.length->suffix,
                  middle);
  }
}

/* True if an angle in radians looks like degrees: above 10 rad and, if the file states radians, a multiple of 5. */
static bool is_degrees(const km_model *model, double value) {
  bool round_number = fabs(value - 5.0 * round(value / 5.0)) < 1e-9;
  return isfinite(value) && fabs(value) > 10.0 && (round_number || model->angle_assumed);
}

/* Warns of the first value of a coordinate that looks like degrees; returns true if there is one. */
static bool check_angle(const km_model *model, int c, const double *values, int count, const char *what,
                        km_findings *f) {
  if (km_model_coordinate_is_length(model, c))
    return false;
  for (int k = 0; k < count; ++k)
    if (is_degrees(model, values[k])) {
      add_finding(f, KM_FINDING_WARNING, "angles", "write \"angle\": \"degrees\" in units, or the angle in radians",
                  "joint %s has %s of %g rad, which looks like degrees%s", model->coordinates[c].label, what, values[k],
                  model->angle_assumed ? "; the file states no unit of angles" : "");
      return true;
    }
  return false;
}

/* Warns of angles that look like degrees, of joints, sweeps, holds and named poses. */
static void check_angles(const km_model *model, km_findings *f) {
  if (model->units.angle->si != 1.0)
    return;
  for (int c = 0; c < model->coordinate_count; ++c) {
    const km_model_coordinate *def = &model->coordinates[c];
    const double values[3] = {def->position, def->low, def->high};
    bool is_reported = check_angle(model, c, values, 3, "an angle", f);
    if (!is_reported && model->sweep.coordinate == c && model->sweep.arclength == 0.0)
      is_reported = check_angle(model, c, model->sweep.range, 2, "a sweep to an angle", f);
    for (int h = 0; h < model->hold_count && !is_reported; ++h)
      is_reported =
          model->holds[h].coordinate == c && check_angle(model, c, &model->holds[h].value, 1, "a hold at an angle", f);
    for (int p = 0; p < model->pose_count && !is_reported; ++p)
      for (int k = 0; k < model->poses[p].count && !is_reported; ++k)
        is_reported = model->poses[p].coordinates[k] == c &&
                      check_angle(model, c, &model->poses[p].values[k], 1, "a named pose with an angle", f);
  }
}

/* Warns of a file without unit of length whose longest link, in metres, exceeds 20 m. */
static void check_length_unit(const km_mechanism *m, km_findings *f) {
  static const double longest_plausible = 20.0; /* m */
  if (m->model->length_assumed && m->length > longest_plausible)
    add_finding(f, KM_FINDING_WARNING, "units", "write \"length\": \"mm\", or the unit that is meant, in units",
                "the file states no unit of length, so that its lengths are metres, and the mechanism is %.4g m long",
                m->length);
}

static bool has_mass(const km_model *model) {
  bool found = false;
  for (int b = 1; b < model->body_count; ++b)
    found = found || model->bodies[b].mass > 0.0;
  return found;
}

/* Warns of gravity outside 0.5 … 50 m/s² (Moon 1.6, Jupiter 25), and of masses without gravity. */
static void check_gravity(const km_model *model, km_findings *f) {
  static const double least = 0.5, most = 50.0; /* m/s² */
  const km_units *u = &model->units;
  double unit = u->length->si / (u->time->si * u->time->si), size = km_vec3_norm(model->gravity);
  if (size > 0.0 && (size * unit < least || size * unit > most))
    add_finding(f, KM_FINDING_WARNING, "gravity", "write it in the model's units",
                "gravity is %.6g %s/%s², which is %.4g m/s²; the earth's is %.6g %s/%s²", size, u->length->suffix,
                u->time->suffix, size * unit, 9.80665 / unit, u->length->suffix, u->time->suffix);
  if (size == 0.0 && has_mass(model) && model->gravity_assumed)
    add_finding(f, KM_FINDING_WARNING, "gravity",
                "write \"gravity\" in model_parameters; [0, 0, 0] where none is meant",
                "bodies have masses, and the file states no gravity: they have no weight");
}

/* True if no body of the loop has a mass. */
static bool is_massless(const km_mechanism *m, int loop) {
  const km_topology *t = &m->topology;
  for (int i = t->member_start[loop]; i < t->member_start[loop + 1]; ++i)
    for (int end = 0; end < 2; ++end) {
      int body = km_joint_body(m->model, t->member[i].joint, end);
      if (body != 0 && m->model->bodies[body].mass > 0.0)
        return false;
    }
  return true;
}

/* Warns of massless loops in substructures that can move without moving any mass. */
static km_status check_masses(const km_mechanism *m, km_state *s, km_findings *f, km_error *error) {
  const km_topology *t = &m->topology;
  for (int i = 0; i < t->substructure_count && has_mass(m->model); ++i) {
    bool massless = false, is_massless_motion = false;
    for (int k = t->loop_start[i]; k < t->loop_start[i + 1]; ++k)
      massless = massless || is_massless(m, t->loop[k]);
    km_status status = massless ? km_has_massless_motion(m, s, i, &is_massless_motion, error) : KM_OK;
    if (status)
      return status;
    for (int k = t->loop_start[i]; k < t->loop_start[i + 1] && is_massless_motion; ++k)
      if (is_massless(m, t->loop[k]))
        add_finding(f, KM_FINDING_WARNING, "massless-loop", "give one of its bodies a mass before simulating",
                    "no body of loop %d, which is closed at joint %s, has a mass, while others have", t->loop[k] + 1,
                    m->model->joints[t->chord[t->loop[k]]].label);
  }
  return KM_OK;
}

/* True if a used frame has the same position in the body, such as a strut's end. */
static bool is_position_used(const km_model *model, const bool *used, int frame) {
  const km_model_frame *own = &model->frames[frame];
  for (int i = 0; i < model->frame_count; ++i)
    if (used[i] && model->frames[i].body == own->body &&
        km_vec3_norm(km_vec3_sub(model->frames[i].pose.p, own->pose.p)) == 0.0)
      return true;
  return false;
}

static void mark_module_port(const km_module_port *port, bool *used) {
  if (port->coordinate < 0)
    used[port->frame[0]] = true;
  if (port->coordinate == KM_MODULE_PORT_FRAMES)
    used[port->frame[1]] = true;
}

static void mark_port(const km_model_port *port, bool *used) {
  if (port->frame >= 0)
    used[port->frame] = true;
}

/* Marks the frames that the model uses. */
static void find_used(const km_model *model, bool *used) {
  for (int j = 0; j < model->joint_count; ++j)
    used[model->joints[j].frame[0]] = used[model->joints[j].frame[1]] = true;
  for (int i = 0; i < model->load_count; ++i)
    used[model->loads[i].frame] = true;
  for (int i = 0; i < model->module_count; ++i) {
    for (int k = 0; k < model->modules[i].input_count; ++k)
      mark_module_port(&model->modules[i].inputs[k].port, used);
    mark_module_port(&model->modules[i].output, used);
  }
  mark_port(&model->advantage_input, used);
  mark_port(&model->advantage_output, used);
}

static void check_frames(const km_model *model, km_findings *f) {
  bool *used = KM_ARENA_NEW(&f->store->arena, bool, (size_t)model->frame_count);
  if (used)
    find_used(model, used);
  for (int i = 0; used && i < model->frame_count; ++i)
    if (!used[i] && strcmp(model->frames[i].name, "origin") != 0 && !is_position_used(model, used, i))
      add_finding(f, KM_FINDING_HINT, "unused-frame", "keep it for --point or views, or remove it",
                  "frame %s of body %s is used by no joint, no load and no force module", model->frames[i].name,
                  model->bodies[model->frames[i].body].name);
}

static bool has_limits(const km_model *model, int joint) {
  bool limited = model->joints[joint].most_turn > 0.0;
  double low, high;
  for (int k = 0; k < km_model_freedom(model, joint); ++k)
    limited = km_model_coordinate_limits(model, model->joints[joint].first_coordinate + k, &low, &high) || limited;
  return limited;
}

/* Checks force laws: negative damping, stops without limits, friction without radius. */
static void check_laws(const km_model *model, km_findings *f) {
  for (int c = 0; c < model->coordinate_count; ++c)
    if (model->coordinates[c].damping < 0.0)
      add_finding(f, KM_FINDING_WARNING, "damping",
                  "write the damping as a positive number, or the drive as a force module",
                  "joint %s has a negative damping of %g, which gives it energy as it moves",
                  model->coordinates[c].label, model->coordinates[c].damping);
  for (int j = 0; j < model->joint_count; ++j) {
    const km_model_joint *joint = &model->joints[j];
    if ((joint->stop.stiffness > 0.0 || joint->stop.damping > 0.0) && !has_limits(model, j))
      add_finding(f, KM_FINDING_HINT, "stop", "give the joint limits, or remove the stop",
                  "joint %s has a stop but no limits, so the stop never acts", joint->label);
    if (km_model_next_without_radius(model, j) == j)
      add_finding(
          f, KM_FINDING_HINT, "friction", "give the radius at which its surfaces slide, or remove the coefficient",
          "joint %s has a coefficient of friction but no radius, so that it turns without friction", joint->label);
  }
}

static void check_ball_angle(const km_mechanism *m, const km_state *s, int c, km_findings *f) {
  const km_model_joint *joint = &m->model->joints[m->model->coordinates[c].joint];
  double excess = km_state_ball_excess(m, c, &s->q[c]), unit = m->model->units.angle->si;
  if (excess > 1e-9)
    add_finding(f, KM_FINDING_FAULT, "limits", "start inside the limits, or widen them",
                "joint %s starts turned by %.6g %s, past its limit of %g", joint->label,
                (excess + m->max_ball_angle[c]) / unit, km_model_coordinate_unit(m->model, c), joint->most_turn);
}

static void check_start(const km_mechanism *m, const km_state *s, km_findings *f) {
  const km_model *model = m->model;
  for (int c = 0; c < model->coordinate_count; ++c) {
    const km_model_coordinate *def = &model->coordinates[c];
    double q = km_state_coordinate(s, c), slack = 1e-9 * (1.0 + fabs(q));
    const char *unit = km_model_coordinate_unit(model, c);
    if (q < def->low - slack || q > def->high + slack)
      add_finding(f, KM_FINDING_FAULT, "limits", "start inside the limits, or widen them",
                  "joint %s starts at %.6g %s, outside its limits [%g, %g]", def->label, q, unit, def->low, def->high);
    check_ball_angle(m, s, c, f);
    if (!m->held[c] && fabs(s->q[c] - m->start[c]) > 1e-3 * m->unit[c])
      add_finding(f, KM_FINDING_WARNING, "start", "write the closed pose with kmob convert",
                  "joint %s is given at %.6g %s, but the loops close at %.6g %s", def->label, def->position, unit, q,
                  unit);
  }
}

static km_status run_checks(const km_mechanism *m, km_state *s, const km_messages *messages,
                            const km_diagnosis *diagnosis, km_findings *out, km_error *error) {
  km_mobility mobility;
  km_ranks_update(m, s, KM_BASIS_ANY, &mobility);
  check_reader(m->model, messages, out);
  check_start(m, s, out);
  check_geometry(m, s, out);
  check_finite(&mobility, &diagnosis->finite, out);
  km_status status = check_ranks(m, s, out, error);
  check_lengths(m->model, out);
  check_length_unit(m, out);
  check_angles(m->model, out);
  check_gravity(m->model, out);
  if (!status)
    status = check_masses(m, s, out, error);
  check_laws(m->model, out);
  check_frames(m->model, out);
  check_passive(m, &diagnosis->passive, out);
  check_planar(m, &diagnosis->redundancies, out);
  check_redundancies(m, &diagnosis->redundancies, out);
  bool failed = out->store->failed || out->store->arena.failed;
  return !status && failed ? km_fail(error, KM_MEMORY, "out of memory for the check") : status;
}

km_status km_check(const km_mechanism *m, km_state *s, const km_messages *messages, km_progress progress, void *context,
                   km_findings *out, km_error *error) {
  if (!out)
    return km_check_given(false, "place for the result", error);
  *out = (km_findings){0};
  km_diagnosis diagnosis;
  km_status status = km_diagnosis_find(m, s, progress, context, &diagnosis, error);
  if (!status) {
    out->store = KM_NEW(struct km_findings_store, 1);
    status = out->store ? run_checks(m, s, messages, &diagnosis, out, error)
                        : km_fail(error, KM_MEMORY, "out of memory for the check");
  }
  km_diagnosis_free(&diagnosis);
  return status;
}

void km_findings_leave_out(km_findings *f, const char *kind) {
  size_t keep_text = 0;
  for (size_t i = 0; f && kind && i < f->count; ++i) {
    bool is_kept = strcmp(f->items[i].kind, kind) != 0;
    f->counts[f->items[i].severity] -= !is_kept;
    f->items[keep_text] = f->items[i];
    keep_text += is_kept;
  }
  if (f && kind)
    f->count = keep_text;
}

void km_findings_free(km_findings *f) {
  if (!f)
    return;
  km_free(f->items);
  if (f->store)
    km_arena_free(&f->store->arena);
  km_free(f->store);
  *f = (km_findings){0};
}

const char *km_finding_severity_name(km_finding_severity severity) {
  static const char *const names[] = {"fault", "warning", "remark"};
  return (size_t)severity < sizeof names / sizeof *names ? names[severity] : "";
}
