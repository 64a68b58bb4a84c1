/* Stated initial rates that the motion doesn't start with. */
#include "ksim/ksim.h"

#include "kmech/base.h"
#include "kmech/inspect.h"
#include "kmech/model.h"

enum { MOST_TOLD = 8 };

/* Rates that agree to three digits are consistent; larger differences are contradictions. */
static const double rounded = 1e-3;

/* "A starts at 5 instead of 6 deg/s, …", of the rates of one source. */
static void list_changed(const km_model *model, const km_history *h, bool by_model, km_text *out) {
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

kt_exit ksim_report_rates(const kt_sweep_job *j, const km_history *h) {
  const kt_common *common = &j->common;
  bool of_model = true;
  for (int i = 0; i < h->changed_rate_count; ++i)
    of_model = of_model && h->changed_rates[i].by_model;
  if (h->changed_rate_count == 0)
    return KT_DONE;
  bool replaced =
      of_model && (kt_question_given(&j->options->asked, "rate") || km_table_span(h->table, "f.").count > 0);
  bool contradict = !replaced && h->rate_change > rounded;
  km_text list = {0};
  list_changed(j->pose.model, h, of_model, &list);
  const char *names = list.data ? list.data : "";
  if (replaced)
    kt_print_message(
        common, KM_NOTE,
        "%s: --rate and prescribed motions come before initial rates of the model that contradict them: %s", j->name,
        names);
  else if (contradict && h->changed_rate_count > 1)
    kt_print_message(
        common, KM_WARNING,
        "%s: stated initial rates contradict each other: %s; state rates that the loops allow, or leave out those of "
        "joints that are to follow",
        j->name, names);
  else if (contradict)
    kt_print_message(common, KM_WARNING, "%s: the loops don't allow a stated initial rate: %s", j->name, names);
  else
    kt_print_message(common, KM_NOTE,
                     "%s: stated initial rates would open the loops; they are changed by %.3g of their size: %s",
                     j->name, h->rate_change, names);
  km_text_free(&list);
  return contradict ? KT_PARTIAL : KT_DONE;
}
