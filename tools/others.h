/* others.h -- simulate's work on some muscles of many: which are wanted, which they need, and those that go as an earlier run had them. */
#ifndef SINEW_TOOLS_OTHERS_H
#define SINEW_TOOLS_OTHERS_H

#include "cli.h"
#include "sinew/scene.h"

typedef struct other_choices {
    cli_list muscles;   /* names, with * and ?; none: all muscles */
    const char *frozen; /* folder of an earlier run's frames; NULL: whatever is tied to the wanted ones is stepped, too */
} other_choices;

/* Leave out of the scene what the wanted muscles do not need, and freeze or hide the others. SN_ERROR_INPUT, SN_ERROR_IO: a muscle that is
 * tied to one of them has no frames in the folder, or such as do not fit. Names that match no muscle are wrong usage. */
SN_MUST_CHECK sn_status others_apply(const cli *c, const other_choices *with, sn_scene *scene, sn_error *error);

/* Leave out of the scene all muscles but those that some name matches; no names: none. As usage as above. */
SN_MUST_CHECK sn_status others_leave_out(const cli *c, const cli_list *names, sn_scene *scene, sn_error *error);

#endif
