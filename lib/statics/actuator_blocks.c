/* Blocks of a static balance (theory 9.3): substructures and tree joints that the actuators move together, since a
 * pushed point can move several (union-find). */
#include "base/number/union_find.h"
#include "statics/statics.h"

/* Parts are the substructures, then the coordinates; tree joints are parts of their own. */
typedef struct part_groups {
  const km_mechanism *m;
  int *parent; /* [part] */
  int *size;   /* [part] members, at a representative */
  int *block;  /* [part] block, at a representative; -1: none */
  int first;   /* a part that the present point moves, -1: none */
} part_groups;

static int part_of(const km_mechanism *m, int coordinate) {
  int substructure = m->substructure_of[coordinate];
  return substructure >= 0 ? substructure : m->topology.substructure_count + coordinate;
}

static void unite_with_point(void *context, int coordinate, bool is_reversed) {
  part_groups *g = context;
  int part = km_set_root(g->parent, part_of(g->m, coordinate));
  (void)is_reversed;
  int other = g->first < 0 ? part : km_set_root(g->parent, g->first);
  g->first = part;
  if (other == part)
    return;
  g->parent[part] = other;
  g->size[other] += g->size[part];
}

static km_status unite_parts(part_groups *g, const km_statics *st, km_error *error) {
  for (int a = 0; a < st->actuator_count; ++a) {
    const km_port *point = &st->work->actuators[a];
    g->first = -1;
    if (point->kind != KM_PORT_POINT)
      continue;
    km_point_each_mover(g->m, point, unite_with_point, g);
    if (g->first < 0)
      return km_fail(error, KM_USAGE, "actuator %s can't move: nothing between it and the inertial frame is free",
                     point->name);
    st->work->column[a] = g->first;
  }
  return KM_OK;
}

/* Numbers the blocks: in the order of their first substructures, then those of tree joints. A single tree joint has
 * no block. */
static void number_blocks(part_groups *g, km_statics_workspace *w) {
  int substructures = g->m->topology.substructure_count;
  for (int part = 0; part < substructures + g->m->coordinate_count; ++part) {
    int coordinate = part - substructures, root = km_set_root(g->parent, part);
    bool is_block_part = part < substructures || (part_of(g->m, coordinate) == part && g->size[root] > 1);
    if (is_block_part && g->block[root] < 0)
      g->block[root] = w->block_count++;
  }
}

static int block_of(const part_groups *g, int part) {
  return g->block[km_set_root(g->parent, part)];
}

static void add_members(const part_groups *g, km_statics_workspace *w) {
  const km_mechanism *m = g->m;
  for (int i = 0; i < m->topology.substructure_count; ++i) {
    km_actuator_workspace *h = &w->blocks[block_of(g, i)];
    h->part[h->part_count++] = i;
    h->columns += m->substructures[i].columns;
  }
  for (int c = 0; c < m->coordinate_count; ++c) {
    int block = m->substructure_of[c] < 0 && !m->held[c] ? block_of(g, part_of(m, c)) : -1;
    if (block < 0)
      continue;
    km_actuator_workspace *h = &w->blocks[block];
    h->tree_joint[h->tree_joint_count++] = c;
    h->columns++;
    w->actuated[c] = true; /* the block determines its motion */
  }
}

/* Lists the columns of a block; if it is not a single substructure, its basis is composed. */
static void list_columns(const km_mechanism *m, km_actuator_workspace *h, km_arena *arena) {
  if (h->part_count == 1 && h->tree_joint_count == 0) {
    h->coordinate = m->column_coordinate + m->substructures[h->part[0]].column_start;
    return;
  }
  int *coordinate = KM_ARENA_NEW(arena, int, (size_t)h->columns), count = 0;
  h->is_composed = true;
  h->coordinate = coordinate;
  for (int i = 0; i < h->part_count && coordinate; ++i)
    for (int k = 0; k < m->substructures[h->part[i]].columns; ++k)
      coordinate[count++] = m->column_coordinate[m->substructures[h->part[i]].column_start + k];
  for (int i = 0; i < h->tree_joint_count && coordinate; ++i)
    coordinate[count++] = h->tree_joint[i];
}

static int column_in(const km_actuator_workspace *h, int coordinate) {
  int k = 0;
  while (k < h->columns && h->coordinate[k] != coordinate)
    ++k;
  return k;
}

/* Assigns an actuator to its block, or to a single tree joint, which only one actuator holds. */
static km_status assign_actuator(const part_groups *g, km_statics_workspace *w, int a, km_error *error) {
  const km_port *actuator = &w->actuators[a];
  bool joint = actuator->kind == KM_PORT_JOINT;
  int part = joint ? part_of(g->m, actuator->coordinate) : w->column[a];
  w->part[a] = block_of(g, part);
  w->tree_joint[a] = w->part[a] < 0 ? part - g->m->topology.substructure_count : -1;
  w->column[a] = joint && w->part[a] >= 0 ? column_in(&w->blocks[w->part[a]], actuator->coordinate) : -1;
  if (joint || w->tree_joint[a] < 0)
    return KM_OK;
  if (w->actuated[w->tree_joint[a]])
    return km_fail(error, KM_USAGE,
                   "actuator \"%s\" pushes what another one holds already; expected one for a joint "
                   "in no loop",
                   actuator->name);
  w->actuated[w->tree_joint[a]] = true;
  return KM_OK;
}

km_status km_blocks_make(const km_mechanism *m, km_statics *st, km_error *error) {
  km_statics_workspace *w = st->work;
  km_arena scratch = {0};
  int count = m->topology.substructure_count + m->coordinate_count;
  part_groups g = {.m = m,
                   .parent = KM_ARENA_NEW(&scratch, int, (size_t)count),
                   .size = KM_ARENA_NEW(&scratch, int, (size_t)count),
                   .block = KM_ARENA_NEW(&scratch, int, (size_t)count)};
  for (int i = 0; i < count && !scratch.failed; ++i) {
    g.parent[i] = i;
    g.size[i] = 1;
    g.block[i] = -1;
  }
  km_status status = scratch.failed ? KM_MEMORY : unite_parts(&g, st, error);
  if (!status) {
    number_blocks(&g, w);
    w->blocks = KM_ARENA_NEW(&w->arena, km_actuator_workspace, (size_t)w->block_count);
    for (int b = 0; b < w->block_count && w->blocks; ++b) {
      w->blocks[b].part = KM_ARENA_NEW(&w->arena, int, (size_t)m->topology.substructure_count);
      w->blocks[b].tree_joint = KM_ARENA_NEW(&w->arena, int, (size_t)m->coordinate_count);
    }
    status = w->arena.failed ? KM_MEMORY : KM_OK;
  }
  if (!status) {
    add_members(&g, w);
    for (int b = 0; b < w->block_count; ++b)
      list_columns(m, &w->blocks[b], &w->arena);
    status = w->arena.failed ? KM_MEMORY : KM_OK;
  }
  for (int a = 0; a < st->actuator_count && !status; ++a)
    status = assign_actuator(&g, w, a, error);
  km_arena_free(&scratch);
  return status == KM_MEMORY ? km_fail(error, KM_MEMORY, "out of memory for the actuators") : status;
}
