/* frames_mesh.c -- meshes that move, for ParaView and VTK: a VTP file per frame, and a PVD collection that gives each its time. */
#include "collection.h"

#include <stdlib.h>

struct sn_mesh_frames {
    sn_collection collection;
};

sn_status sn_mesh_frames_create(const char *prefix, sn_mesh_frames **out, sn_error *error) {
    sn_mesh_frames *frames = *out = SN_NEW(sn_mesh_frames, 1);
    if (frames == NULL) return sn_fail_memory(error, "the frames of a mesh");
    sn_status status = sn_collection_open(&frames->collection, prefix, error);
    if (status == SN_OK) return SN_OK;
    sn_mesh_frames_abort(frames);
    *out = NULL;
    return status;
}

sn_status sn_mesh_frames_append(sn_mesh_frames *frames, sn_index frame, double time, const sn_mesh *mesh, sn_error *error) {
    sn_output *output = NULL;
    sn_status status = sn_output_open(sn_collection_frame(&frames->collection, frame), false, &output, error);
    if (status != SN_OK) return status;
    status = sn_mesh_write(mesh, SN_MESH_VTP, SN_ENCODING_LITTLE, output, error);
    if (status == SN_OK)
        status = sn_output_commit(output, error);
    else
        sn_output_abort(output);
    return status == SN_OK ? sn_collection_list(&frames->collection, time, error) : status;
}

sn_status sn_mesh_frames_resume(sn_mesh_frames *frames, sn_resume *resume, bool *goes_on, sn_error *error) {
    return sn_collection_resume(&frames->collection, resume, goes_on, error);
}

sn_status sn_mesh_frames_commit(sn_mesh_frames *frames, sn_error *error) {
    sn_status status = sn_collection_close(&frames->collection, error);
    free(frames);
    return status;
}

void sn_mesh_frames_abort(sn_mesh_frames *frames) {
    if (frames == NULL) return;
    sn_collection_drop(&frames->collection);
    free(frames);
}
