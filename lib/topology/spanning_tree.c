/* Spanning tree (breadth-first), fundamental cycles and biconnected components of a graph (docs/theory.md 2.2). */
#include "topology/short_loops.h"

#include "base/number/union_find.h"

#include <string.h>

/* Lists the joints at each body. */
static void list_incident(const km_graph *g, km_topology *t) {
  int *start = t->incident_start;
  for (int j = 0; j < g->joint_count; ++j) {
    start[g->edges[j].tail + 2]++;
    start[g->edges[j].head + 2]++;
  }
  for (int b = 0; b < g->body_count; ++b)
    start[b + 2] += start[b + 1];
  /* start[b + 1] is the position of body b's next joint while they are sorted, and its end afterwards. */
  for (int j = 0; j < g->joint_count; ++j) {
    t->incident[start[g->edges[j].tail + 1]++] = j;
    t->incident[start[g->edges[j].head + 1]++] = j;
  }
}

/* Unites the classes of a and b; the smallest number represents the class. False if they were one. */
static bool unite_sets(int *set, int a, int b) {
  a = km_set_root(set, a);
  b = km_set_root(set, b);
  set[a > b ? a : b] = a < b ? a : b;
  return a != b;
}

/* Marks the joints that a tree may use: those that aren't cut, and of those to cut the ones without which bodies are
 * separate (J. B. Kruskal 1956, with two weights). set: [bodies] workspace. */
static void choose_usable_joints(const km_graph *g, int *set, bool *is_usable) {
  km_sets_reset(set, g->body_count);
  for (int pass = 0; pass < 2; ++pass)
    for (int j = 0; j < g->joint_count; ++j)
      if ((g->is_cut && g->is_cut[j]) == pass)
        is_usable[j] = unite_sets(set, g->edges[j].tail, g->edges[j].head) || pass == 0;
}

/* Breadth-first spanning tree of usable joints from the inertial frame. */
static void build_tree(const km_graph *g, const bool *is_usable, km_topology *t) {
  for (int b = 0; b < g->body_count; ++b)
    t->parent[b] = t->arc[b] = t->level[b] = -1;
  int tail = 1;
  t->order[0] = 0;
  t->level[0] = 0;
  for (int head = 0; head < tail; ++head) {
    int body = t->order[head];
    for (int i = t->incident_start[body]; i < t->incident_start[body + 1]; ++i) {
      int joint = t->incident[i];
      bool forward = g->edges[joint].tail == body;
      int next = forward ? g->edges[joint].head : g->edges[joint].tail;
      if (t->level[next] >= 0 || !is_usable[joint])
        continue;
      t->level[next] = t->level[body] + 1;
      t->parent[next] = body;
      t->arc[next] = joint;
      t->is_reversed[joint] = !forward;
      t->order[tail++] = next;
    }
  }
}

static bool is_arc(const km_graph *g, const km_topology *t, int joint) {
  return t->arc[g->edges[joint].head] == joint || t->arc[g->edges[joint].tail] == joint;
}

/* Lowest common ancestor of two bodies in the tree. */
static int common_ancestor(const km_topology *t, int a, int b) {
  while (a != b) {
    if (t->level[a] >= t->level[b])
      a = t->parent[a];
    else
      b = t->parent[b];
  }
  return a;
}

/* Finds the chords and base bodies, and counts the members of their fundamental cycles. */
static void find_chords(const km_graph *g, km_topology *t, int *members) {
  *members = 0;
  for (int j = 0; j < g->joint_count; ++j) {
    if (is_arc(g, t, j))
      continue;
    int a = g->edges[j].tail, b = g->edges[j].head, base = common_ancestor(t, a, b);
    t->chord[t->loop_count] = j;
    t->base[t->loop_count++] = base;
    *members += 1 + t->level[a] + t->level[b] - 2 * t->level[base];
  }
}

/* Writes the tree joints from `base` down to `body`, ending just before *end; returns the first. */
static km_member *write_path(const km_topology *t, int base, int body, int side, km_member *end) {
  for (; body != base; body = t->parent[body])
    *--end = (km_member){t->arc[body], side, t->is_reversed[t->arc[body]]};
  return end;
}

/* Writes the members of all fundamental cycles. */
static void list_members(const km_graph *g, km_topology *t) {
  int used = 0;
  for (int l = 0; l < t->loop_count; ++l) {
    const km_edge *edge = &g->edges[t->chord[l]];
    int base = t->base[l];
    int outward = t->level[edge->tail] - t->level[base], return_path = t->level[edge->head] - t->level[base];
    t->member_start[l] = used;
    write_path(t, base, edge->tail, +1, t->member + used + outward);
    t->member[used + outward] = (km_member){t->chord[l], +1, false};
    used += outward + 1 + return_path;
    write_path(t, base, edge->head, -1, t->member + used);
  }
  t->member_start[t->loop_count] = used;
}

/* Unites the joints of each loop and of each coupling. Loops that share a joint are one substructure: the classes are
 * the biconnected components, since these are the connected components of the fundamental cycles (matroid theory). */
static void unite_joints(const km_graph *g, const km_topology *t, int *set, bool *is_in_substructure) {
  for (int l = 0; l < t->loop_count; ++l) {
    for (int i = t->member_start[l]; i < t->member_start[l + 1]; ++i) {
      is_in_substructure[t->member[i].joint] = true;
      unite_sets(set, t->chord[l], t->member[i].joint);
    }
  }
  for (int i = 0; i < g->coupled_count; ++i) {
    for (int k = 0; k < g->coupled[i].count; ++k) {
      is_in_substructure[g->coupled[i].joints[k]] = true;
      unite_sets(set, g->coupled[i].joints[0], g->coupled[i].joints[k]);
    }
  }
}

/* Numbers the substructures by their first joint. */
static void number_substructures(km_topology *t, int *set, const bool *is_in_substructure) {
  for (int j = 0; j < t->joint_count; ++j) {
    int root = km_set_root(set, j);
    if (!is_in_substructure[j])
      t->substructure_of_joint[j] = -1;
    else
      t->substructure_of_joint[j] = root == j ? t->substructure_count++ : t->substructure_of_joint[root];
  }
  for (int l = 0; l < t->loop_count; ++l)
    t->substructure_of_loop[l] = t->substructure_of_joint[t->chord[l]];
}

/* Counting sort of 0 … count-1 by class: the members of class c are item[start[c]] …, in order. */
static void group_by_class(const int *class_of, int count, int classes, int *start, int *item) {
  for (int i = 0; i < count; ++i)
    if (class_of[i] >= 0)
      start[class_of[i] + 1]++;
  for (int c = 0; c < classes; ++c)
    start[c + 1] += start[c];
  for (int i = count - 1, position; i >= 0; --i) {
    if (class_of[i] < 0)
      continue;
    position = --start[class_of[i] + 1];
    item[position] = i;
  }
  memmove(start, start + 1, (size_t)classes * sizeof *start);
}

/* Lists the joints and loops of each substructure. */
static void group_joints_and_loops(km_topology *t) {
  int grouped_count = 0;
  for (int j = 0; j < t->joint_count; ++j)
    grouped_count += t->substructure_of_joint[j] >= 0;
  group_by_class(t->substructure_of_joint, t->joint_count, t->substructure_count, t->joint_start, t->joint);
  group_by_class(t->substructure_of_loop, t->loop_count, t->substructure_count, t->loop_start, t->loop);
  t->joint_start[t->substructure_count] = grouped_count;
  t->loop_start[t->substructure_count] = t->loop_count;
}

/* Lists the bodies of each substructure in level order. */
static void group_bodies(km_topology *t, int *class_of) {
  int grouped_count = 0;
  for (int i = 0; i < t->body_count; ++i) {
    class_of[i] = i ? t->substructure_of_joint[t->arc[t->order[i]]] : -1;
    grouped_count += class_of[i] >= 0;
  }
  group_by_class(class_of, t->body_count, t->substructure_count, t->body_start, t->body);
  t->body_start[t->substructure_count] = grouped_count;
  for (int i = 0; i < grouped_count; ++i)
    t->body[i] = t->order[t->body[i]];
}

/* Lists the loops through each joint. False when out of memory. */
static bool list_joint_loops(km_topology *t, km_arena *arena) {
  int members = t->member_start[t->loop_count], *start = KM_ARENA_NEW(arena, int, (size_t)t->joint_count + 2);
  t->joint_loop = KM_ARENA_NEW(arena, km_joint_loop, (size_t)members);
  t->joint_loop_start = start;
  if (arena->failed)
    return false;
  for (int i = 0; i < members; ++i)
    start[t->member[i].joint + 2]++;
  for (int j = 0; j < t->joint_count; ++j)
    start[j + 2] += start[j + 1];
  /* start[j + 1] is the position of joint j's next loop while they are sorted, and its end afterwards. */
  for (int s = 0; s < t->substructure_count; ++s)
    for (int i = t->loop_start[s]; i < t->loop_start[s + 1]; ++i)
      for (int n = t->member_start[t->loop[i]]; n < t->member_start[t->loop[i] + 1]; ++n)
        t->joint_loop[start[t->member[n].joint + 1]++] =
            (km_joint_loop){i - t->loop_start[s], km_member_sign(&t->member[n])};
  return true;
}

static bool allocate_arrays(const km_graph *g, km_arena *arena, km_topology *t) {
  size_t bodies = (size_t)g->body_count, joints = (size_t)g->joint_count;
  t->body_count = g->body_count;
  t->joint_count = g->joint_count;
  t->order = KM_ARENA_NEW(arena, int, bodies);
  t->level = KM_ARENA_NEW(arena, int, bodies);
  t->parent = KM_ARENA_NEW(arena, int, bodies);
  t->arc = KM_ARENA_NEW(arena, int, bodies);
  t->is_reversed = KM_ARENA_NEW(arena, bool, joints);
  t->chord = KM_ARENA_NEW(arena, int, joints);
  t->base = KM_ARENA_NEW(arena, int, joints);
  t->member_start = KM_ARENA_NEW(arena, int, joints + 1);
  t->substructure_of_joint = KM_ARENA_NEW(arena, int, joints);
  t->substructure_of_loop = KM_ARENA_NEW(arena, int, joints);
  t->joint_start = KM_ARENA_NEW(arena, int, joints + 2);
  t->joint = KM_ARENA_NEW(arena, int, joints);
  t->loop_start = KM_ARENA_NEW(arena, int, joints + 2);
  t->loop = KM_ARENA_NEW(arena, int, joints);
  t->body_start = KM_ARENA_NEW(arena, int, joints + 2);
  t->body = KM_ARENA_NEW(arena, int, bodies);
  t->incident_start = KM_ARENA_NEW(arena, int, bodies + 2);
  t->incident = KM_ARENA_NEW(arena, int, 2 * joints);
  return !arena->failed;
}

/* Tree, chords, fundamental cycles, substructures, short cycles, loops through each joint. */
static bool build(const km_graph *g, km_arena *arena, km_arena *scratch, km_topology *t) {
  int *set = KM_ARENA_NEW(scratch, int, (size_t)g->joint_count);
  int *class_of = KM_ARENA_NEW(scratch, int, (size_t)g->body_count);
  bool *is_in_substructure = KM_ARENA_NEW(scratch, bool, (size_t)g->joint_count);
  bool *is_usable = KM_ARENA_NEW(scratch, bool, (size_t)g->joint_count);
  if (scratch->failed || !allocate_arrays(g, arena, t))
    return false;
  int members;
  list_incident(g, t);
  choose_usable_joints(g, class_of, is_usable);
  build_tree(g, is_usable, t);
  find_chords(g, t, &members);
  t->member = KM_ARENA_NEW(arena, km_member, (size_t)members);
  if (arena->failed)
    return false;
  list_members(g, t);
  km_sets_reset(set, g->joint_count);
  unite_joints(g, t, set, is_in_substructure);
  number_substructures(t, set, is_in_substructure);
  group_joints_and_loops(t);
  group_bodies(t, class_of);
  return km_find_short_loops(g, scratch, t) && list_joint_loops(t, arena);
}

km_status km_topology_build(const km_graph *graph, km_arena *arena, km_topology *outward, km_error *error) {
  km_arena scratch = {0};
  *outward = (km_topology){0};
  bool is_ok = build(graph, arena, &scratch, outward);
  km_arena_free(&scratch);
  return is_ok ? KM_OK : km_fail(error, KM_MEMORY, "out of memory while analysing the topology");
}
