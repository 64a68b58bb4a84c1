/* The names, units and values of the transmission metrics. */
#include "report/record/transmission_record.h"

#include "report/record/sweep_text.h"
#include "topology/mechanism.h"
#include "transfer/transmission_metrics.h"

void km_transmission_list(const km_mechanism *m, const km_transmission *t, const km_port *output,
                          km_named_metric out[KM_TRANSMISSION_METRICS]) {
  static const char *const words[KM_TRANSMISSION_METRICS] = {"transmission angle",    "virtual coefficient",
                                                             "Sutherland-Roth index", "Chen-Angeles index",
                                                             "manipulability",        "condition number"};
  const km_metric *const metrics[KM_TRANSMISSION_METRICS] = {
      &t->angle, &t->virtual_coefficient, &t->sutherland_roth, &t->chen_angeles, &t->manipulability, &t->condition};
  for (int i = 0; i < KM_TRANSMISSION_METRICS; ++i)
    out[i] =
        (km_named_metric){km_transmission_name(i), words[i], km_transmission_unit(m->model, output, i), metrics[i]};
}

void km_transmission_record(const km_mechanism *m, const km_transmission *t, const km_port *output, km_value *record,
                            km_arena *arena) {
  km_named_metric list[KM_TRANSMISSION_METRICS];
  km_value *all = km_value_add(arena, record, "transmission", KM_OBJECT);
  km_transmission_list(m, t, output, list);
  for (int i = 0; i < KM_TRANSMISSION_METRICS && !arena->failed; ++i) {
    km_value *item = km_value_add(arena, all, list[i].name, KM_OBJECT);
    km_value_number(arena, item, "value", list[i].metric->value);
    if (list[i].metric->why)
      km_value_string(arena, item, "undefined", list[i].metric->why);
    if (list[i].unit[0])
      km_value_string(arena, item, "unit", list[i].unit);
  }
  km_value *wrench = km_value_add(arena, all, "wrench", KM_OBJECT);
  if (t->no_wrench) {
    km_value_add(arena, wrench, "value", KM_NULL);
    km_value_string(arena, wrench, "undefined", t->no_wrench);
  } else {
    km_value_numbers(arena, wrench, "value", t->wrench, 6);
  }
}

void km_transmission_print(const km_mechanism *m, const km_transmission *t, const km_port *output, km_text *out) {
  km_named_metric list[KM_TRANSMISSION_METRICS];
  km_transmission_list(m, t, output, list);
  km_text_add(out, "\ntransmission\n");
  for (int i = 0; i < KM_TRANSMISSION_METRICS; ++i) {
    km_text_add(out, "  ");
    km_text_padded(list[i].words, 26, out);
    if (list[i].metric->why)
      km_text_format(out, "  undefined: %s\n", list[i].metric->why);
    else
      km_text_format(out, "  %.6g%s%s\n", list[i].metric->value, list[i].unit[0] ? " " : "", list[i].unit);
  }
}
