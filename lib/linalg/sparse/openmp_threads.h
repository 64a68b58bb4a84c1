/* Keeps OpenMP to the calling thread. CHOLMOD asks for four threads in blocks of 64 rows, which spend more on waiting for each
 * other than they save, and a study has a worker on every core as it is. Private to partition/. */
#ifndef KM_LINALG_SPARSE_OPENMP_THREADS_H
#define KM_LINALG_SPARSE_OPENMP_THREADS_H

/* From here on to the end parallel regions of this thread run on it alone. Returns what the end is to be given. */
int km_openmp_single_thread_begin(void);
void km_openmp_single_thread_end(int levels);

#endif
