/* Shapes of bodies, part by part. */
#include "kview/messages.h"

/* patch BODY PART */
km_status kv_patch(const kv_call *c, km_error *error) {
  km_surface_patch patch;
  km_text *out = &c->answer->bytes;
  km_status status = km_body_patch(c->session->model, kv_index(c, 0), kv_index(c, 1), &patch, error);
  if (!status) {
    c->answer->binary = true;
    kv_add_u32(out, KV_PATCH);
    kv_add_u32(out, c->request);
    kv_add_u32(out, (uint32_t)kv_index(c, 0));
    kv_add_u32(out, (uint32_t)patch.vertex_count);
    kv_add_u32(out, (uint32_t)patch.triangle_count);
    for (int k = 0; k < 4; ++k)
      kv_add_f32(out, patch.color[k]);
    for (int k = 0; k < 3 * patch.vertex_count; ++k)
      kv_add_f32(out, patch.vertices[k]);
    for (int k = 0; k < 3 * patch.triangle_count; ++k)
      kv_add_u32(out, (uint32_t)patch.triangles[k]);
  }
  km_surface_patch_free(&patch);
  return status;
}
