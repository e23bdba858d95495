/* resume.c -- outputs of an earlier run that a later one goes on with: whether they are that run's, and where they end. */
#include "sinew/io.h"

#include <stdio.h>
#include <sys/stat.h>

bool sn_resume_exists(const char *path) {
    struct stat info;
    return stat(path, &info) == 0 && S_ISREG(info.st_mode) && info.st_size > 0;
}

static const char *hint = "name another file or folder to begin one there";

sn_status sn_resume_take(sn_resume *resume, const char *path, int64_t first, int64_t last, bool *goes_on, sn_error *error) {
    long frame = resume->frame, next = resume->next;
    *goes_on = false;
    if (first == next || last < first) return SN_OK;
    if (first > next)
        return sn_fail_at(error, SN_ERROR_USAGE, path, 0, "begins with frame %lld, and the run goes on with frame %ld; %s",
                          (long long)first, next, hint);
    if (last < frame)
        return sn_fail_at(error, SN_ERROR_USAGE, path, 0, "ends with frame %lld, before the state's frame %ld; %s", (long long)last, frame,
                          hint);
    if (resume->continued > 0 && first != resume->first)
        return sn_fail_at(error, SN_ERROR_USAGE, path, 0, "begins with frame %lld, but %s with frame %ld: they are not of one run; %s",
                          (long long)first, resume->name, (long)resume->first, hint);
    if (resume->continued++ == 0) snprintf(resume->name, sizeof resume->name, "%s", path);
    resume->first = (sn_index)first;
    if (last > resume->reached) resume->reached = (sn_index)last;
    *goes_on = true;
    return SN_OK;
}

sn_status sn_resume_differs(const sn_resume *resume, const char *path, sn_error *error) {
    return sn_fail_at(error, SN_ERROR_USAGE, path, 0, "its frame %ld is not that of the state: it is of another run; %s",
                      (long)resume->frame, hint);
}
