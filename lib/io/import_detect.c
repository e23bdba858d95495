/*
 * import_detect.c -- which of the formats of mesh-import a file has: by its content, never by its name.
 *
 * A name proves nothing (.mot is a motion of a gait laboratory and of a 3D program, .x anything), and random bytes must not cost the
 * start of a child.
 */
#include "import.h"

#include <string.h>

typedef struct signature {
    const char *kind, *name; /* the extension that assimp knows the format by; its name in messages */
    size_t offset;
    const char *magic;
} signature;

static const signature signatures[] = {
    {"glb", "glTF", 0, "glTF"},
    {"fbx", "FBX", 0, "Kaydara FBX Binary"},
    {"fbx", "FBX", 0, "; FBX "},
    {"fbx", "FBX", 0, "FBXHeaderExtension:"},
    {"x", "DirectX", 0, "xof 0"},
    {"blend", "Blender", 0, "BLENDER"},
    {"ac", "AC3D", 0, "AC3D"},
    {"b3d", "Blitz3D", 0, "BB3D"},
    {"ms3d", "Milkshape", 0, "MS3D000000"},
    {"lwo", "LightWave", 8, "LWO"},
    {"md2", "MD2", 0, "IDP2"},
    {"md3", "MD3", 0, "IDP3"},
    {"md5mesh", "MD5", 0, "MD5Version"},
    {"ase", "3ds Max ASCII", 0, "*3DSMAX_ASCIIEXPORT"},
    {"cob", "TrueSpace", 0, "Caligari "},
    {"q3o", "Quick3D", 0, "quick3Do"},
};

/* The root of an XML file: it stands behind declarations and comments, near the front. */
static const signature roots[] = {
    {"dae", "Collada", 0, "<COLLADA"},
    {"x3d", "X3D", 0, "<X3D"},
    {"amf", "AMF", 0, "<amf"},
};

enum { SIGNATURE_COUNT = sizeof signatures / sizeof *signatures, ROOT_COUNT = sizeof roots / sizeof *roots, XML_REACH = 4096 };

static bool has(const sn_blob *blob, size_t offset, const char *magic) {
    size_t length = strlen(magic);
    return blob->size >= offset + length && memcmp(blob->data + offset, magic, length) == 0;
}

/* The main chunk of a 3DS file, as long as the file, and the first chunk in it: a version or the editor's. */
static bool is_3ds(const sn_blob *blob) {
    const unsigned char *b = (const unsigned char *)blob->data;
    if (blob->size < 16 || b[0] != 0x4d || b[1] != 0x4d) return false;
    uint64_t length = (uint64_t)b[2] | (uint64_t)b[3] << 8 | (uint64_t)b[4] << 16 | (uint64_t)b[5] << 24;
    return length <= blob->size && length >= 16 && ((b[6] == 0x02 && b[7] == 0x00) || (b[6] == 0x3d && b[7] == 0x3d));
}

static const char *xml_kind(const sn_blob *blob) {
    size_t start = sn_byte_order_mark(blob->data, blob->size), reach = blob->size < XML_REACH ? blob->size : XML_REACH;
    while (start < reach && strchr(" \t\r\n", blob->data[start]) != NULL && blob->data[start] != '\0') start++;
    if (start >= reach || blob->data[start] != '<') return NULL;
    for (int i = 0; i < ROOT_COUNT; i++)
        if (memmem(blob->data + start, reach - start, roots[i].magic, strlen(roots[i].magic)) != NULL) return roots[i].kind;
    return NULL;
}

/* The same for text: "  0", "SECTION" on the first two lines. */
static bool is_dxf(const sn_blob *blob) {
    const char *at = blob->data, *end = at + (blob->size < 64 ? blob->size : 64);
    while (at < end && *at == ' ') at++;
    if (at == end || *at++ != '0') return false;
    const char *line_end = at;
    while (at < end && (*at == '\r' || *at == '\n' || *at == ' ')) at++;
    return at > line_end && end - at >= 7 && memcmp(at, "SECTION", 7) == 0;
}

const char *sn_import_detect(const sn_blob *blob) {
    if (blob->size == 0) return NULL;
    for (int i = 0; i < SIGNATURE_COUNT; i++) {
        if (has(blob, signatures[i].offset, signatures[i].magic)) return signatures[i].kind;
    }
    if (is_3ds(blob)) return "3ds";
    if (is_dxf(blob)) return "dxf";
    if (sn_gltf_detect(blob)) return "gltf";
    return xml_kind(blob);
}

const char *sn_import_format_name(const char *kind) {
    if (strcmp(kind, "3ds") == 0) return "3DS";
    if (strcmp(kind, "dxf") == 0) return "DXF";
    if (strcmp(kind, "gltf") == 0) return "glTF";
    for (int i = 0; i < SIGNATURE_COUNT; i++)
        if (strcmp(kind, signatures[i].kind) == 0) return signatures[i].name;
    for (int i = 0; i < ROOT_COUNT; i++)
        if (strcmp(kind, roots[i].kind) == 0) return roots[i].name;
    return kind;
}
