/*
 * kept.h -- inside lib/sim: what the lists of a state's arrays and numbers are for: room, bytes, saving, checking what was read.
 *
 * A list of arrays has X(type, name, count, kept); one of numbers X(member, holds), `holds` being what is true of the member in every state
 * that a run comes to. Each one's condition may rely on those before it. Of a flag nothing but its byte may be looked at until that is
 * known to be 0 or 1.
 */
#ifndef SN_SIM_KEPT_H
#define SN_SIM_KEPT_H

#include "state.h"

#include <stdlib.h>
#include <string.h>

/* ---- a cursor that counts, writes or reads (kept.c) ------------------------------------------------------------------------- */

typedef struct sn_cursor {
    const char *from; /* what it reads */
    char *to;         /* or writes; both NULL = it only counts */
    size_t at, size;
    bool short_of; /* fewer bytes than the state needs */
} sn_cursor;
void sn_cursor_pass(sn_cursor *c, void *data, size_t size);

/* ---- what every number may be (kept.c) --------------------------------------------------------------------------------------- */

bool sn_sound_flag(const bool *flag);
bool sn_sound_flags(const bool *values, size_t count);
bool sn_sound_numbers(const double *values, size_t count);
bool sn_sound_vectors(const sn_vec3 *values, size_t count);
bool sn_sound_points(const sn_point *values, size_t count);
bool sn_sound_single_points(const sn_single_point *values, size_t count);
bool sn_sound_indices(const sn_index *values, size_t count); /* of what is made anew: any */
bool sn_sound_poses(const sn_rigid *values, size_t count);
bool sn_sound_boxes(const sn_box *values, size_t count); /* made anew: any */
/* A product of rotations, each a unit to within the 1e-6 that a scene may have it off. */
bool sn_sound_unit(sn_quat q);
bool sn_sound_turns(const sn_quat *values, size_t count); /* zeros: nothing has turned yet */

/* Of arrays by the type of their elements: a type without a rule does not compile. */
#define SN_SOUND(values, count)                                                                                                            \
    _Generic((values),                                                                                                                     \
        double *: sn_sound_numbers,                                                                                                        \
        sn_vec3 *: sn_sound_vectors,                                                                                                       \
        sn_point *: sn_sound_points,                                                                                                       \
        sn_single_point *: sn_sound_single_points,                                                                                         \
        bool *: sn_sound_flags,                                                                                                            \
        sn_index *: sn_sound_indices,                                                                                                      \
        sn_quat *: sn_sound_turns,                                                                                                         \
        sn_box *: sn_sound_boxes,                                                                                                          \
        sn_rigid *: sn_sound_poses)((values), (count))

/* ---- for the lists; `part` is the struct that has the members, `kept_only`, `made`, `bytes`, `c`, `read` are the user's ----------- */

#define SN_MAKE_ARRAY(type, name, count, kept)                                                                                             \
    if (kept || !kept_only) made = (part->name = SN_NEW(type, count)) != NULL && made;
#define SN_FREE_ARRAY(type, name, count, kept) free(part->name);
#define SN_ADD_BYTES(type, name, count, kept) bytes += (size_t)(count) * sizeof(type);
#define SN_PASS_NUMBER(member, holds) sn_cursor_pass(c, &part->member, sizeof part->member);
#define SN_PASS_ARRAY(type, name, count, kept)                                                                                             \
    if (kept) sn_cursor_pass(c, part->name, (size_t)(count) * sizeof(type));
#define SN_CHECK_NUMBER(member, holds)                                                                                                     \
    if (!(holds)) return #member;
#define SN_CHECK_ARRAY(type, name, count, kept)                                                                                            \
    if (kept && !SN_SOUND(part->name, (size_t)(count))) return #name;
#define SN_TAKE_NUMBER(member, holds) part->member = read->member;
#define SN_TAKE_ARRAY(type, name, count, kept)                                                                                             \
    if (kept && (count) > 0) memcpy(part->name, read->name, (size_t)(count) * sizeof(type));

#endif
