/*
 * scene_surface.h -- surfaces that move and change their shape under muscles: envelopes over bones, and meshes that a host deforms; points
 * that follow them.   rank 2
 *
 * Lengths are metres, z up; times seconds.
 */
#ifndef SINEW_SCENE_SURFACE_H
#define SINEW_SCENE_SURFACE_H

#include "sinew/envelope.h"
#include "sinew/motion.h"

/* Places of the vertices of a mesh over time, as a host keeps them: between two samples a vertex goes straight, outside of them it stays
 * where the nearest has it. */
typedef struct sn_vertex_track {
    sn_index sample_count, vertex_count;
    double *times;    /* (sample_count) ascending; owned */
    float *positions; /* (sample_count x vertex_count x 3) owned */
} sn_vertex_track;

sn_vec3 sn_vertex_track_at(const sn_vertex_track *track, double time, sn_index vertex); /* track has at least one sample */
void sn_vertex_track_free(sn_vertex_track *track);                                      /* leaves all zeros */

/* Which axis a file means to point up. */
typedef enum sn_up { SN_UP_UNKNOWN, SN_UP_Y, SN_UP_Z } sn_up;

typedef enum sn_scene_surface_kind {
    SN_SURFACE_ENVELOPE, /* goes with the scene's bones */
    SN_SURFACE_DRIVEN    /* goes as its frames say */
} sn_scene_surface_kind;

/* A surface of a scene. Until it is loaded it has a name and files alone. */
typedef struct sn_scene_surface {
    char *name; /* owned, as are all that follow */
    sn_scene_surface_kind kind;
    char *uri;              /* as written in the document: of the envelope document, or of the mesh at rest */
    char *frames;           /* DRIVEN: as written: a point cache, or the meshes of a sequence */
    double meters_per_unit; /* DRIVEN: of mesh and frames; 0 = as their files say */
    sn_space space;         /* DRIVEN: that its mesh's file says, once loaded */
    sn_up up;               /* DRIVEN: of mesh and frames; UNKNOWN = as the mesh's file says, else z */
    double rate;            /* DRIVEN: frames a second of its frames; 0 = the scene's, or what a cache with times says */
    bool solid;             /* muscles keep out of it where there is contact; default false */
    bool loaded;
    sn_envelope envelope;  /* DRIVEN: its mesh alone, at rest */
    sn_index *joints;      /* ENVELOPE: (envelope.bone_count) of the scene's motion; SN_NONE = the bone never moves */
    sn_vertex_track track; /* DRIVEN */
} sn_scene_surface;

void sn_scene_surface_free(sn_scene_surface *surface); /* leaves all zeros */

/* When a surface is asked for. */
typedef struct sn_surface_moment {
    const sn_rigid *poses; /* of all joints of the scene's motion */
    double time;
    double share; /* of the way from rest to there; 1 but in a run-in */
} sn_surface_moment;

/* Where one vertex of a loaded surface is, or all of them: positions (envelope.mesh.vertex_count); pool is nullable. Both give the same. */
sn_vec3 sn_scene_surface_vertex(const sn_scene_surface *surface, const sn_surface_moment *at, sn_index vertex);
void sn_scene_surface_positions(const sn_scene_surface *surface, const sn_surface_moment *at, sn_pool *pool, sn_vec3 *positions);

/* ---- points that follow a surface: by barycentric coordinates and tangent frame ([R18] 4.2) ------------------------------------------ */

/* A point beside a triangle: offset from the barycentric point in the triangle's frame (first edge, across it, normal). */
typedef struct sn_follower {
    sn_index triangle;
    double barycentric[3];
    sn_vec3 offset;
} sn_follower;

/* Bind points (count) to the nearest triangles of a surface's rest shape, or to a well-shaped one where that is a mean edge farther at
 * most (the frame of a needle is noise): followers (count). SN_ERROR_INPUT: no triangle has an area. *farthest (nullable) gets the
 * greatest distance. */
SN_MUST_CHECK sn_status sn_followers_bind(const sn_scene_surface *surface, sn_index count, const sn_vec3 *points, sn_follower *followers,
                                          double *farthest, sn_error *error);
/* Where a follower is. Where its triangle has no area at that moment, its offset is turned as at rest. */
sn_vec3 sn_follower_place(const sn_scene_surface *surface, const sn_surface_moment *at, const sn_follower *follower);
/* The rigid motion of the follower's tangent frame away from rest. */
sn_rigid sn_follower_pose(const sn_scene_surface *surface, const sn_surface_moment *at, const sn_follower *follower);

#endif
