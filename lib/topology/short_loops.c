/* Short cycle basis (docs/theory.md 2.2): shortest cycles by bidirectional breadth-first search from both ends of a
 * chord.
 *
 *   loops in the order of their fundamental cycles; a cycle may use tree joints and chords of earlier loops */
#include "topology/short_loops.h"

#include <string.h>

enum { MAX_SHORT_LENGTH = 4 }; /* loops of up to this number of joints are not shortened */

/* Search front from one end of a chord: bodies reached so far. */
typedef struct search_front {
  int *stamp;             /* [body] stamp of the last search that reached it */
  int *entry_joint;       /* [body] joint by which it was reached */
  int *queue;             /* [bodies] in the order of the search */
  int level_start, count; /* the outermost level is queue[level_start … count-1] */
} search_front;

typedef struct cycle_finder {
  const km_graph *g;
  km_topology *t;
  bool *is_usable; /* [joint] may be used by other loops: tree joints and chords of earlier loops */
  search_front sides[2];
  int search_stamp;
  int *start;       /* [loop + 1] into `member`: loops in the order of the search */
  int *order_index; /* [loop] index in that order */
  int *order;       /* [loop] loops by the length of their fundamental cycles */
  km_member *member;
  int *path; /* [bodies] joints of a path from the chord's tail to its head */
} cycle_finder;

static int opposite_body(const km_graph *g, int joint, int body) {
  return g->edges[joint].tail == body ? g->edges[joint].head : g->edges[joint].tail;
}

static int loop_length(const km_topology *t, int loop) {
  return t->member_start[loop + 1] - t->member_start[loop];
}

/* Starts a search front at a body. */
static void start_front(cycle_finder *f, int which, int body) {
  search_front *s = &f->sides[which];
  s->stamp[body] = f->search_stamp;
  s->queue[0] = body;
  s->entry_joint[body] = -1;
  s->level_start = 0;
  s->count = 1;
}

static void add_body(cycle_finder *f, search_front *s, int body, int joint) {
  s->stamp[body] = f->search_stamp;
  s->entry_joint[body] = joint;
  s->queue[s->count++] = body;
}

/* Number of joints that the next level of a front visits. */
static int front_cost(const cycle_finder *f, const search_front *s) {
  int sum = 0;
  for (int i = s->level_start; i < s->count; ++i)
    sum += f->t->incident_start[s->queue[i] + 1] - f->t->incident_start[s->queue[i]];
  return sum;
}

/* Advances a front by one level. Returns the joint that meets the other front, −1: none; *body: its body on this
 * side. */
static int advance_front(cycle_finder *f, int which, int substructure, int *body) {
  search_front *s = &f->sides[which];
  const search_front *other = &f->sides[!which];
  int end = s->count;
  for (; s->level_start < end; ++s->level_start) {
    *body = s->queue[s->level_start];
    for (int i = f->t->incident_start[*body]; i < f->t->incident_start[*body + 1]; ++i) {
      int joint = f->t->incident[i], next = opposite_body(f->g, joint, *body);
      if (!f->is_usable[joint] || f->t->substructure_of_joint[joint] != substructure ||
          s->stamp[next] == f->search_stamp)
        continue;
      if (other->stamp[next] == f->search_stamp)
        return joint;
      add_body(f, s, next, joint);
    }
  }
  return -1;
}

/* Writes the path from the chord's tail to its head through the joint at which the fronts met, which leaves `body` on
 * side `which`. Returns its number of joints. */
static int write_path(cycle_finder *f, int which, int body, int joint) {
  int inner[2], count = 0;
  inner[which] = body;
  inner[!which] = opposite_body(f->g, joint, body);
  for (int b = inner[0]; f->sides[0].entry_joint[b] >= 0; b = opposite_body(f->g, f->sides[0].entry_joint[b], b))
    f->path[count++] = f->sides[0].entry_joint[b];
  for (int i = 0; i < count / 2; ++i) {
    int swap = f->path[i];
    f->path[i] = f->path[count - 1 - i];
    f->path[count - 1 - i] = swap;
  }
  f->path[count++] = joint;
  for (int b = inner[1]; f->sides[1].entry_joint[b] >= 0; b = opposite_body(f->g, f->sides[1].entry_joint[b], b))
    f->path[count++] = f->sides[1].entry_joint[b];
  return count;
}

/* Shortest path between the chord's ends with fewer than `max_length` joints, into `path`. Returns its number of
 * joints; 0: none. */
static int find_shortest_path(cycle_finder *f, int loop, int max_length) {
  const km_edge *ends = &f->g->edges[f->t->chord[loop]];
  f->search_stamp++;
  start_front(f, 0, ends->tail);
  start_front(f, 1, ends->head);
  for (int length = 1; length < max_length; ++length) {
    int which = front_cost(f, &f->sides[1]) < front_cost(f, &f->sides[0]), body;
    int joint = advance_front(f, which, f->t->substructure_of_loop[loop], &body);
    if (joint >= 0)
      return write_path(f, which, body, joint);
  }
  return 0;
}

/* Finds the base body of a path's loop: the body with the lowest level. Returns its index on the path; 0 is the chord's
 * tail. */
static int find_base(const cycle_finder *f, int loop, int path_length, int *base) {
  int body = f->g->edges[f->t->chord[loop]].tail, best = 0;
  *base = body;
  for (int i = 0; i < path_length; ++i) {
    body = opposite_body(f->g, f->path[i], body);
    if (f->t->level[body] < f->t->level[*base]) {
      *base = body;
      best = i + 1;
    }
  }
  return best;
}

/* Writes the members of the path's loop: from the base to the chord's tail, the chord, and from the base to the chord's
 * head. */
static void write_loop(cycle_finder *f, int loop, int path_length, km_member *out) {
  int base, incidence = find_base(f, loop, path_length, &base);
  f->t->base[loop] = base;
  for (int i = incidence - 1, body = base; i >= 0; body = opposite_body(f->g, f->path[i--], body))
    *out++ = (km_member){f->path[i], +1, f->g->edges[f->path[i]].head == body};
  *out++ = (km_member){f->t->chord[loop], +1, false};
  for (int i = incidence, body = base; i < path_length; body = opposite_body(f->g, f->path[i++], body))
    *out++ = (km_member){f->path[i], -1, f->g->edges[f->path[i]].head == body};
}

/* Counting sort of the loops by the length of their fundamental cycles, then by number. */
static bool sort_loops_by_length(cycle_finder *f, km_arena *scratch) {
  const km_topology *t = f->t;
  int longest = 0;
  for (int l = 0; l < t->loop_count; ++l)
    longest = loop_length(t, l) > longest ? loop_length(t, l) : longest;
  int *next = KM_ARENA_NEW(scratch, int, (size_t)longest + 2);
  if (!next)
    return false;
  for (int l = 0; l < t->loop_count; ++l)
    next[loop_length(t, l) + 1]++;
  for (int i = 0; i <= longest; ++i)
    next[i + 1] += next[i];
  for (int l = 0; l < t->loop_count; ++l)
    f->order[next[loop_length(t, l)]++] = l;
  return true;
}

/* Writes the shortest allowed cycle of one loop. */
static void shorten(cycle_finder *f, int loop, int *used) {
  const km_topology *t = f->t;
  int s = t->substructure_of_loop[loop], length = loop_length(t, loop);
  bool large = t->loop_start[s + 1] - t->loop_start[s] > KM_MAX_TREE_LOOPS;
  int path_length = large && length > MAX_SHORT_LENGTH ? find_shortest_path(f, loop, length - 1) : 0;
  if (path_length)
    write_loop(f, loop, path_length, f->member + *used);
  else
    memcpy(f->member + *used, t->member + t->member_start[loop], (size_t)length * sizeof *f->member);
  *used += path_length ? path_length + 1 : length;
  f->is_usable[t->chord[loop]] = true;
}

/* Stores the members of all loops in the order of their numbers. No loop is longer than before. */
static void store_loops(const cycle_finder *f) {
  km_topology *t = f->t;
  int used = 0;
  for (int l = 0; l < t->loop_count; ++l) {
    int level_start = f->start[f->order_index[l]], count = f->start[f->order_index[l] + 1] - level_start;
    memcpy(t->member + used, f->member + level_start, (size_t)count * sizeof *t->member);
    t->member_start[l] = used;
    used += count;
  }
  t->member_start[t->loop_count] = used;
}

/* Allocates the search and sorts the loops. */
static bool create_finder(cycle_finder *f, km_arena *scratch) {
  size_t bodies = (size_t)f->g->body_count, path_length = (size_t)f->g->joint_count, loops = (size_t)f->t->loop_count;
  for (int i = 0; i < 2; ++i)
    f->sides[i] = (search_front){.stamp = KM_ARENA_NEW(scratch, int, bodies),
                                 .entry_joint = KM_ARENA_NEW(scratch, int, bodies),
                                 .queue = KM_ARENA_NEW(scratch, int, bodies)};
  f->is_usable = KM_ARENA_NEW(scratch, bool, path_length);
  f->start = KM_ARENA_NEW(scratch, int, loops + 1);
  f->order_index = KM_ARENA_NEW(scratch, int, loops);
  f->order = KM_ARENA_NEW(scratch, int, loops);
  f->path = KM_ARENA_NEW(scratch, int, bodies);
  f->member = KM_ARENA_NEW(scratch, km_member, (size_t)f->t->member_start[loops]);
  return !scratch->failed && sort_loops_by_length(f, scratch);
}

static bool is_needed(const km_topology *t) {
  bool needed = false;
  for (int s = 0; s < t->substructure_count; ++s)
    needed = needed || t->loop_start[s + 1] - t->loop_start[s] > KM_MAX_TREE_LOOPS;
  return needed;
}

/* Replaces the loops of large substructures by shortest cycles. */
bool km_find_short_loops(const km_graph *g, km_arena *scratch, km_topology *t) {
  cycle_finder f = {.g = g, .t = t};
  int used = 0;
  if (!is_needed(t))
    return true;
  if (!create_finder(&f, scratch))
    return false;
  for (int b = 1; b < t->body_count; ++b)
    f.is_usable[t->arc[b]] = true;
  for (int i = 0; i < t->loop_count; ++i) {
    f.order_index[f.order[i]] = i;
    f.start[i] = used;
    shorten(&f, f.order[i], &used);
  }
  f.start[t->loop_count] = used;
  store_loops(&f);
  return true;
}
