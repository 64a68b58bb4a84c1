/* Stands between a tool and the system's calloc and realloc: the call that KMECH_FAIL_AT counts finds no memory. Only calls
 * of the tool itself count, not those of other libraries. With KMECH_CALLS_TO the number of calls is written to that file
 * when the tool ends. Loaded by LD_PRELOAD (tests/faults/run). */
#include <dlfcn.h>
#include <link.h>
#include <stdatomic.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

static atomic_long calls;
static long failing;
static uintptr_t first, last; /* of the tool's own code */

static int find_own(struct dl_phdr_info *info, size_t size, void *context) {
  (void)size, (void)context;
  for (int i = 0; i < info->dlpi_phnum; ++i)
    if (info->dlpi_phdr[i].p_type == PT_LOAD && (info->dlpi_phdr[i].p_flags & PF_X)) {
      first = info->dlpi_addr + info->dlpi_phdr[i].p_vaddr;
      last = first + info->dlpi_phdr[i].p_memsz;
    }
  return 1; /* the first object is the tool */
}

__attribute__((constructor)) static void begin(void) {
  const char *at = getenv("KMECH_FAIL_AT");
  dl_iterate_phdr(find_own, NULL);
  failing = at ? strtol(at, NULL, 10) : 0;
}

__attribute__((destructor)) static void end(void) {
  const char *path = getenv("KMECH_CALLS_TO");
  FILE *file = path ? fopen(path, "w") : NULL;
  if (file) {
    fprintf(file, "%ld\n", (long)calls);
    fclose(file);
  }
}

static int fails(uintptr_t caller) {
  return caller >= first && caller < last && ++calls == failing;
}

extern void *__libc_calloc(size_t count, size_t size);
extern void *__libc_realloc(void *block, size_t size);

void *calloc(size_t count, size_t size) {
  return fails((uintptr_t)__builtin_return_address(0)) ? NULL : __libc_calloc(count, size);
}

void *realloc(void *block, size_t size) {
  return fails((uintptr_t)__builtin_return_address(0)) ? NULL : __libc_realloc(block, size);
}
