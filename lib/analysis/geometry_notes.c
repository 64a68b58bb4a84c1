/* Notes about geometry that differs from what the file says without changing how the mechanism moves. */
#include "kmech/diagnosis.h"

#include "topology/mechanism.h"

static const double rounding =
    1e-6; /* of a substructure's size: offsets of this order come from the digits of a file */

/* The note about a loop whose ends are offset along its hinge axes. */
static void add_pin_offset(const km_mechanism *m, int index, km_messages *messages) {
  const km_loop *loop = &m->loops[index];
  const km_model *model = m->model;
  const km_topology *t = &m->topology;
  double size = m->substructures[t->substructure_of_loop[index]].size;
  if (!(fabs(loop->pin_offset) > rounding))
    return;
  int base = t->base[index];
  const km_member *member = &t->member[t->member_start[index]];
  const km_model_frame *frame = &model->frames[model->joints[member->joint].frame[member->against]];
  km_vec3 n = km_rotate(&frame->pose.R, loop->plane_normal);
  km_messages_add(
      messages, KM_NOTE,
      "loop %d: at %.80s its ends are %.4g %s apart along the hinge axes, direction (%.4g, %.4g, %.4g) of body %.80s; "
      "taken for one point, since a hinge's frames may lie anywhere along its axis",
      index + 1, model->joints[t->chord[index]].label, size * fabs(loop->pin_offset), model->units.length->suffix,
      n.x + 0.0, n.y + 0.0, n.z + 0.0, model->bodies[base].name);
}

void km_geometry_notes(const km_mechanism *m, km_messages *messages) {
  for (int l = 0; m && messages && l < m->topology.loop_count; ++l)
    add_pin_offset(m, l, messages);
}
