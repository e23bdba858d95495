/* earlier.h -- outputs of the run that simulate --from goes on with: whether they are that run's, and where they end. */
#ifndef SINEW_TOOLS_EARLIER_H
#define SINEW_TOOLS_EARLIER_H

#include "cli.h"
#include "sinew/sim.h"

/* Open the log behind what it holds until the state's frame; *out NULL: there is none to go on with. Each frame has a line of each muscle.
 */
SN_MUST_CHECK sn_status earlier_log(const char *path, const sn_model *model, sn_resume *resume, sn_output **out, sn_error *error);
/* Is there a sequence PREFIX.0000.ply to go on with (*goes_on)? mesh: as the state has it, which the file of its frame must hold. */
SN_MUST_CHECK sn_status earlier_sequence(const char *prefix, const sn_mesh *mesh, sn_resume *resume, bool *goes_on, sn_error *error);
/* Of outputs that belong together either all are gone on with, or none: `continued` of `count`, in a folder or beside a file at path. */
SN_MUST_CHECK sn_status earlier_whole(const char *path, sn_index continued, sn_index count, sn_error *error);

#endif
