/*
 * stream.c -- whole files in, all or nothing out.
 *
 * A regular target is written as a file without a name in the target's folder (O_TMPFILE), flushed, then linked and renamed over the
 * target: a reader sees the old file or the new one, and a killed process leaves nothing behind. What cannot be renamed over (stdout,
 * devices, pipes) is held in memory until commit, so that a failure leaves it untouched; a line stream alone is written at once. What is
 * published (sn_output_publish) takes its name before it is whole, and grows there: that much of it outlives a killed process.
 */
#include "sinew/io.h"

#include "codec.h"
#include "scalar.h"

#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

enum { CHUNK = 1 << 16, ATTEMPTS = 100 };

/* Of what comes through a pipe, which may never end. */
static const size_t MOST_STREAMED = (size_t)2 << 30;

static bool is_standard(const char *path) { return !path || strcmp(path, "-") == 0; }

/* ---- input ---------------------------------------------------------------------------------------------------------- */

/* Read to the end of fd; size_hint is what the file system says, which a growing file or a pipe may belie. */
static sn_status read_all(int fd, size_t size_hint, size_t most, sn_blob *blob, sn_error *error) {
    size_t capacity = 0;
    if (!sn_grow((void **)&blob->data, &capacity, size_hint + 1, 1)) return sn_fail_memory(error, blob->name);
    for (;;) {
        if (blob->size + 1 == capacity && !sn_grow((void **)&blob->data, &capacity, capacity + CHUNK, 1)) {
            return sn_fail_memory(error, blob->name);
        }
        ssize_t got = read(fd, blob->data + blob->size, capacity - 1 - blob->size);
        if (got == 0) break;
        if (got < 0 && errno == EINTR) continue;
        if (got < 0) return sn_fail_at(error, SN_ERROR_IO, blob->name, 0, "cannot be read: %s", strerror(errno));
        blob->size += (size_t)got;
        if (blob->size > most)
            return sn_fail_at(error, SN_ERROR_INPUT, blob->name, 0, "does not end within %zu GB, the most that is read of a pipe; save it as a file",
                              most >> 30);
    }
    blob->data[blob->size] = '\0';
    return SN_OK;
}

/* As /dev/null is. */
static bool is_empty(int fd) {
    char byte;
    ssize_t got;
    while ((got = read(fd, &byte, 1)) < 0 && errno == EINTR) {}
    return got == 0;
}

static sn_status read_descriptor(int fd, sn_blob *blob, sn_error *error) {
    struct stat info;
    if (fstat(fd, &info) != 0) return sn_fail_at(error, SN_ERROR_IO, blob->name, 0, "cannot be read: %s", strerror(errno));
    if (S_ISDIR(info.st_mode)) return sn_fail_at(error, SN_ERROR_IO, blob->name, 0, "is a directory; name a file in it");
    if (S_ISREG(info.st_mode)) return read_all(fd, (size_t)info.st_size, SIZE_MAX, blob, error);
    bool device = S_ISBLK(info.st_mode) || (S_ISCHR(info.st_mode) && !isatty(fd));
    if (device && !is_empty(fd)) return sn_fail_at(error, SN_ERROR_INPUT, blob->name, 0, "is a device, which may not end; name a file");
    return read_all(fd, CHUNK, MOST_STREAMED, blob, error);
}

/* Does a text of two bytes a character begin here: with its byte order mark, or with letters between zeros? */
static bool is_wide_text(const char *data, size_t size) {
    const unsigned char *b = (const unsigned char *)data;
    if (size >= 2 && ((b[0] == 0xff && b[1] == 0xfe) || (b[0] == 0xfe && b[1] == 0xff))) return true;
    if (size < 8) return false;
    size_t zeros = b[0] == 0 ? 0 : 1;
    for (size_t i = 0; i < 8; i++) {
        bool letter = (b[i] >= ' ' && b[i] <= '~') || b[i] == '\t' || b[i] == '\r' || b[i] == '\n';
        if (i % 2 == zeros ? b[i] != 0 : !letter) return false;
    }
    return true;
}

static sn_status unpack(sn_blob *blob, sn_error *error) {
    const size_t base = (size_t)64 << 20, share = 64; /* what a packed file unpacks to must not fill the machine */
    char *data;
    size_t size;
    sn_status status = sn_gunzip(blob->data, blob->size, base + share * blob->size, &data, &size);
    if (status == SN_ERROR_MEMORY) return sn_fail_memory(error, blob->name);
    if (status != SN_OK)
        return sn_fail_at(error, SN_ERROR_INPUT, blob->name, 0,
                          "cannot be unpacked: the gzip file is damaged or cut short, or would be of more than %zu MB",
                          (base + share * blob->size) >> 20);
    free(blob->data);
    blob->data = data;
    blob->size = size;
    return SN_OK;
}

/* A text is read the same whether it is packed by gzip, begins with a byte order mark, or does not; but never as UTF-16. */
static sn_status unwrap(sn_blob *blob, sn_error *error) {
    sn_status status = sn_gzip_is(blob->data, blob->size) ? unpack(blob, error) : SN_OK;
    if (status != SN_OK || sn_stl_is_binary(blob->data, blob->size)) return status;
    if (is_wide_text(blob->data, blob->size))
        return sn_fail_at(error, SN_ERROR_INPUT, blob->name, 0, "is a text in UTF-16, which is not read; save it as UTF-8");
    size_t mark = sn_byte_order_mark(blob->data, blob->size);
    blob->size -= mark;
    if (mark > 0) memmove(blob->data, blob->data + mark, blob->size + 1);
    return SN_OK;
}

sn_status sn_blob_read_bytes(const char *path, sn_blob *out, sn_error *error) {
    *out = (sn_blob){0};
    bool standard = is_standard(path);
    out->name = sn_strdup(standard ? "<stdin>" : path);
    if (!out->name) return sn_fail_memory(error, "a file name");
    int fd = standard ? STDIN_FILENO : open(path, O_RDONLY | O_CLOEXEC);
    sn_status status =
        fd < 0 ? sn_fail_at(error, SN_ERROR_IO, path, 0, "cannot be opened: %s", strerror(errno)) : read_descriptor(fd, out, error);
    if (!standard && fd >= 0) close(fd);
    if (status != SN_OK) sn_blob_free(out);
    return status;
}

sn_status sn_blob_read(const char *path, sn_blob *out, sn_error *error) {
    sn_status status = sn_blob_read_bytes(path, out, error);
    if (status != SN_OK) return status;
    status = unwrap(out, error);
    if (status != SN_OK) sn_blob_free(out);
    return status;
}

sn_status sn_file_check(const char *path, sn_error *error) {
    struct stat info;
    if (stat(path, &info) != 0) return sn_fail_at(error, SN_ERROR_IO, path, 0, "cannot be opened: %s", strerror(errno));
    if (S_ISDIR(info.st_mode)) return sn_fail_at(error, SN_ERROR_IO, path, 0, "is a directory; name a file in it");
    if (S_ISREG(info.st_mode)) return SN_OK;
    return sn_fail_at(error, SN_ERROR_INPUT, path, 0, "is a device or a pipe, which may not end; a document names files");
}

sn_status sn_blob_read_named(const char *path, sn_blob *out, sn_error *error) {
    *out = (sn_blob){0};
    sn_status status = sn_file_check(path, error);
    return status == SN_OK ? sn_blob_read(path, out, error) : status;
}

void sn_blob_free(sn_blob *blob) {
    free(blob->name);
    free(blob->data);
    *blob = (sn_blob){0};
}

/* ---- output --------------------------------------------------------------------------------------------------------- */

struct sn_output {
    char *name;      /* as the user gave it, for messages */
    char *target;    /* what commit renames over, links resolved; NULL = written in place */
    char *temporary; /* its name until then; NULL = it has none yet (O_TMPFILE) */
    int fd;
    bool hold;        /* keep everything in memory until commit */
    bool stream;      /* whole lines go out at once */
    bool untruncated; /* a regular file written in place, whose old content goes with the first write, but for: */
    bool published;   /* it has its name already */
    uint64_t keep;    /* bytes of the old content that stay */
    char *buffer;
    size_t used, capacity;
    uint64_t written; /* bytes handed to fd */
    sn_error failure; /* the first one; code SN_OK = none */
};

static sn_status keep_failure(sn_output *output, sn_status code, const char *text) {
    if (output->failure.code == SN_OK) {
        sn_fail_at(&output->failure, code, output->name, 0, "%s", text);
        output->failure.code = code;
    }
    return output->failure.code;
}

static sn_status keep_system_failure(sn_output *output) {
    char text[256];
    snprintf(text, sizeof text, "cannot be written: %s", strerror(errno));
    return keep_failure(output, SN_ERROR_IO, text);
}

static sn_status report_failure(const sn_output *output, sn_error *error) {
    if (output->failure.code != SN_OK && error) *error = output->failure;
    return output->failure.code;
}

/* The folder of the target with a '/' at its end; "" for the current one. NULL = out of memory. */
static char *folder_of(const char *target) {
    const char *slash = strrchr(target, '/');
    return sn_strndup(target, slash ? (size_t)(slash - target) + 1 : 0);
}

/* A name for attempt number `attempt` at a temporary file beside the target; NULL = out of memory. */
static char *temporary_name(const char *target, int attempt) {
    char *folder = folder_of(target), *name = NULL;
    if (folder && asprintf(&name, "%s.sinew-%ld-%d~", folder, (long)getpid(), attempt) < 0) name = NULL;
    free(folder);
    return name;
}

/* A file without a name; linking it later needs /proc. -1 where the file system has no such files. */
static int open_nameless(const char *target) {
    if (access("/proc/self/fd", X_OK) != 0) return -1;
    char *folder = folder_of(target);
    int fd = folder ? open(*folder ? folder : ".", O_TMPFILE | O_WRONLY | O_CLOEXEC, 0666) : -1;
    free(folder);
    return fd;
}

/* An open file in the target's folder, to become the target on commit. */
static sn_status open_beside(sn_output *output, sn_error *error) {
    output->fd = open_nameless(output->target);
    for (int attempt = 0; output->fd < 0 && attempt < ATTEMPTS; attempt++) {
        char *name = temporary_name(output->target, attempt);
        if (!name) return sn_fail_memory(error, "a file name");
        output->fd = open(name, O_CREAT | O_EXCL | O_WRONLY | O_CLOEXEC, 0666);
        int reason = errno;
        if (output->fd >= 0) {
            output->temporary = name;
            break;
        }
        free(name);
        if (reason != EEXIST || attempt + 1 == ATTEMPTS) {
            return sn_fail_at(error, SN_ERROR_IO, output->name, 0, "cannot be written: %s", strerror(reason));
        }
    }
    return SN_OK;
}

static sn_status open_in_place(sn_output *output, const char *path, sn_error *error) {
    output->fd = open(path, O_WRONLY | O_CREAT | O_CLOEXEC, 0666);
    if (output->fd < 0) return sn_fail_at(error, SN_ERROR_IO, path, 0, "cannot be written: %s", strerror(errno));
    return SN_OK;
}

static sn_status open_replacing(sn_output *output, const char *path, const struct stat *existing, sn_error *error) {
    output->target = existing ? realpath(path, NULL) : sn_strdup(path);
    if (!output->target) return sn_fail_at(error, SN_ERROR_IO, path, 0, "cannot be written: %s", strerror(errno));
    if (existing && access(path, W_OK) != 0) { return sn_fail_at(error, SN_ERROR_IO, path, 0, "cannot be written: %s", strerror(errno)); }
    sn_status status = open_beside(output, error);
    if (status == SN_OK && existing && fchmod(output->fd, existing->st_mode & 0777) != 0) {
        return sn_fail_at(error, SN_ERROR_IO, path, 0, "cannot be given the mode of the file it replaces: %s", strerror(errno));
    }
    return status;
}

static sn_status open_path(sn_output *output, const char *path, sn_error *error) {
    struct stat info;
    bool exists = stat(path, &info) == 0;
    if (!*path) return sn_fail_at(error, SN_ERROR_IO, path, 0, "an output needs a file name");
    if (exists && S_ISDIR(info.st_mode)) return sn_fail_at(error, SN_ERROR_IO, path, 0, "is a directory; name a file in it");
    bool regular = !exists || S_ISREG(info.st_mode);
    if (regular && !output->stream) return open_replacing(output, path, exists ? &info : NULL, error);
    output->untruncated = regular;
    output->hold = !output->stream;
    return open_in_place(output, path, error);
}

/* A duplicate, so that its close can be checked without closing the process's stdout. */
static sn_status open_standard(sn_output *output, sn_error *error) {
    output->hold = !output->stream;
    output->fd = fcntl(STDOUT_FILENO, F_DUPFD_CLOEXEC, 3);
    if (output->fd < 0) return sn_fail_at(error, SN_ERROR_IO, output->name, 0, "cannot be written: %s", strerror(errno));
    return SN_OK;
}

sn_status sn_output_open(const char *path, bool stream, sn_output **out, sn_error *error) {
    *out = NULL;
    sn_output *output = SN_NEW(sn_output, 1);
    if (!output) return sn_fail_memory(error, "an output");
    output->fd = -1;
    output->stream = stream;
    bool standard = is_standard(path);
    output->name = sn_strdup(standard ? "<stdout>" : path);
    sn_status status = !output->name ? sn_fail_memory(error, "a file name")
                       : standard    ? open_standard(output, error)
                                     : open_path(output, path, error);
    if (status != SN_OK) {
        sn_output_abort(output);
        return status;
    }
    *out = output;
    return SN_OK;
}

sn_status sn_output_open_behind(const char *path, uint64_t keep, bool stream, sn_output **out, sn_error *error) {
    sn_output *output = *out = SN_NEW(sn_output, 1);
    if (!output || !(output->name = sn_strdup(path))) {
        free(output);
        *out = NULL;
        return sn_fail_memory(error, "an output");
    }
    output->stream = stream;
    output->untruncated = true;
    output->keep = output->written = keep;
    output->fd = open(path, O_WRONLY | O_CLOEXEC);
    if (output->fd >= 0) return SN_OK;
    sn_status status = sn_fail_at(error, SN_ERROR_IO, path, 0, "cannot be written: %s", strerror(errno));
    sn_output_abort(output);
    *out = NULL;
    return status;
}

sn_status sn_output_open_memory(sn_output **out, sn_error *error) {
    *out = NULL;
    sn_output *output = SN_NEW(sn_output, 1);
    if (!output || !(output->name = sn_strdup("<memory>"))) {
        free(output);
        return sn_fail_memory(error, "an output");
    }
    output->fd = -1;
    output->hold = true;
    *out = output;
    return SN_OK;
}

sn_status sn_output_take(sn_output *output, const char *name, sn_blob *out, sn_error *error) {
    *out = (sn_blob){0};
    sn_output_write(output, "", 1, NULL); /* the terminating 0 */
    sn_status status = report_failure(output, error);
    char *copy = sn_strdup(is_standard(name) ? "<stdout>" : name);
    if (status == SN_OK && !copy) status = sn_fail_memory(error, "a file name");
    if (status == SN_OK) {
        *out = (sn_blob){.name = copy, .data = output->buffer, .size = output->used - 1};
        output->buffer = NULL;
        copy = NULL;
    }
    free(copy);
    sn_output_abort(output);
    return status;
}

/* write(2) until all is out; a descriptor that does not block is waited for. */
static bool write_fully(int fd, const char *data, size_t size) {
    while (size > 0) {
        ssize_t put = write(fd, data, size);
        if (put < 0 && errno == EAGAIN) {
            struct pollfd ready = {.fd = fd, .events = POLLOUT};
            if (poll(&ready, 1, -1) < 0 && errno != EINTR) return false;
        } else if (put < 0 && errno != EINTR) {
            return false;
        } else if (put > 0) {
            data += put;
            size -= (size_t)put;
        }
    }
    return true;
}

/* Hand the first `size` bytes of the buffer to the system. */
static sn_status flush_bytes(sn_output *output, size_t size) {
    if (output->untruncated) {
        off_t keep = (off_t)output->keep;
        if (ftruncate(output->fd, keep) != 0 || lseek(output->fd, keep, SEEK_SET) != keep) return keep_system_failure(output);
        output->untruncated = false;
    }
    if (!write_fully(output->fd, output->buffer, size)) return keep_system_failure(output);
    output->written += size;
    output->used -= size;
    if (output->used > 0) memmove(output->buffer, output->buffer + size, output->used);
    return SN_OK;
}

static sn_status flush_lines(sn_output *output) {
    const char *newline = output->used > 0 ? memrchr(output->buffer, '\n', output->used) : NULL;
    return newline ? flush_bytes(output, (size_t)(newline - output->buffer) + 1) : SN_OK;
}

/* Room for `size` more bytes in the buffer, emptied first where that is allowed. */
static sn_status make_room(sn_output *output, size_t size) {
    if (!output->hold && !output->stream && output->used >= CHUNK) {
        sn_status status = flush_bytes(output, output->used);
        if (status != SN_OK) return status;
    }
    if (size > SIZE_MAX - output->used || !sn_grow((void **)&output->buffer, &output->capacity, output->used + size, 1)) {
        return keep_failure(output, SN_ERROR_MEMORY, "out of memory for the output");
    }
    return SN_OK;
}

sn_status sn_output_write(sn_output *output, const void *data, size_t size, sn_error *error) {
    if (output->failure.code == SN_OK && size > 0 && make_room(output, size) == SN_OK) {
        memcpy(output->buffer + output->used, data, size);
        output->used += size;
        if (output->stream) flush_lines(output);
    }
    return report_failure(output, error);
}

sn_status sn_output_print(sn_output *output, const char *format, ...) {
    char text[512];
    va_list arguments, again;
    va_start(arguments, format);
    va_copy(again, arguments);
    int length = vsnprintf(text, sizeof text, format, arguments);
    if (length >= 0 && (size_t)length < sizeof text) {
        sn_output_write(output, text, (size_t)length, NULL);
    } else if (length >= 0 && output->failure.code == SN_OK && make_room(output, (size_t)length + 1) == SN_OK) {
        vsnprintf(output->buffer + output->used, (size_t)length + 1, format, again);
        output->used += (size_t)length;
        if (output->stream) flush_lines(output);
    }
    va_end(again);
    va_end(arguments);
    return output->failure.code;
}

sn_status sn_output_patch(sn_output *output, uint64_t offset, const void *data, size_t size, sn_error *error) {
    if (output->failure.code != SN_OK) return report_failure(output, error);
    if (output->stream || offset > output->written + output->used || size > output->written + output->used - offset) {
        return sn_fail_at(error, SN_ERROR_USAGE, output->name, 0, "bytes that were not written, or have left, cannot be patched");
    }
    if (output->hold) {
        memcpy(output->buffer + offset, data, size);
    } else if (output->used == 0 || flush_bytes(output, output->used) == SN_OK) {
        if (pwrite(output->fd, data, size, (off_t)offset) != (ssize_t)size) keep_system_failure(output);
    }
    return report_failure(output, error);
}

bool sn_output_is_terminal(const sn_output *output) { return isatty(output->fd) == 1; }

/* Give a nameless file a name beside the target: linkat cannot replace, rename can. */
static void name_temporary(sn_output *output) {
    char descriptor[32];
    snprintf(descriptor, sizeof descriptor, "/proc/self/fd/%d", output->fd);
    for (int attempt = 0; attempt < ATTEMPTS; attempt++) {
        char *name = temporary_name(output->target, attempt);
        if (!name) {
            keep_failure(output, SN_ERROR_MEMORY, "out of memory for a file name");
            return;
        }
        if (linkat(AT_FDCWD, descriptor, AT_FDCWD, name, AT_SYMLINK_FOLLOW) == 0) {
            output->temporary = name;
            return;
        }
        int reason = errno;
        free(name);
        errno = reason;
        if (errno != EEXIST) break;
    }
    keep_system_failure(output);
}

static void take_name(sn_output *output) {
    if (rename(output->temporary, output->target) != 0) {
        keep_system_failure(output);
        return;
    }
    free(output->temporary);
    output->temporary = NULL;
    output->published = true;
}

static void replace_target(sn_output *output) {
    if (fsync(output->fd) != 0) keep_system_failure(output);
    if (output->failure.code == SN_OK && !output->temporary && !output->published) name_temporary(output);
    int fd = output->fd;
    output->fd = -1;
    if (close(fd) != 0) keep_system_failure(output);
    if (output->failure.code == SN_OK && !output->published) take_name(output);
}

/* Behind what was written, without moving on: the next write takes its place. */
static void write_tail(sn_output *output, const char *tail) {
    ssize_t size = (ssize_t)strlen(tail);
    if (pwrite(output->fd, tail, (size_t)size, (off_t)output->written) != size) keep_system_failure(output);
}

sn_status sn_output_publish(sn_output *output, const char *tail, sn_error *error) {
    if (output->hold || output->failure.code != SN_OK) return report_failure(output, error);
    flush_bytes(output, output->used);
    if (output->failure.code == SN_OK && tail) write_tail(output, tail);
    if (output->failure.code == SN_OK && output->target && !output->published) {
        if (!output->temporary) name_temporary(output);
        if (output->failure.code == SN_OK) take_name(output);
    }
    return report_failure(output, error);
}

static void finish_in_place(sn_output *output) {
    int fd = output->fd;
    output->fd = -1;
    if (close(fd) != 0) keep_system_failure(output);
}

sn_status sn_output_commit(sn_output *output, sn_error *error) {
    if (output->failure.code == SN_OK) flush_bytes(output, output->used);
    if (output->failure.code == SN_OK) {
        if (output->target) {
            replace_target(output);
        } else {
            finish_in_place(output);
        }
    }
    sn_status status = report_failure(output, error);
    sn_output_abort(output);
    return status;
}

void sn_output_abort(sn_output *output) {
    if (!output) return;
    if (output->fd >= 0) close(output->fd);
    if (output->temporary) unlink(output->temporary);
    free(output->temporary);
    free(output->target);
    free(output->name);
    free(output->buffer);
    free(output);
}
