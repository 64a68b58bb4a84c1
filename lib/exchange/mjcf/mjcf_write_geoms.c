/* Shapes of bodies as geoms without mass and contact. */
#include "exchange/mjcf/mjcf_write.h"

#include "model/validation.h"

static const char *mesh_name(km_written *w, const km_model_shape *shape, int index) {
  return km_written_text(w, "%s:%d", w->bodies[shape->body], index);
}

void km_mjcf_write_assets(km_written *w) {
  km_xml_begin(&w->xml, "asset");
  for (int b = 1; b < w->model->body_count; ++b) {
    int count;
    const km_model_shape *shapes = km_written_shapes(w, b, &count);
    for (int i = 0; i < count; ++i) {
      if (shapes[i].kind != KM_SHAPE_OF_MESH)
        continue;
      km_xml_begin(&w->xml, "mesh");
      km_xml_set(&w->xml, "name", mesh_name(w, &shapes[i], i));
      km_xml_set(&w->xml, "file", shapes[i].mesh);
      km_xml_set_numbers(&w->xml, "scale", shapes[i].scale, 3, false);
      km_xml_end(&w->xml, "mesh");
    }
  }
  km_xml_end(&w->xml, "asset");
}

/* Sizes are halves, but for radii. */
static void set_size(km_written *w, const km_model_shape *shape) {
  double size[3];
  for (int k = 0; k < 3; ++k)
    size[k] = (k == 0 && shape->kind != KM_SHAPE_BOX ? 1.0 : 0.5) * shape->size[k];
  km_xml_set_numbers(&w->xml, "size", size, km_shape_sizes(shape->kind), false);
}

static void add_geom(km_written *w, const km_model_shape *shape, int index) {
  const double none = 0.0;
  km_xml_begin(&w->xml, "geom");
  km_xml_set(&w->xml, "type", km_shape_word(shape->kind));
  if (shape->kind == KM_SHAPE_OF_MESH)
    km_xml_set(&w->xml, "mesh", mesh_name(w, shape, index));
  else
    set_size(w, shape);
  km_mjcf_set_pose(w, &shape->pose);
  if (shape->color[3] >= 0.0)
    km_xml_set_numbers(&w->xml, "rgba", shape->color, 4, false);
  km_xml_set_numbers(&w->xml, "mass", &none, 1, false);
  km_xml_set(&w->xml, "contype", "0");
  km_xml_set(&w->xml, "conaffinity", "0");
  km_xml_end(&w->xml, "geom");
}

void km_mjcf_write_geoms(km_written *w, int body) {
  int count;
  const km_model_shape *shapes = km_written_shapes(w, body, &count);
  for (int i = 0; i < count; ++i)
    add_geom(w, &shapes[i], i);
}
