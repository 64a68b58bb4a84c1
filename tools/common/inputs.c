/* Files that a command reads, so that none of its results takes their place, under whichever name. */
#include "common/common.h"

#include "kmech/base.h"

#include <string.h>
#include <sys/stat.h>

enum { MOST_INPUTS = KT_MOST_TEXTS + KT_MOST_OPTIONS + 4 }; /* operands, options, and files that a study names */

typedef struct input {
  dev_t device;
  ino_t inode;
} input;

/* Filled while the command line is read, by one thread. */
static input inputs[MOST_INPUTS];
static int count;

void kt_input(const char *path) {
  struct stat found;
  if (count < MOST_INPUTS && strcmp(path, "-") != 0 && stat(path, &found) == 0 && S_ISREG(found.st_mode))
    inputs[count++] = (input){found.st_dev, found.st_ino};
}

/* Also by another name: a link. */
static bool is_input(const char *path) {
  struct stat found;
  if (stat(path, &found) != 0)
    return false;
  for (int i = 0; i < count; ++i)
    if (inputs[i].device == found.st_dev && inputs[i].inode == found.st_ino)
      return true;
  return false;
}

kt_exit kt_write_file(const kt_common *common, const char *path, const km_text *bytes) {
  km_error error;
  if (is_input(path)) {
    kt_print_message(common, KM_ERROR, "%s: would be replaced, but this command reads it; expected another name by -o",
                     path);
    return KT_USAGE;
  }
  km_status status = km_file_write(path, bytes, &error);
  if (status)
    kt_print_message(common, KM_ERROR, "%s", error.text);
  else if (!kt_is_piped(path))
    kt_print_message(common, KM_NOTE, "wrote %s", path);
  return kt_exit_of(status);
}
