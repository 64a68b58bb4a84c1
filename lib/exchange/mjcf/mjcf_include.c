/* Files that a model of MuJoCo includes. */
#include "exchange/mjcf/mjcf.h"

#include <string.h>

typedef struct including {
  km_robot *robot;
  km_names files; /* those that are included already */
} including;

static void include_in(including *work, km_xml *parent);

/* The root of the file that is named, its own includes resolved; NULL: reported. */
static km_xml *read_included(including *work, const km_xml *at) {
  km_robot *robot = work->robot;
  const char *name = km_xml_attribute_of(at, "file"), *path = name ? km_robot_find(robot, name) : NULL;
  if (!path) {
    km_robot_error(robot, at, "the file \"%.200s\" to include isn't there; expected it beside the model",
                   name ? name : "");
    return NULL;
  }
  if (km_names_get(&work->files, 0, path) >= 0) {
    km_robot_error(robot, at, "the file \"%.200s\" is included twice; expected once", name);
    return NULL;
  }
  if (!km_names_set(&work->files, 0, path, 0))
    robot->arena.failed = true;
  km_xml *root = km_robot_read_file(robot, path, at);
  if (root)
    include_in(work, root);
  return root;
}

/* Puts the members of `root` in the place of the element after `last` (NULL: the first one). */
static km_xml *splice(km_xml *parent, km_xml *last, const km_xml *gone, km_xml *root) {
  km_xml *first = root ? root->first : NULL, *end = root ? root->last : NULL;
  for (km_xml *e = first; e; e = e->next)
    e->parent = parent;
  if (end)
    end->next = gone->next;
  km_xml *next = first ? first : gone->next;
  if (last)
    last->next = next;
  else
    parent->first = next;
  if (!gone->next)
    parent->last = end ? end : last;
  return end ? end : last;
}

static void include_in(including *work, km_xml *parent) {
  km_xml *last = NULL;
  for (km_xml *e = parent->first, *next; e; e = next) {
    next = e->next;
    if (strcmp(e->name, "include") == 0) {
      last = splice(parent, last, e, read_included(work, e));
    } else {
      include_in(work, e);
      last = e;
    }
  }
}

void km_mjcf_include(km_robot *robot, km_xml *root) {
  including work = {.robot = robot};
  include_in(&work, root);
  km_names_free(&work.files);
}
