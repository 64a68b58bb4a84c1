/* Messages between the ranks of mpirun. Without MPI, or without mpirun, there is one rank. */
#include "kstudy/ranks.h"

#ifdef KSTUDY_MPI

#include "kmech/base.h"

#include <limits.h>
#include <mpi.h>
#include <stdlib.h>
#include <time.h>

enum { TAG = 1 };

static bool send(void *context, int to, const void *bytes, size_t size) {
  (void)context;
  return size <= INT_MAX && MPI_Send(bytes, (int)size, MPI_BYTE, to, TAG, MPI_COMM_WORLD) == MPI_SUCCESS;
}

/* OpenMPI waits at full speed; a rank that has nothing to do should leave the processor to others. */
static bool wait_for(MPI_Status *status, bool wait) {
  const struct timespec pause = {0, 200000};
  int there = 0;
  while (MPI_Iprobe(MPI_ANY_SOURCE, TAG, MPI_COMM_WORLD, &there, status) == MPI_SUCCESS && !there && wait)
    nanosleep(&pause, NULL);
  return there;
}

typedef struct mailbox {
  char *bytes;
  size_t room;
} mailbox;
static mailbox mail; /* the process's own: MPI is the process's too */

static int receive(void *context, bool wait, const void **bytes, size_t *size) {
  MPI_Status status;
  int count = 0;
  (void)context;
  if (!wait_for(&status, wait) || MPI_Get_count(&status, MPI_BYTE, &count) != MPI_SUCCESS)
    return -1;
  void *data = mail.bytes;
  if (!km_reserve(&data, &mail.room, (size_t)count + 1, 1))
    return -1;
  mail.bytes = data;
  if (MPI_Recv(mail.bytes, count, MPI_BYTE, status.MPI_SOURCE, TAG, MPI_COMM_WORLD, &status) != MPI_SUCCESS)
    return -1;
  *bytes = mail.bytes;
  *size = (size_t)count;
  return status.MPI_SOURCE;
}

void kstudy_ranks_begin(kstudy_ranks *ranks) {
  int provided;
  *ranks = (kstudy_ranks){.count = 1};
  if (!getenv("OMPI_COMM_WORLD_SIZE") && !getenv("PMI_SIZE") && !getenv("PMIX_RANK"))
    return;
  if (MPI_Init_thread(NULL, NULL, MPI_THREAD_FUNNELED, &provided) != MPI_SUCCESS)
    return;
  MPI_Comm_rank(MPI_COMM_WORLD, &ranks->rank);
  MPI_Comm_size(MPI_COMM_WORLD, &ranks->count);
  ranks->crew = (km_design_workers){.size = ranks->count - 1, .send = send, .receive = receive};
}

void kstudy_ranks_end(kstudy_ranks *ranks) {
  if (!ranks->crew.send)
    return;
  if (ranks->rank == 0)
    km_design_workers_stop(&ranks->crew);
  MPI_Finalize();
  km_free(mail.bytes);
  mail = (mailbox){0};
}

#else

void kstudy_ranks_begin(kstudy_ranks *ranks) {
  *ranks = (kstudy_ranks){.count = 1};
}

void kstudy_ranks_end(kstudy_ranks *ranks) {
  (void)ranks;
}

#endif
