/*
 * envelope.h -- a surface of one piece over the bones, bound to them: attachment and collider of muscles ([R18] 4.2).   rank 2
 *
 * Lengths are metres, places those of the bones' rest pose, z up.
 */
#ifndef SINEW_ENVELOPE_H
#define SINEW_ENVELOPE_H

#include "sinew/geom.h"
#include "sinew/motion_clip.h"
#include "sinew/thread.h"

/*
 * How a vertex goes with several bones.
 * BLEND: by the weighted mean of their poses as dual quaternions (Kavan et al. 2007, "Skinning with dual quaternions"): what turns about a
 * joint keeps its distance from it.
 * WRAP: the weighted mean of where the tangent frames of its closest points on the bones carry it ([R18]'s wrap deformation). The frame of
 * a point of a rigid bone moves as the bone does, so that this is a mean of places: it is drawn inwards where bones turn far apart.
 */
typedef enum sn_envelope_method { SN_ENVELOPE_BLEND, SN_ENVELOPE_WRAP } sn_envelope_method;
extern const char *const sn_envelope_method_names[]; /* "blend", "wrap"; NULL at the end */

enum { SN_INFLUENCE_LIMIT = 4 };

/* The bones that carry one vertex, the heaviest first; of two alike the first. */
typedef struct sn_influence {
    sn_index count;                     /* 1 to SN_INFLUENCE_LIMIT */
    sn_index bones[SN_INFLUENCE_LIMIT]; /* (count) no two alike */
    double weights[SN_INFLUENCE_LIMIT]; /* (count) above 0; their sum is 1; exactly 1 where count is 1 */
} sn_influence;

typedef struct sn_envelope {
    char *name; /* nullable */
    sn_envelope_method method;
    double reach; /* that it was bound with */
    sn_mesh mesh; /* at rest */
    sn_index bone_count;
    char **bones;             /* (bone_count) names */
    sn_influence *influences; /* (mesh.vertex_count) */
} sn_envelope;

void sn_envelope_free(sn_envelope *envelope); /* frees what it owns and zeroes it */
/* A valid mesh; names there and distinct; every influence as said above (sums to 1e-9). */
SN_MUST_CHECK sn_status sn_envelope_validate(const sn_envelope *envelope, sn_error *error);
/* Where the vertices are under the bones' poses away from rest: poses (bone_count), positions (vertex_count). A vertex on one bone is
 * carried by its pose alone. A pose may be written as q or -q. pool is nullable. The envelope must be valid. */
void sn_envelope_deform(const sn_envelope *envelope, const sn_rigid *poses, sn_pool *pool, sn_vec3 *positions);
/* The same of one vertex: poses (influences[vertex].count) of the bones that carry it, in the order of its influences. */
sn_vec3 sn_envelope_vertex(const sn_envelope *envelope, sn_index vertex, const sn_rigid *poses);

/* ---- binding ------------------------------------------------------------------------------------------------------------------- */

/* A bone at rest. */
typedef struct sn_envelope_bone {
    const char *name;
    const sn_mesh *mesh;
    sn_index joint; /* bones of one joint move alike: of these the nearest alone carries a vertex. SN_NONE is one too: the world */
} sn_envelope_bone;

typedef struct sn_envelope_params {
    sn_envelope_method method;
    double reach;      /* > 0: how much farther than the nearest a bone may be and still carry; see sn_envelope_bind */
    sn_pool *pool;     /* nullable */
    sn_trace *trace;   /* nullable: a step "bone" for each: how many vertices it carries alone, and with others */
    double *clearance; /* (vertex_count) nullable: gets the distance of each vertex to its nearest bone */
} sn_envelope_params;

#define SN_ENVELOPE_REACH 0.04

/*
 * Bind a surface to bones. With distances d to the bones' surfaces, d0 the least, a bone has the share w / (1 - w), w = S((1 - s) / 2),
 * s = (d - d0) / reach; none from s = 1 on. S goes from 0 to 1, straight but for a fifth of the way at either end, where it bends. Between
 * two bones that is a weight which goes from 1 to 0 as the difference of the distances goes through -reach..reach, by 1.25 / reach of a
 * vertex's way at most. Of more than four bones the four nearest carry, each share less that of the fifth, so that nothing jumps where
 * fourth and fifth change places. Shares over their sum are the weights. clearance (vertex_count, nullable): d0 of each vertex. The
 * envelope gets copies of the mesh and of all names.
 */
SN_MUST_CHECK sn_status sn_envelope_bind(const sn_mesh *mesh, sn_index bone_count, const sn_envelope_bone *bones,
                                         const sn_envelope_params *params, sn_envelope *out, sn_error *error);

/* ---- what a motion does to it ---------------------------------------------------------------------------------------------------- */

/* One frame. */
typedef struct sn_envelope_frame {
    double least_area; /* of a triangle over its area at rest; those without area at rest are not asked */
    sn_index triangle;
    sn_index small;         /* triangles below a fifth of their area at rest */
    double deepest;         /* how far the farthest vertex of a bone is outside the envelope, metres; negative: all are inside */
    sn_index bone, vertex;  /* which that is */
    sn_index outside, deep; /* vertices of bones outside; by more than SN_ENVELOPE_DEEP */
} sn_envelope_frame;

#define SN_ENVELOPE_DEEP 0.003
#define SN_ENVELOPE_SMALL 0.2

/* Measure the envelope under poses (bone_count; NULL = rest). bones (bone_count) in the envelope's order. What is outside is told by
 * closest point, and by winding number where the envelope crosses itself. */
SN_MUST_CHECK sn_status sn_envelope_measure(const sn_envelope *envelope, const sn_envelope_bone *bones, const sn_rigid *poses,
                                            sn_pool *pool, sn_envelope_frame *out, sn_error *error);

#endif
