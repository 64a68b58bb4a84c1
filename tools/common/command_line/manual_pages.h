/* Manual pages and bash completions from tables of options: `kmob sweep --help=man`, `--help=completion`. */
#ifndef KT_COMMON_COMMAND_LINE_MANUAL_PAGES_H
#define KT_COMMON_COMMAND_LINE_MANUAL_PAGES_H

#include "common/common.h"

/* Prints the page of a command ("kmob sweep") that the word behind `--help=` names. False: there is none. */
bool kt_page_print(const kt_options *options, const char *command, const char *about, const char *word);
/* Manual page or completion of a tool; `commands` lists its commands, one per line. */
bool kt_page_print_tool(const char *tool, const char *about, const kt_command *commands, const char *word);

#endif
