/*
 * scene_build.h -- a first scene out of its parts: rigs, bones, a motion, activations, settings by pattern.   rank 3
 *
 * A draft is filled in this order: rigs, motion, bones, bindings, activations, settings; then sn_draft_finish writes the document and reads
 * it back, so that what is written is a scene that can run. Paths are from the working directory here and from the scene in the document.
 */
#ifndef SINEW_SCENE_BUILD_H
#define SINEW_SCENE_BUILD_H

#include "sinew/io.h"

/* The members of a muscle that can be set, in the order in which they are written: "activation", "stiffness.relaxed", ...; NULL at the
 * end. */
enum { SN_DRAFT_MEMBERS = 25 };
extern const char *const sn_draft_members[SN_DRAFT_MEMBERS + 1];

typedef struct sn_draft_muscle {
    char *name, *path;                /* owned; the name is the rig's, else its file's */
    sn_muscle rig;                    /* sn_draft_finish hands it on to the scene */
    bool left_out;                    /* the caller's: this muscle is not written */
    bool has_channel;                 /* the activation document has a channel of its name */
    char *settings[SN_DRAFT_MEMBERS]; /* JSON text, owned; NULL = the default */
} sn_draft_muscle;

typedef struct sn_draft_bone {
    sn_motion_bone bone;
    bool own; /* it stands in the scene; false = the motion document has it as it is */
} sn_draft_bone;

typedef struct sn_scene_draft {
    const char *place;                /* where the scene will be; NULL, "-": standard output; the caller's */
    const char *name;                 /* nullable; the caller's */
    double rate;                      /* frames a second */
    sn_index first_frame, last_frame; /* inclusive; of the motion, once that is taken */
    double preroll, run_in;           /* s */
    sn_solver_method method;
    bool contact, externals; /* the scene has them, by their defaults */
    char *motion_path;       /* owned; NULL = nothing moves */
    sn_motion motion;
    sn_index bone_count;
    size_t bone_capacity;
    sn_draft_bone *bones;
    sn_index envelope_count;
    size_t envelope_capacity;
    struct sn_draft_envelope {
        char *name, *path; /* owned */
        bool solid;        /* muscles keep out of it where there is contact */
    } * envelopes;         /* (envelope_count) */
    sn_index muscle_count;
    size_t muscle_capacity;
    sn_draft_muscle *muscles;
    char *activation_path; /* owned; NULL = none */
    sn_muscle_names channels;
} sn_scene_draft;

void sn_draft_defaults(sn_scene_draft *draft); /* empty: 24 frames a second, frame 0 alone, qn */
void sn_draft_free(sn_scene_draft *draft);

/* A rig's file, a muscle document or a bare mesh in metres. SN_ERROR_INPUT: another one has the same name; both files are named. */
SN_MUST_CHECK sn_status sn_draft_add_rig(sn_scene_draft *draft, const char *path, sn_error *error);
/* A motion document: rate and frames become its own, from 0 or its first key to its last; its bones are the scene's. */
SN_MUST_CHECK sn_status sn_draft_take_motion(sn_scene_draft *draft, const char *path, sn_error *error);
/* The same of a motion, which is taken and left empty, whose document will be at `path` before sn_draft_finish. */
SN_MUST_CHECK sn_status sn_draft_put_motion(sn_scene_draft *draft, sn_motion *motion, double rate, const char *path, sn_error *error);
/* The frames of the motion at draft->rate, which the caller may have changed. */
SN_MUST_CHECK sn_status sn_draft_spread(sn_scene_draft *draft, sn_error *error);
/* A bone of the caller's own; its strings are copied, its joint is not read. One of the motion's of that name gives way, and leaves its
 * joint; else it hangs on the joint of its name, where there is one. SN_ERROR_INPUT: two of the caller's have one name. */
SN_MUST_CHECK sn_status sn_draft_add_bone(sn_scene_draft *draft, const sn_motion_bone *bone, sn_error *error);
/* "PATTERN=JOINT": bones by a pattern of their names on a joint; SN_ERROR_INPUT where there is no such joint or no such bone. */
SN_MUST_CHECK sn_status sn_draft_bind(sn_scene_draft *draft, const char *text, sn_error *error);
/* An activation document: muscles of the names of its channels take them. */
SN_MUST_CHECK sn_status sn_draft_take_activations(sn_scene_draft *draft, const char *path, sn_error *error);
/* "PATTERN.MEMBER=VALUE": a member of all muscles of that pattern; JSON, or a word. The value is judged by the reader of scenes. A later
 * one goes before an earlier one, and all before channels. SN_ERROR_USAGE: no such member, or a value that it cannot have; SN_ERROR_INPUT:
 * the pattern is no muscle's. */
SN_MUST_CHECK sn_status sn_draft_set(sn_scene_draft *draft, const char *text, sn_error *error);

/* An envelope document, under that name (NULL = its file's, without .envelope.json). SN_ERROR_INPUT: a bone or another envelope has it. */
SN_MUST_CHECK sn_status sn_draft_add_envelope(sn_scene_draft *draft, const char *name, const char *path, sn_error *error);
/* Muscles keep out of the envelope of that name. SN_ERROR_USAGE: there is none. */
SN_MUST_CHECK sn_status sn_draft_touch(sn_scene_draft *draft, const char *name, sn_error *error);

/* What the muscle is attached to and the draft has not got, as a bone, an envelope or a joint; NULL = nothing. */
const char *sn_draft_missing_bone(const sn_scene_draft *draft, const sn_draft_muscle *muscle);
const sn_draft_bone *sn_draft_find_bone(const sn_scene_draft *draft, const char *name); /* NULL = none */
/* How far the bones are from rest at the first frame: the greatest turn (radians) and the greatest way of a joint's centre (m). */
SN_MUST_CHECK sn_status sn_draft_away(const sn_scene_draft *draft, double *angle, double *distance, sn_error *error);
/* The document as text, named as draft->place, and the scene that it is, its bones' surfaces loaded; both are the caller's to free. entry
 * is nullable. Errors of the scene's reader and checks come through. */
SN_MUST_CHECK sn_status sn_draft_finish(sn_scene_draft *draft, const sn_history_entry *entry, sn_blob *text, sn_scene *scene,
                                        sn_error *error);

#endif
