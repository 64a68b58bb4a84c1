/* Files that a description names, by a path or behind the name of a package. */
#include "exchange/robot/robot.h"

#include "base/file.h"

#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

enum { MOST_PARENTS = 12 };

/* Path after `package://`, `model://` or `file://`. */
static const char *without_scheme(const char *name) {
  const char *colon = strstr(name, "://");
  return colon ? colon + 3 : name;
}

/* A device or a pipe might never end. */
static bool is_readable(const char *path) {
  struct stat found;
  return stat(path, &found) == 0 && S_ISREG(found.st_mode) && access(path, R_OK) == 0;
}

static const char *find_above(km_robot *robot, const char *folder, const char *path) {
  for (int n = 0; n < MOST_PARENTS && !robot->arena.failed; ++n) {
    const char *found = km_robot_text(robot, "%s/%s", folder, path);
    if (is_readable(found))
      return found;
    folder = km_robot_text(robot, "%s/..", folder);
  }
  return NULL;
}

static const char *folder_of(km_robot *robot) {
  const char *file = robot->request->file, *slash = file ? strrchr(file, '/') : NULL;
  return slash ? km_robot_text(robot, "%.*s", (int)(slash - file), file) : ".";
}

const char *km_robot_find_whole(km_robot *robot, const char *name) {
  const char *path = without_scheme(name);
  if (path[0] == '/')
    return is_readable(path) ? path : NULL;
  return find_above(robot, folder_of(robot), path);
}

const char *km_robot_find(km_robot *robot, const char *name) {
  const char *path = without_scheme(name), *found = km_robot_find_whole(robot, name);
  const char *behind = path != name && path[0] != '/' ? strchr(path, '/') : NULL; /* path without the package's name */
  return found || !behind ? found : find_above(robot, folder_of(robot), behind + 1);
}

km_xml *km_robot_read_file(km_robot *robot, const char *path, const km_xml *at) {
  km_text bytes = {0};
  km_xml *root = NULL;
  km_error error;
  km_status status = km_file_read(path, &bytes, &error);
  if (!status)
    status = km_xml_parse(bytes.data ? bytes.data : "", bytes.size, path, &robot->arena, &root, &error);
  km_text_free(&bytes);
  if (status == KM_MEMORY)
    robot->arena.failed = true;
  else if (status)
    km_robot_error(robot, at, "%s", error.text);
  return root;
}

const char *km_robot_mesh(km_robot *robot, const char *name) {
  const char *file = robot->request->file, *slash = file ? strrchr(file, '/') : NULL;
  const char *found = km_robot_find(robot, name);
  if (!found)
    return without_scheme(name);
  return found[0] == '/' ? found : found + (slash ? slash - file + 1 : 2);
}
