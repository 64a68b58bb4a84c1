/* Bodies by their meshes: which faces the viewer sees, how light they are, and which edges show. */
#include "report/canvas/palette.h"
#include "report/drawing/drawing_parts.h"

#include <stdlib.h>

static const double sharp = 0.9;    /* cosine of the angle between faces from which the edge between them shows */
static const double edge_on = 1e-6; /* rounding of a face's normal: smaller differences are invisible */

typedef struct edge {
  int low, high; /* vertices */
  int triangle, side;
} edge;

static int by_vertices(const void *x, const void *y) {
  const edge *a = x, *b = y;
  if (a->low != b->low)
    return a->low - b->low;
  return a->high != b->high ? a->high - b->high : a->triangle - b->triangle;
}

static km_vec3 area_of(const km_mesh *mesh, int triangle) {
  const int *c = mesh->triangles[triangle].corner;
  km_vec3 a = mesh->vertices[c[0]];
  return km_vec3_cross(km_vec3_sub(mesh->vertices[c[1]], a), km_vec3_sub(mesh->vertices[c[2]], a));
}

static bool is_sharp(const km_mesh *mesh, int triangle, int other) {
  km_vec3 a = area_of(mesh, triangle), b = area_of(mesh, other);
  return !(km_vec3_dot(a, b) > sharp * km_vec3_norm(a) * km_vec3_norm(b));
}

static bool runs_up(const km_mesh *mesh, const edge *e) {
  return mesh->triangles[e->triangle].corner[e->side] == e->low;
}

/* `edges` are sorted: those of one place follow each other. */
static void mark_edges(km_surface *surface, const edge *edges, int count) {
  surface->closed = true;
  for (int i = 0, end; i < count; i = end) {
    for (end = i + 1; end < count && edges[end].low == edges[i].low && edges[end].high == edges[i].high;)
      ++end;
    bool pair = end == i + 2 && runs_up(surface->mesh, &edges[i]) != runs_up(surface->mesh, &edges[i + 1]);
    surface->closed = surface->closed && pair;
    if (pair && !is_sharp(surface->mesh, edges[i].triangle, edges[i + 1].triangle))
      continue;
    for (int k = i; k < end; ++k)
      surface->shown[edges[k].triangle] |= (unsigned char)(1U << edges[k].side);
  }
}

/* Six times the volume: negative where the faces look inwards. */
static double volume_of(const km_mesh *mesh) {
  double volume = 0.0;
  for (int t = 0; t < mesh->triangle_count; ++t)
    volume +=
        km_vec3_dot(area_of(mesh, t), km_vec3_sub(mesh->vertices[mesh->triangles[t].corner[0]], mesh->vertices[0]));
  return volume;
}

static void make_surface(const km_mesh *mesh, km_surface *out, km_arena *arena) {
  int count = 3 * mesh->triangle_count;
  edge *edges = KM_ARENA_NEW(arena, edge, (size_t)count);
  *out = (km_surface){.mesh = mesh, .shown = KM_ARENA_NEW(arena, unsigned char, (size_t)mesh->triangle_count)};
  if (arena->failed)
    return;
  for (int i = 0; i < count; ++i) {
    const int *c = mesh->triangles[i / 3].corner;
    int a = c[i % 3], b = c[(i + 1) % 3];
    edges[i] = (edge){a < b ? a : b, a < b ? b : a, i / 3, i % 3};
  }
  qsort(edges, (size_t)count, sizeof *edges, by_vertices);
  mark_edges(out, edges, count);
  out->inwards = volume_of(mesh) < 0.0;
}

km_surface *km_surfaces_make(const km_drawing_def *drawing, km_arena *arena) {
  int bodies = drawing->mechanism->model->body_count;
  km_surface *surfaces = KM_ARENA_NEW(arena, km_surface, (size_t)bodies);
  for (int b = 0; surfaces && drawing->meshes && b < bodies && !arena->failed; ++b)
    if (drawing->meshes[b])
      make_surface(drawing->meshes[b], &surfaces[b], arena);
  return surfaces;
}

/* Light comes from the upper left, over the viewer's shoulder. */
static double shade_of(km_spot normal) {
  const km_spot light = {-0.41, -0.57, 0.71};
  return fmax(0.0, normal.x * light.x + normal.y * light.y + normal.depth * light.depth);
}

static km_face *face_of(const km_scene *scene, int body, int triangle) {
  const km_surface *surface = &scene->surfaces[body];
  const km_triangle *t = &surface->mesh->triangles[triangle];
  km_vec3 area = area_of(surface->mesh, triangle);
  double size = (surface->inwards ? -1.0 : 1.0) * km_vec3_norm(area);
  km_spot normal = km_project_direction(
      scene->view, km_rotate(&scene->pose[body].R, km_vec3_scale(size != 0.0 ? 1.0 / size : 0.0, area)));
  if (fabs(normal.depth) < edge_on || (surface->closed && normal.depth < 0.0))
    return NULL;
  if (normal.depth < 0.0) /* an open surface is seen from both sides */
    normal = (km_spot){-normal.x, -normal.y, -normal.depth};
  km_face *face = KM_ARENA_NEW(scene->arena, km_face, 1);
  km_spot *spots = face ? KM_ARENA_NEW(scene->arena, km_spot, 3) : NULL;
  if (!spots)
    return NULL;
  for (int k = 0; k < 3; ++k)
    spots[k] = km_project(scene->view, km_pose_point(&scene->pose[body], surface->mesh->vertices[t->corner[k]]));
  *face = (km_face){.body = body,
                    .color = t->color,
                    .spots = spots,
                    .count = 3,
                    .shown = surface->shown[triangle],
                    .normal = normal,
                    .shade = shade_of(normal)};
  return face;
}

void km_scene_add_faces(km_scene *scene) {
  km_face **end = &scene->faces;
  for (int b = 1; b < scene->mechanism->model->body_count; ++b) {
    const km_mesh *mesh = scene->surfaces[b].mesh;
    for (int t = 0; mesh && t < mesh->triangle_count; ++t) {
      km_face *face = face_of(scene, b, t);
      if (!face)
        continue;
      *end = face;
      end = &face->next;
    }
  }
  scene->faces = km_faces_order(scene->faces, scene->arena);
}

static km_colour colour_of(const km_scene *scene, const km_face *face) {
  unsigned code = face->color;
  if (code == 0)
    return km_palette_colour(scene->shapes[face->body].colour);
  return (km_colour){(code >> 16 & 255U) / 255.0, (code >> 8 & 255U) / 255.0, (code & 255U) / 255.0, 1};
}

void km_face_paint(const km_scene *scene, km_canvas *canvas, const km_face *face) {
  enum { MOST_CORNERS = 32 + 1 };
  static const km_colour white = {1, 1, 1, 1}, black = {0.1, 0.1, 0.1, 1};
  km_canvas_point points[MOST_CORNERS];
  km_colour body = colour_of(scene, face);
  km_colour light = km_mix(body, white, 0.62), dark = km_mix(body, black, 0.35);
  km_colour fill = km_faded(scene, km_mix(dark, light, face->shade));
  km_pen seam = {.colour = fill, .width = 0.5},
         rim = {.colour = km_faded(scene, km_mix(body, black, 0.6)), .width = 0.13 * scene->radius};
  for (int i = 0; i <= face->count; ++i)
    points[i] = (km_canvas_point){face->spots[i % face->count].x, face->spots[i % face->count].y};
  km_canvas_polygon(canvas, fill, points, (size_t)face->count);
  /* Adjacent faces of one colour overlap slightly, otherwise the page would be visible between them. */
  km_canvas_polyline(canvas, &seam, points, (size_t)face->count + 1);
  for (int i = 0; i < face->count; ++i)
    if (face->shown >> i & 1U)
      km_canvas_line(canvas, &rim, points[i], points[i + 1]);
}
