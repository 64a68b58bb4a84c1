/* Shorter loops than the tree's, which grow long in lattices: a search from both ends of each chord. */
#include "topology/short_loops.h"

#include <string.h>

enum { SHORTEST = 4 }; /* loops of so few joints are taken as they are */

/* One end of a chord, and the bodies that were reached from it. */
typedef struct side {
  int *stamp;      /* [body] of the last search that reached it */
  int *via;        /* [body] the joint by which */
  int *queue;      /* [bodies] in the order in which they were reached */
  int from, count; /* those of the last step outwards are queue[from … count-1] */
} side;

typedef struct finder {
  const km_graph *g;
  const km_incidence *at;
  km_topology *t;
  bool *usable; /* [joint] may lie in other loops than its own: of the tree, or of a shorter loop */
  side sides[2];
  int search;
  int *start; /* [loop + 1] into `member`: the loops in the order in which they were found, by `place` */
  int *place; /* [loop] its place in that order */
  int *order; /* [loop] the loops by the length that the tree gives them */
  km_member *member;
  int *path; /* [bodies] joints of a way, from the chord's tail to its head */
} finder;

static int other_end(const km_graph *g, int joint, int body) {
  return g->edges[joint].tail == body ? g->edges[joint].head : g->edges[joint].tail;
}

static int length_of(const km_topology *t, int loop) {
  return t->member_start[loop + 1] - t->member_start[loop];
}

static void put_out(finder *f, int which, int body) {
  side *s = &f->sides[which];
  s->stamp[body] = f->search;
  s->queue[0] = body;
  s->via[body] = -1;
  s->from = 0;
  s->count = 1;
}

static void reach(finder *f, side *s, int body, int joint) {
  s->stamp[body] = f->search;
  s->via[body] = joint;
  s->queue[s->count++] = body;
}

/* How many joints the next step of a side looks at. */
static int effort(const finder *f, const side *s) {
  int sum = 0;
  for (int i = s->from; i < s->count; ++i)
    sum += f->at->start[s->queue[i] + 1] - f->at->start[s->queue[i]];
  return sum;
}

/* One step outwards. Returns the joint that leads to a body of the other side, -1: none yet. */
static int step(finder *f, int which, int substructure, int *body) {
  side *s = &f->sides[which];
  const side *other = &f->sides[!which];
  int end = s->count;
  for (; s->from < end; ++s->from) {
    *body = s->queue[s->from];
    for (int i = f->at->start[*body]; i < f->at->start[*body + 1]; ++i) {
      int joint = f->at->item[i], next = other_end(f->g, joint, *body);
      if (!f->usable[joint] || f->t->substructure_of_joint[joint] != substructure || s->stamp[next] == f->search)
        continue;
      if (other->stamp[next] == f->search)
        return joint;
      reach(f, s, next, joint);
    }
  }
  return -1;
}

/* The way from the chord's tail to its head through the joint at which the sides met, which leads away from `body` on
 * side `which`. Returns how many joints. */
static int write_way(finder *f, int which, int body, int joint) {
  int inner[2], count = 0;
  inner[which] = body;
  inner[!which] = other_end(f->g, joint, body);
  for (int b = inner[0]; f->sides[0].via[b] >= 0; b = other_end(f->g, f->sides[0].via[b], b))
    f->path[count++] = f->sides[0].via[b];
  for (int i = 0; i < count / 2; ++i) {
    int swap = f->path[i];
    f->path[i] = f->path[count - 1 - i];
    f->path[count - 1 - i] = swap;
  }
  f->path[count++] = joint;
  for (int b = inner[1]; f->sides[1].via[b] >= 0; b = other_end(f->g, f->sides[1].via[b], b))
    f->path[count++] = f->sides[1].via[b];
  return count;
}

/* The shortest way between the chord's ends that has fewer than `most` joints, into `path`. Returns how many; 0: there
 * is none. */
static int find_way(finder *f, int loop, int most) {
  const km_edge *ends = &f->g->edges[f->t->chord[loop]];
  f->search++;
  put_out(f, 0, ends->tail);
  put_out(f, 1, ends->head);
  for (int length = 1; length < most; ++length) {
    int which = effort(f, &f->sides[1]) < effort(f, &f->sides[0]), body;
    int joint = step(f, which, f->t->substructure_of_loop[loop], &body);
    if (joint >= 0)
      return write_way(f, which, body, joint);
  }
  return 0;
}

/* Of the way's bodies that nearest to the inertial frame, as its place: 0 is the chord's tail. */
static int nearest(const finder *f, int loop, int joints, int *base) {
  int body = f->g->edges[f->t->chord[loop]].tail, best = 0;
  *base = body;
  for (int i = 0; i < joints; ++i) {
    body = other_end(f->g, f->path[i], body);
    if (f->t->level[body] < f->t->level[*base]) {
      *base = body;
      best = i + 1;
    }
  }
  return best;
}

/* The loop of the way: from its base to the chord's tail, the chord, and from the base to the chord's head. */
static void write_loop(finder *f, int loop, int joints, km_member *out) {
  int base, at = nearest(f, loop, joints, &base);
  f->t->base[loop] = base;
  for (int i = at - 1, body = base; i >= 0; body = other_end(f->g, f->path[i--], body))
    *out++ = (km_member){f->path[i], +1, f->g->edges[f->path[i]].head == body};
  *out++ = (km_member){f->t->chord[loop], +1, false};
  for (int i = at, body = base; i < joints; body = other_end(f->g, f->path[i++], body))
    *out++ = (km_member){f->path[i], -1, f->g->edges[f->path[i]].head == body};
}

/* The loops by the length that the tree gives them, those of one length by number. */
static bool sort(finder *f, km_arena *scratch) {
  const km_topology *t = f->t;
  int longest = 0;
  for (int l = 0; l < t->loop_count; ++l)
    longest = length_of(t, l) > longest ? length_of(t, l) : longest;
  int *next = KM_ARENA_NEW(scratch, int, (size_t)longest + 2);
  if (!next)
    return false;
  for (int l = 0; l < t->loop_count; ++l)
    next[length_of(t, l) + 1]++;
  for (int i = 0; i <= longest; ++i)
    next[i + 1] += next[i];
  for (int l = 0; l < t->loop_count; ++l)
    f->order[next[length_of(t, l)]++] = l;
  return true;
}

static void shorten(finder *f, int loop, int *used) {
  const km_topology *t = f->t;
  int s = t->substructure_of_loop[loop], length = length_of(t, loop);
  bool large = t->loop_start[s + 1] - t->loop_start[s] > KM_MAX_TREE_LOOPS;
  int joints = large && length > SHORTEST ? find_way(f, loop, length - 1) : 0;
  if (joints)
    write_loop(f, loop, joints, f->member + *used);
  else
    memcpy(f->member + *used, t->member + t->member_start[loop], (size_t)length * sizeof *f->member);
  *used += joints ? joints + 1 : length;
  f->usable[t->chord[loop]] = true;
}

/* The loops' members in the order of their numbers. None is longer than it was. */
static void take_over(const finder *f) {
  km_topology *t = f->t;
  int used = 0;
  for (int l = 0; l < t->loop_count; ++l) {
    int from = f->start[f->place[l]], count = f->start[f->place[l] + 1] - from;
    memcpy(t->member + used, f->member + from, (size_t)count * sizeof *t->member);
    t->member_start[l] = used;
    used += count;
  }
  t->member_start[t->loop_count] = used;
}

static bool make_finder(finder *f, km_arena *scratch) {
  size_t bodies = (size_t)f->g->body_count, joints = (size_t)f->g->joint_count, loops = (size_t)f->t->loop_count;
  for (int i = 0; i < 2; ++i)
    f->sides[i] = (side){.stamp = KM_ARENA_NEW(scratch, int, bodies),
                         .via = KM_ARENA_NEW(scratch, int, bodies),
                         .queue = KM_ARENA_NEW(scratch, int, bodies)};
  f->usable = KM_ARENA_NEW(scratch, bool, joints);
  f->start = KM_ARENA_NEW(scratch, int, loops + 1);
  f->place = KM_ARENA_NEW(scratch, int, loops);
  f->order = KM_ARENA_NEW(scratch, int, loops);
  f->path = KM_ARENA_NEW(scratch, int, bodies);
  f->member = KM_ARENA_NEW(scratch, km_member, (size_t)f->t->member_start[loops]);
  return !scratch->failed && sort(f, scratch);
}

static bool is_needed(const km_topology *t) {
  bool needed = false;
  for (int s = 0; s < t->substructure_count; ++s)
    needed = needed || t->loop_start[s + 1] - t->loop_start[s] > KM_MAX_TREE_LOOPS;
  return needed;
}

bool km_find_short_loops(const km_graph *g, const km_incidence *at, km_arena *scratch, km_topology *t) {
  finder f = {.g = g, .at = at, .t = t};
  int used = 0;
  if (!is_needed(t))
    return true;
  if (!make_finder(&f, scratch))
    return false;
  for (int b = 1; b < t->body_count; ++b)
    f.usable[t->arc[b]] = true;
  for (int i = 0; i < t->loop_count; ++i) {
    f.place[f.order[i]] = i;
    f.start[i] = used;
    shorten(&f, f.order[i], &used);
  }
  f.start[t->loop_count] = used;
  take_over(&f);
  return true;
}
