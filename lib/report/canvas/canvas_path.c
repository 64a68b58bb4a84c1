/* Paths in the making. */
#include "report/canvas/canvas_path.h"

#include "base/memory.h"

#include <string.h>

void km_canvas_path_free(km_canvas_path *path) {
  km_free(path->commands);
  km_free(path->points);
  *path = (km_canvas_path){0};
}

void km_canvas_path_clear(km_canvas_path *path) {
  path->command_count = path->point_count = 0;
}

int km_canvas_path_takes(char command) {
  return command == 'Z' ? 0 : command == 'Q' ? 2 : command == 'C' ? 3 : 1;
}

void km_canvas_path_add(km_canvas_path *path, char command, const km_canvas_point *points) {
  size_t count = (size_t)km_canvas_path_takes(command);
  void *all = path->points, *commands = path->commands;
  if (!km_reserve(&all, &path->point_room, path->point_count + count, sizeof *points) ||
      !km_reserve(&commands, &path->command_room, path->command_count + 1, 1))
    path->failed = true;
  path->points = all;
  path->commands = commands;
  if (path->failed)
    return;
  path->commands[path->command_count++] = command;
  if (count)
    memcpy(path->points + path->point_count, points, count * sizeof *points);
  path->point_count += count;
}

void km_canvas_path_rectangle(km_canvas_path *path, double x, double y, double width, double height) {
  const km_canvas_point corners[] = {{x, y}, {x + width, y}, {x + width, y + height}, {x, y + height}};
  for (int i = 0; i < 4; ++i)
    km_canvas_path_add(path, i ? 'L' : 'M', &corners[i]);
  km_canvas_path_add(path, 'Z', NULL);
}

/* Four quarters, each a cubic that leaves the circle by 3e-4 of the radius at most. */
void km_canvas_path_circle(km_canvas_path *path, km_canvas_point centre, double radius) {
  const double handle = 0.5522847498 * radius; /* 4/3 (√2 − 1) */
  const double x = centre.x, y = centre.y, r = radius, h = handle;
  const km_canvas_point begin = {x + r, y};
  const km_canvas_point quarters[4][3] = {{{x + r, y + h}, {x + h, y + r}, {x, y + r}},
                                          {{x - h, y + r}, {x - r, y + h}, {x - r, y}},
                                          {{x - r, y - h}, {x - h, y - r}, {x, y - r}},
                                          {{x + h, y - r}, {x + r, y - h}, {x + r, y}}};
  km_canvas_path_add(path, 'M', &begin);
  for (int i = 0; i < 4; ++i)
    km_canvas_path_add(path, 'C', quarters[i]);
  km_canvas_path_add(path, 'Z', NULL);
}
