/* osim.h -- what the files that read OpenSim's models share. Private to lib/io. */
#ifndef SN_IO_OSIM_H
#define SN_IO_OSIM_H

#include "sinew/model_files.h"
#include "xml_tree.h"

/* No model has as many bodies, joints, frames or meshes; this bounds what comparing them all takes. */
enum { SN_OSIM_MOST = 4096 };

/* A frame that is fixed to a body, or to another such frame. */
typedef struct sn_osim_frame {
    sn_span name, owner; /* owner: name of the element that it is a part of */
    sn_index element, owner_element;
    sn_rigid local; /* in what it is fixed to */
} sn_osim_frame;

/* A joint: child = parent, then its moves. */
typedef struct sn_osim_joint {
    sn_index element, parent, child; /* bodies; SN_NONE = the ground */
    bool used;
    sn_skeleton_body moves; /* its moves alone */
} sn_osim_joint;

typedef struct sn_osim {
    const sn_xml_tree *tree;
    sn_error *error;
    sn_skeleton *out;
    sn_index model;
    sn_index *bodies; /* (out->body_count) element of each body */
    size_t body_capacity, coordinate_capacity, coupler_capacity, mesh_capacity;
    sn_osim_frame *frames;
    size_t frame_count, frame_capacity;
    sn_osim_joint *joints;
    size_t joint_count, joint_capacity;
} sn_osim;

/* A place on a body. */
typedef struct sn_osim_place {
    sn_index body; /* SN_NONE = the ground */
    sn_rigid local;
} sn_osim_place;

/* Three numbers of the element's child `name`; a missing one leaves *out alone. */
SN_MUST_CHECK sn_status sn_osim_vec3(const sn_osim *o, sn_index element, const char *name, sn_vec3 *out);
/* Rotations about x, y, z, each in the frame that the one before it has turned. */
sn_quat sn_osim_rotation(sn_vec3 angles);
/* The body or frame that a socket names, by its last part: "/bodyset/pelvis", "hip_offset", ".." . `from` is the element that has the
 * socket. */
SN_MUST_CHECK sn_status sn_osim_resolve(const sn_osim *o, sn_index from, sn_span socket, sn_osim_place *out);
/* The last part of a path, which is taken off it with the slash before it. */
sn_span sn_osim_last_part(sn_span *path);
sn_index sn_osim_find_body(const sn_osim *o, sn_span name, bool *is_ground);

/* Read one joint, with its coordinates, into joint->moves; its ends are known. parent_frame and child_frame: where the joint is on them. */
SN_MUST_CHECK sn_status sn_osim_read_joint(sn_osim *o, sn_osim_joint *joint, sn_rigid parent_frame, sn_rigid child_frame);
bool sn_osim_is_joint(sn_span name); /* the name of an element */
SN_MUST_CHECK sn_status sn_osim_read_couplers(sn_osim *o);

/* The function that `owner` holds under this name, in either way of writing it; SN_NONE = none. */
sn_index sn_osim_find_function(const sn_xml_tree *tree, sn_index owner, const char *name);
SN_MUST_CHECK sn_status sn_osim_read_function(const sn_xml_tree *tree, sn_index element, double scale, sn_function **out, sn_error *error);

#endif
