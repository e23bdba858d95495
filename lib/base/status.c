/* status.c -- error sentences and the log callback. */
#include "sinew/base.h"

#include <stdio.h>
#include <string.h>

/* Write the sentence; keep the file that is already named. */
static void fill(sn_error *error, sn_status code, const char *format, va_list arguments) {
    char text[sizeof error->text];
    vsnprintf(text, sizeof text, format, arguments); /* first into a copy: an argument may point into *error */
    for (char *c = text; *c != '\0'; c++)
        if ((unsigned char)*c < ' ' || *c == 0x7f) *c = ' '; /* what a file says must not break the line */
    memcpy(error->text, text, sizeof text);
    error->code = code;
}

static void reset(sn_error *error) {
    error->line = 0;
    error->column = 0;
    error->element = -1;
}

sn_status sn_fail(sn_error *error, sn_status code, const char *format, ...) {
    if (error == NULL) return code;
    va_list arguments;
    va_start(arguments, format);
    fill(error, code, format, arguments);
    va_end(arguments);
    reset(error);
    return code;
}

sn_status sn_fail_at(sn_error *error, sn_status code, const char *file, int64_t line, const char *format, ...) {
    if (error == NULL) return code;
    va_list arguments;
    va_start(arguments, format);
    fill(error, code, format, arguments);
    va_end(arguments);
    reset(error);
    error->line = line;
    error->file[0] = '\0';
    sn_error_set_file(error, file);
    return code;
}

sn_status sn_fail_memory(sn_error *error, const char *what) { return sn_fail(error, SN_ERROR_MEMORY, "out of memory for %s", what); }

void sn_error_set_file(sn_error *error, const char *file) {
    if (error == NULL || file == NULL || error->file[0] != '\0') return;
    snprintf(error->file, sizeof error->file, "%s", file);
}

static sn_log_function log_function;
static void *log_user;

void sn_log_set(sn_log_function function, void *user) {
    log_function = function;
    log_user = user;
}

void sn_log(sn_log_level level, const char *format, ...) {
    if (log_function == NULL) return;
    char text[1024];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    log_function(log_user, level, text);
}
