/* The plot of mechanical advantage over a sweep: which lines, marks and poles. */
#include "report/charts/advantage_plot.h"

#include "report/plot/short_names.h"
#include "topology/mechanism.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

const char *km_advantage_toggle_name(const km_advantage_toggle *toggle) {
  return toggle->state == KM_ADVANTAGE_ZERO ? "MA 0" : toggle->state == KM_ADVANTAGE_INFINITE ? "MA ∞" : "undefined";
}

size_t km_advantage_column(const km_advantage_sweep *sweep, bool friction) {
  return km_table_span(sweep->motion.table, friction ? "force_ratio." : "ma.").first;
}

static const char *text_in(km_arena *arena, const char *format, const char *a, const char *b) {
  char text[800];
  snprintf(text, sizeof text, format, a, b);
  return km_arena_string(arena, text);
}

/* The extreme of a single sweep, if it is finite, named with its value. */
static size_t mark_peak(km_arena *arena, const char *word, const km_peak *peak, km_swept_mark *out) {
  char number[40];
  if (!isfinite(peak->value) || !isfinite(peak->s))
    return 0;
  snprintf(number, sizeof number, "%s%.4g", peak->value < 0.0 ? "−" : "", fabs(peak->value));
  *out = (km_swept_mark){0, 0, peak->s, text_in(arena, "%s %s", word, number)};
  return 1;
}

bool km_advantage_plot_make(const km_plotted_advantage *sweeps, int count, bool ordered, bool strip, km_arena *arena,
                            km_plot *out) {
  const km_advantage_sweep *first = sweeps[0].sweep;
  const char *unit = km_advantage_unit(sweeps[0].swept.mechanism->model, &first->input, &first->output);
  size_t marks = 0, gaps = 0, lines = 0;
  for (int i = 0; i < count; ++i)
    marks += sweeps[i].sweep->toggle_count;
  km_swept *swept = KM_ARENA_NEW(arena, km_swept, (size_t)count);
  km_swept_line *line = KM_ARENA_NEW(arena, km_swept_line, 2 * (size_t)count);
  km_swept_mark *mark = KM_ARENA_NEW(arena, km_swept_mark, marks + 2);
  km_swept_break *gap = KM_ARENA_NEW(arena, km_swept_break, 2 * marks);
  const char **models = km_short_names_of(&sweeps[0].swept.name, sizeof *sweeps, count, arena);
  if (arena->failed)
    return false;
  marks = 0;
  for (int i = 0; i < count; ++i) {
    const km_advantage_sweep *s = sweeps[i].sweep;
    swept[i] = sweeps[i].swept;
    line[lines++] = (km_swept_line){i, km_advantage_column(s, false),
                                    text_in(arena, "%.300s/%.300s", s->input.name, s->output.name), 0};
    if (count > 1)
      line[lines - 1].name = text_in(arena, "%.300s (%.300s)", line[lines - 1].name, models[i]);
    if (s->friction) {
      line[lines] = (km_swept_line){i, km_advantage_column(s, true),
                                    text_in(arena, "%s%s", line[lines - 1].name, " with friction"), 0};
      ++lines;
    }
    for (size_t k = 0; k < s->toggle_count; ++k) {
      mark[marks++] = (km_swept_mark){i, 0, s->toggles[k].s, km_advantage_toggle_name(&s->toggles[k])};
      for (int friction = 0; friction <= s->friction && s->toggles[k].state == KM_ADVANTAGE_INFINITE; ++friction)
        gap[gaps++] = (km_swept_break){i, km_advantage_column(s, friction), s->toggles[k].s};
    }
  }
  size_t toggles = marks;
  if (count == 1) {
    marks += mark_peak(arena, "min", &first->lowest, &mark[marks]);
    marks += mark_peak(arena, "max", &first->highest, &mark[marks]);
  }
  km_sweep_picture picture = {
      .title = text_in(arena, "Mechanical advantage of %.300s over %.300s", first->input.name, first->output.name),
      .note = toggles ? "▲ a dead point: MA 0 or infinite" : NULL,
      .y_label = unit[0] ? text_in(arena, "mechanical advantage (%s)%s", unit, "") : "mechanical advantage",
      .sweeps = swept,
      .sweep_count = count,
      .ordered = ordered,
      .lines = line,
      .line_count = lines,
      .marks = mark,
      .mark_count = marks,
      .breaks = gap,
      .break_count = gaps,
      .panel_count = 1,
      .strip = strip};
  return !arena->failed && km_sweep_plot_make(&picture, arena, out);
}
