/* ksim run --rate: the joints' rates at the start, and whether the motion has them. */
#include "ksim/ksim.h"

#include "kmech/base.h"
#include "kmech/inspect.h"
#include "kmech/model.h"

enum { MOST_TOLD = 8 };

/* Rates that agree to three digits are consistent; larger differences are contradictions. */
static const double rounded = 1e-3;

kt_exit ksim_set_rates(ksim_work *w) {
  const ksim_options *o = w->options;
  kt_exit result = KT_DONE;
  if (o->rates.count > 0 && o->from)
    return kt_usage(&o->common, "--from", "a table beside --rate", "one of them: both give the rates");
  for (int i = 0; i < (int)o->rates.count && result == KT_DONE; ++i) {
    const char *rest = o->rates.items[i];
    int coordinate = -1;
    double rate;
    km_error error;
    kt_piece label = kt_split(&rest, "=");
    if (label.separator != '=')
      result = kt_usage(&o->common, "--rate", o->rates.items[i], "JOINT=RATE, as A=60rpm or A=2.5");
    else
      result = kt_coordinate(&o->common, w->pose.model, "--rate", label.text, &coordinate);
    km_free(label.text);
    if (result == KT_DONE && !ksim_read_rate(w->pose.model, coordinate, rest, &rate))
      result = kt_usage(&o->common, "--rate", o->rates.items[i],
                        "a rate in the model's unit per time unit, or of an angle in rpm");
    if (result != KT_DONE)
      continue;
    km_status status = km_state_set_rate(w->pose.mechanism, w->pose.state, coordinate, rate, &error);
    if (status)
      kt_print_message(&o->common, KM_ERROR, "--rate %s: %s", o->rates.items[i], error.text);
    result = kt_exit_of(status);
  }
  return result;
}

/* "A starts at 5 instead of 6 deg/s, …", of the rates of one source. */
static void list_changed(const ksim_work *w, bool by_model, km_text *out) {
  const km_history *h = &w->history;
  const km_model *model = w->pose.model;
  int count = 0;
  for (int i = 0; i < h->changed_rate_count; ++i) {
    const km_changed_rate *r = &h->changed_rates[i];
    if (r->by_model == by_model && ++count <= MOST_TOLD)
      km_text_format(out, "%s%s starts at %.6g instead of %.6g %s/%s", count > 1 ? ", " : "",
                     km_model_coordinate_label(model, r->coordinate), r->start, r->stated,
                     km_model_coordinate_unit(model, r->coordinate), km_model_units(model).time->suffix);
  }
  if (count > MOST_TOLD)
    km_text_format(out, ", and %d more", count - MOST_TOLD);
}

kt_exit ksim_report_rates(const ksim_work *w) {
  const ksim_options *o = w->options;
  const km_history *h = &w->history;
  bool of_model = true;
  for (int i = 0; i < h->changed_rate_count; ++i)
    of_model = of_model && h->changed_rates[i].by_model;
  if (h->changed_rate_count == 0)
    return KT_DONE;
  bool replaced = of_model && (o->rates.count > 0 || km_table_span(h->table, "f.").count > 0);
  bool contradict = !replaced && h->rate_change > rounded;
  km_text list = {0};
  list_changed(w, of_model, &list);
  const char *names = list.data ? list.data : "";
  if (replaced)
    kt_print_message(
        &o->common, KM_NOTE,
        "%s: --rate and prescribed motions come before initial rates of the model that contradict them: %s", o->model,
        names);
  else if (contradict && h->changed_rate_count > 1)
    kt_print_message(
        &o->common, KM_WARNING,
        "%s: stated initial rates contradict each other: %s; state rates that the loops allow, or leave out those of "
        "joints that are to follow",
        o->model, names);
  else if (contradict)
    kt_print_message(&o->common, KM_WARNING, "%s: the loops don't allow a stated initial rate: %s", o->model, names);
  else
    kt_print_message(&o->common, KM_NOTE,
                     "%s: stated initial rates would open the loops; they are changed by %.3g of their size: %s",
                     o->model, h->rate_change, names);
  km_text_free(&list);
  return contradict ? KT_PARTIAL : KT_DONE;
}
