/* Compares messages of readers about a text. */
#include "support/refusals.h"

#include <string.h>

bool is_told(const told_text *text, km_status status, km_status expected, const km_messages *messages,
             const km_error *error) {
  bool found = status && strstr(error->text, text->words);
  for (size_t i = 0; i < km_messages_count(messages); ++i)
    found = found || strstr(km_messages_text(messages, i), text->words);
  if (found && status == expected)
    return true;
  print_error("%s\nisn't told of \"%s\" with status %d, but with %d: %s\n", text->text, text->words, (int)expected,
              (int)status, status ? error->text : "");
  for (size_t i = 0; i < km_messages_count(messages); ++i)
    print_error("  %s\n", km_messages_text(messages, i));
  return false;
}

void assert_models_told(const told_text *list, size_t count, bool refused) {
  int silent = 0;
  for (size_t i = 0; i < count; ++i) {
    km_model *model = NULL;
    km_mechanism *mechanism = NULL;
    km_state *state = NULL;
    km_error error = {.text = ""};
    km_messages *messages = km_messages_create();
    km_status status = km_model_read(list[i].text, strlen(list[i].text), messages, &model, &error);
    if (!status)
      status = km_mechanism_compile(model, NULL, 0, &mechanism, &error);
    if (!status)
      status = km_state_create(mechanism, &state, &error);
    if (!status)
      status = km_assemble(mechanism, state, NULL, &error);
    silent += !is_told(&list[i], status, refused ? KM_MODEL : KM_OK, messages, &error);
    km_state_free(state);
    km_mechanism_free(mechanism);
    km_model_free(model);
    km_messages_free(messages);
  }
  assert_int_equal(silent, 0);
}
