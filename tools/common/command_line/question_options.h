/* The options of a question on the command line: from the library's table to its typed values. */
#ifndef KT_COMMON_COMMAND_LINE_QUESTION_OPTIONS_H
#define KT_COMMON_COMMAND_LINE_QUESTION_OPTIONS_H

#include "common/pose.h"
#include "kmech/question.h"

enum { KT_MOST_ASKED = 24, KT_ASKED_HELP = 400 };

/* A kind of question, and its options as they were given. */
typedef struct kt_question {
  int kind;
  int count;
  const km_option *options[KT_MOST_ASKED];
  char help[KT_MOST_ASKED][KT_ASKED_HELP];
  const char *names[KT_MOST_ASKED]; /* name in messages: "--joint" */
  char name_texts[KT_MOST_ASKED][32];
  bool flags[KT_MOST_ASKED];
  kt_texts texts[KT_MOST_ASKED];
} kt_question;

/* Adds the options of a kind of question; of one about a single pose (`motion` false) those of the motion aren't
 * there. `asked` must outlive `out`. */
void kt_question_options(kt_options *out, kt_question *asked, const char *kind, bool motion);
/* Only some of them: `names`, NULL behind the last. */
void kt_question_some(kt_options *out, kt_question *asked, const char *kind, const char *const *names);
/* True if the option is on the command line. */
bool kt_question_given(const kt_question *asked, const char *option);
/* Value of an option; NULL if the question has no option of this name. */
kt_texts *kt_question_texts(kt_question *asked, const char *option);
/* Sets an option for the command, if the question has it. */
void kt_question_set(kt_question *asked, const char *option);
/* The value of this option was given by another one, which messages name: "--point". */
void kt_question_call(kt_question *asked, const char *option, const char *name);
/* Another help than the library's, for an option whose text can say more on a command line. */
void kt_question_explain(kt_options *out, const char *option, const char *argument, const char *help);

/* Makes the question about a model at its pose, with all its options. Says what is wrong. The caller frees `*out`. */
kt_exit kt_compute_question(const kt_common *common, const char *path, const kt_question *asked, const kt_pose *pose,
                            km_question **out);

/* Says a text of a question's, where the names of options stand in `backquotes`; `path` may be NULL. */
void kt_print_messages(const kt_common *common, km_severity severity, const char *path, const char *text);

/* Reads what was given for one option; what its value points at goes to the arena. Says what is wrong. */
kt_exit kt_question_value(const kt_common *common, const km_model *model, const km_option *option, const char *name,
                          const kt_texts *texts, km_arena *arena, km_option_value *out);
/* As kt_question_value for an option by its name; zero if it isn't on the command line. */
kt_exit kt_question_read(const kt_common *common, const km_model *model, const kt_question *asked, const char *option,
                         km_arena *arena, km_option_value *out);
/* An end of a leverage: a joint, or BODY/FRAME:DX,DY,DZ. */
kt_exit kt_end(const kt_common *common, const km_model *model, const char *option, const char *text, km_arena *arena,
               km_port *out);
/* Start of the direction of a point; NULL if it has none. */
const char *kt_direction(const char *text);
/* All loads that act: the model's own, as changed and added to by --load. */
kt_exit kt_loads(const kt_common *common, const km_model *model, const kt_texts *texts, km_arena *arena,
                 km_option_value *out);

#endif
