/* folder.h -- the files of a folder as inputs. */
#ifndef SINEW_TOOLS_FOLDER_H
#define SINEW_TOOLS_FOLDER_H

#include "cli.h"

bool folder_is(const char *path);
/* The files whose names are wanted, as FOLDER/NAME, by the bytes of their names; count 0: there is none. */
SN_MUST_CHECK sn_status folder_list(const char *folder, bool (*wanted)(const char *name), char ***paths, int *count, sn_error *error);
void folder_free(char **paths, int count); /* NULL is fine */

#endif
