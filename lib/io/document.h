/* document.h -- what the documents share. Private to lib/io. */
#ifndef SINEW_IO_DOCUMENT_H
#define SINEW_IO_DOCUMENT_H

#include "json.h"

/* The most bones, muscles, joints, attachments or attributes that a document may list. */
enum { SN_LIST_LIMIT = 4096 };

/* The path of a file that a document names: relative to the document's own folder. Allocated; NULL = out of memory. */
char *sn_path_beside(const char *document, const char *uri);
/* The other way round: what a document at `document` (NULL, "-": on standard output) calls the file that is at `path` from the working
 * directory. Allocated; NULL = out of memory. */
char *sn_path_from(const char *document, const char *path);
/* The file's name without folder and extension; NULL = out of memory, or a stream without a name. */
char *sn_path_stem(const char *path);
/* What a muscle is called: as the rig says, else as its file is. Allocated; NULL = out of memory. */
char *sn_muscle_call(const sn_muscle *rig, const char *path);
/* The member "history": the entries of tree (nullable), then entry (nullable); nothing where there is neither. */
void sn_history_write(const sn_json_tree *tree, const sn_history_entry *entry, sn_json *json);
/* The member "mesh" of a document, inline or by uri and hash; required. */
SN_MUST_CHECK sn_status sn_parse_mesh(const sn_json_value *value, sn_mesh *mesh, sn_error *error);
void sn_mesh_document_write(const sn_mesh *mesh, sn_json *json);
/* The list of fibres of a document; an absent one leaves *out alone. */
SN_MUST_CHECK sn_status sn_parse_polylines(const sn_json_value *value, sn_fibers *out, sn_error *error);

#endif
