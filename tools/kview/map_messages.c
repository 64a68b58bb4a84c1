/* Maps over two drivers: the configurations of the grid, and the singularity curves. */
#include "kview/messages.h"
#include "kview/server/time_limit.h"

#include "kmech/space.h"

enum { MOST_STEPS = 200 };

static km_status add_table(const kv_call *call, const char *what, const char *note, const km_table *table,
                           km_error *error) {
  km_text header = {0};
  km_text_format(&header, "{\"question\":\"%s\",\"driver\":-1,\"branches\":0,\"stopped\":\"\"", what);
  kv_add_columns(table, &header);
  km_text_add(&header, ",\"events\":[],\"notes\":[");
  if (note)
    kv_add_string(&header, note);
  km_text_add(&header, "]}");
  km_status status = kv_add_table(call, &header, table, error);
  km_text_free(&header);
  return status;
}

/* Message `map DRIVER DRIVER FROM TO FROM TO STEPS`: the cells over both ranges, of the sheets that are finished within
 * the limit of time. */
km_status kv_map(const kv_call *call, km_error *error) {
  kv_session *s = call->session;
  km_space_map_def def = {0};
  km_all_modes modes = {0};
  km_space_map map = {0};
  kv_limit limit = kv_limit_begin();
  int steps = kv_index(call, 6);
  if (steps > MOST_STEPS)
    return km_fail(error, KM_USAGE, "%d steps are more than a page shows; expected up to %d", steps, MOST_STEPS);
  for (int d = 0; d < 2; ++d)
    def.axis[d] = (km_space_axis){.coordinate = kv_index(call, d),
                                  .from = call->arguments[2 + 2 * d],
                                  .to = call->arguments[3 + 2 * d],
                                  .steps = steps};
  km_status status = km_map_modes_find(s->mechanism, s->state, def.axis[0].coordinate, def.axis[1].coordinate, 1,
                                       kv_limit_goes_on, &limit, &modes, error);
  if (!status)
    status = km_space_map_compute(s->mechanism, s->state, &def, &modes, kv_limit_goes_on, &limit, &map, error);
  const char *note = modes.is_complete ? NULL : "There may be further sheets.";
  if (status == KM_CANCELLED && map.cells && km_table_rows(map.cells) > 0) { /* the finished sheets */
    note = "Sheets and curves are missing: the map took too long; state fewer steps or a smaller range.";
    status = KM_OK;
  }
  status = kv_limit_report(status, "the map", error);
  if (!status)
    status = add_table(call, "map", note, map.cells, error);
  if (!status) {
    km_table_free(s->singular);
    s->singular = map.curves;
    map.curves = NULL;
  }
  km_all_modes_free(&modes);
  km_space_map_free(&map);
  return status;
}

/* singular: the singularity curves of the drivers, of the last map. */
km_status kv_singular(const kv_call *call, km_error *error) {
  const km_table *curves = call->session->singular;
  return curves ? add_table(call, "singular", NULL, curves, error)
                : km_fail(error, KM_USAGE, "there is no map yet, whose singularity curves could be told");
}
