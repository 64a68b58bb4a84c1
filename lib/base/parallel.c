/* A loop whose iterations run on several threads. */
#include "base/parallel.h"

#include "base/memory.h"

#include <pthread.h>
#include <stdatomic.h>

typedef struct queue {
  atomic_int next;
  int count;
  void (*work)(void *context, int index);
  void *context;
} queue;

static void *run(void *data) {
  queue *q = data;
  for (int i = atomic_fetch_add(&q->next, 1); i < q->count; i = atomic_fetch_add(&q->next, 1))
    q->work(q->context, i);
  return NULL;
}

void km_parallel_for(int count, int jobs, void (*work)(void *context, int index), void *context) {
  if (!work)
    return;
  queue q = {.count = count, .work = work, .context = context};
  pthread_t threads[KM_MAX_THREADS];
  int started = 0;
  atomic_init(&q.next, 0);
  /* If a thread can't be created, the others do its work. */
  while (started + 1 < jobs && started + 1 < count && started < KM_MAX_THREADS &&
         pthread_create(&threads[started], NULL, run, &q) == 0)
    ++started;
  run(&q);
  for (int i = 0; i < started; ++i)
    pthread_join(threads[i], NULL);
}

typedef struct member {
  struct km_team *team;
  int index;        /* index that it takes first, because its data of the last round is in its cache */
  atomic_bool held; /* true if that index is taken, by this member or by an idle one */
  pthread_t thread;
} member;

/* A round ends when all its indices are done, not when all threads have noticed it. A thread that wakes late finds
 * no index left, or takes one of the next round. Therefore an index is taken first and its data read afterwards: the
 * round can't end before that index is done. A thread polls for a short time, then sleeps. */
struct km_team {
  member members[KM_MAX_THREADS + 1]; /* the first member is the caller */
  int started;
  pthread_mutex_t mutex;
  pthread_cond_t begins, ends;
  atomic_uint round; /* number of the round */
  atomic_bool over;
  int count;
  void (*work)(void *context, int index);
  void *context;
  atomic_int left; /* indices without a member of their own that aren't taken */
  atomic_int done;
};

enum { WATCH = 6000 }; /* iterations of polling, less than 0.3 ms: longer than a level of a small tree takes */

static void breathe(void) {
#if defined(__x86_64__) || defined(__i386__)
  __builtin_ia32_pause();
#endif
}

/* Waits for a round other than `seen`; returns its number. */
static unsigned await_round(km_team *team, unsigned seen) {
  for (int i = 0; i < WATCH; ++i, breathe())
    if (atomic_load(&team->round) != seen)
      return atomic_load(&team->round);
  pthread_mutex_lock(&team->mutex);
  while (atomic_load(&team->round) == seen)
    pthread_cond_wait(&team->begins, &team->mutex);
  pthread_mutex_unlock(&team->mutex);
  return atomic_load(&team->round);
}

static bool all_done(km_team *team) {
  return atomic_load(&team->done) == team->count;
}

/* Works on an index that was taken. The thread that ends the last index wakes the caller. */
static void work_on(km_team *team, int index) {
  int count = team->count;
  team->work(team->context, index);
  if (atomic_fetch_add(&team->done, 1) + 1 < count)
    return;
  pthread_mutex_lock(&team->mutex);
  pthread_cond_signal(&team->ends);
  pthread_mutex_unlock(&team->mutex);
}

static void copy_own(member *m) {
  if (!atomic_load(&m->held) && !atomic_exchange(&m->held, true))
    work_on(m->team, m->index);
}

/* Takes an index without a member of its own. */
static bool copy_another(km_team *team) {
  int left = atomic_load(&team->left);
  while (left > 0 && !atomic_compare_exchange_weak(&team->left, &left, left - 1))
    ;
  if (left > 0)
    work_on(team, team->count - left);
  return left > 0;
}

/* Takes the member's own index first, and those of members that haven't begun last. */
static void copy_part(member *m) {
  km_team *team = m->team;
  copy_own(m);
  while (copy_another(team))
    ;
  for (int i = 0; i <= team->started; ++i)
    copy_own(&team->members[i]);
}

static void *stand_by(void *data) {
  member *own = data;
  for (unsigned seen = 0;;) {
    seen = await_round(own->team, seen);
    if (atomic_load(&own->team->over))
      return NULL;
    copy_part(own);
  }
}

km_team *km_team_create(int jobs) {
  km_team *team = KM_NEW(km_team, 1);
  if (!team)
    return NULL;
  pthread_mutex_init(&team->mutex, NULL);
  pthread_cond_init(&team->begins, NULL);
  pthread_cond_init(&team->ends, NULL);
  for (int i = 0; i <= KM_MAX_THREADS; ++i) {
    team->members[i].team = team;
    team->members[i].index = i;
    atomic_init(&team->members[i].held, true);
  }
  while (team->started + 1 < jobs && team->started < KM_MAX_THREADS) {
    member *m = &team->members[team->started + 1];
    if (pthread_create(&m->thread, NULL, stand_by, m))
      break;
    ++team->started;
  }
  return team;
}

static void begin_round(km_team *team) {
  pthread_mutex_lock(&team->mutex);
  atomic_fetch_add(&team->round, 1);
  pthread_cond_broadcast(&team->begins);
  pthread_mutex_unlock(&team->mutex);
}

void km_team_free(km_team *team) {
  if (!team)
    return;
  atomic_store(&team->over, true);
  begin_round(team);
  for (int i = 0; i < team->started; ++i)
    pthread_join(team->members[i + 1].thread, NULL);
  pthread_cond_destroy(&team->begins);
  pthread_cond_destroy(&team->ends);
  pthread_mutex_destroy(&team->mutex);
  km_free(team);
}

static void await_end(km_team *team) {
  for (int i = 0; i < WATCH; ++i, breathe())
    if (all_done(team))
      return;
  pthread_mutex_lock(&team->mutex);
  while (!all_done(team))
    pthread_cond_wait(&team->ends, &team->mutex);
  pthread_mutex_unlock(&team->mutex);
}

void km_team_run(km_team *team, int count, void (*work)(void *context, int index), void *context) {
  if (!team || team->started == 0 || count < 2) {
    for (int i = 0; i < count; ++i)
      work(context, i);
    return;
  }
  team->count = count;
  team->work = work;
  team->context = context;
  atomic_store(&team->done, 0);
  for (int i = 0; i <= team->started && i < count; ++i)
    atomic_store(&team->members[i].held, false);
  atomic_store(&team->left, count > team->started + 1 ? count - team->started - 1 : 0);
  begin_round(team);
  copy_part(&team->members[0]);
  await_end(team);
}

void km_serially(void (*work)(void *context), void *context) {
  static pthread_mutex_t mutex = PTHREAD_MUTEX_INITIALIZER;
  pthread_mutex_lock(&mutex);
  work(context);
  pthread_mutex_unlock(&mutex);
}

const void *km_thread_mark(void) {
  static _Thread_local char mark;
  return &mark;
}
