/* Finds and starts the programs of kmech. */
#include "base/child_process.h"

#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <link.h>
#include <signal.h>
#include <spawn.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

/* Writes the path of the file that holds this function: the shared library, or the program with the static library. */
static bool find_own_file(char out[PATH_MAX]) {
  static const char own = 0;
  Dl_info info;
  struct link_map *map = NULL;
  void *extra = NULL;
  if (!dladdr1(&own, &info, &extra, RTLD_DL_LINKMAP))
    return false;
  map = extra;
  /* The program has an empty name in the list of loaded objects. */
  return realpath(map && map->l_name[0] ? map->l_name : "/proc/self/exe", out) != NULL;
}

static bool is_program(const char *path) {
  return access(path, X_OK) == 0;
}

/* False if the file doesn't exist or the path is too long. */
static bool try_folder(const char *folder, const char *below, const char *name, char out[PATH_MAX]) {
  int size = snprintf(out, PATH_MAX, "%s%s/%s", folder, below, name);
  return size > 0 && size < PATH_MAX && is_program(out);
}

static bool find_program(const char *name, char out[PATH_MAX]) {
  const int levels = 3; /* lib/x86_64-linux-gnu/libkmech.so: libexec is a sibling of lib */
  char file[PATH_MAX];
  const char *stated = secure_getenv("KMECH_LIBEXEC");
  if (stated && *stated)
    return try_folder(stated, "", name, out);
  bool known = find_own_file(file);
  for (int i = 0; i < levels && known; ++i) {
    char *end = strrchr(file, '/');
    if (!end)
      break;
    *end = '\0';
    if (try_folder(file, "/libexec/kmech", name, out))
      return true;
  }
  return try_folder(KM_LIBEXEC_INSTALLED, "", name, out);
}

/* Prepares the new process: default signals, no descriptors but 0, 1 and 2. */
static int prepare(posix_spawn_file_actions_t *files, posix_spawnattr_t *attributes, int output) {
  sigset_t none, all;
  sigemptyset(&none);
  sigfillset(&all);
  int fault = posix_spawn_file_actions_adddup2(files, output, STDOUT_FILENO);
  if (!fault)
    fault = posix_spawn_file_actions_addopen(files, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  if (!fault)
    fault = posix_spawn_file_actions_addopen(files, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
  if (!fault)
    fault = posix_spawn_file_actions_addclosefrom_np(files, STDERR_FILENO + 1);
  if (!fault)
    fault = posix_spawnattr_setsigmask(attributes, &none);
  if (!fault)
    fault = posix_spawnattr_setsigdefault(attributes, &all);
  if (!fault)
    fault = posix_spawnattr_setflags(attributes, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF);
  return fault;
}

static int spawn(pid_t *process, char *program, const char *argument, int output) {
  posix_spawn_file_actions_t files;
  posix_spawnattr_t attributes;
  char own[PATH_MAX];
  char *const words[] = {program, own, NULL};
  if (snprintf(own, sizeof own, "%s", argument) >= (int)sizeof own)
    return ENAMETOOLONG;
  int fault = posix_spawn_file_actions_init(&files);
  if (fault)
    return fault;
  fault = posix_spawnattr_init(&attributes);
  if (!fault) {
    fault = prepare(&files, &attributes, output);
    if (!fault)
      fault = posix_spawn(process, program, &files, &attributes, words, environ);
    posix_spawnattr_destroy(&attributes);
  }
  posix_spawn_file_actions_destroy(&files);
  return fault;
}

const char *km_helper_start(km_helper *helper, const char *name, const char *argument) {
  char program[PATH_MAX];
  int ends[2];
  *helper = (km_helper){0};
  if (!find_program(name, program))
    return "isn't found; expected it in libexec/kmech beside the library, or in the folder that KMECH_LIBEXEC states";
  if (pipe2(ends, O_CLOEXEC))
    return strerror(errno);
  helper->output = fdopen(ends[0], "rb");
  int fault = helper->output ? spawn(&helper->process, program, argument, ends[1]) : errno;
  close(ends[1]);
  if (!fault)
    return NULL;
  if (helper->output)
    fclose(helper->output);
  else
    close(ends[0]);
  return strerror(fault);
}

bool km_helper_read(km_helper *helper, void *out, size_t size) {
  return fread(out, 1, size, helper->output) == size;
}

int km_helper_end(km_helper *helper) {
  int status = 0;
  pid_t ended;
  fclose(helper->output);
  do
    ended = waitpid(helper->process, &status, 0);
  while (ended < 0 && errno == EINTR);
  return ended == helper->process && WIFSIGNALED(status) ? WTERMSIG(status) : 0;
}
