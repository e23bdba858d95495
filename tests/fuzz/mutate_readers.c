/*
 * mutate_readers.c -- every reader against broken files: mutate_readers [COUNT [FIRST]], or mutate_readers --seeds FOLDER
 *
 * Small good files of every format and both documents are truncated, flipped, spliced and given other numbers, from seeds: case n is always
 * the same file. Each must be read as a valid mesh, muscle, scene or cache, or be refused with one line that names the file, with no more
 * memory than ten times the file and 64 MB. What is read as a mesh must survive being written. The longest time is printed, not judged.
 * Files that once found a fault (tests/data/broken) are read as well.
 * --seeds writes the good files to FOLDER, a folder for each format in it: where the programs of tests/fuzz/targets begin.
 */
#include "fields.h"
#include "sinew/arm_files.h"
#include "sinew/error_time.h"
#include "sinew/model_files.h"

#include <dirent.h>
#include <malloc.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/time.h>
#include <time.h>
#include <unistd.h>

/* Of the processor, for one file: a limit against hanging, which judges no speed. */
enum { SECONDS_UNTIL_HANGING = 30 };
enum { SEED_LIMIT = 96, GROWTH = 4096 };

typedef enum kind {
    MESH,
    MUSCLE,
    SCENE,
    CACHE,
    REPORT,
    SETTINGS,
    MOTION,
    SKELETON,
    MODEL,
    STORAGE,
    SENSORS,
    NAMES,
    BODY,
    ENVELOPE,
    FIELD,
    LINES,
    GLTF,
    WEIGHTS,   /* of an embedding */
    LANDMARKS, /* around attachment areas */
    SITES,     /* of a muscle's ends */
    TEMPLATE,  /* of fibres */
    ENDS,      /* of fibres, by vertices */
    LENGTHS,   /* over a coordinate */
    MEASURED   /* moment arms */
} kind;

typedef struct bytes {
    char *data;
    size_t size, capacity;
} bytes;

typedef struct seed {
    kind kind;
    char name[64];
    bytes content;
} seed;

static seed seeds[SEED_LIMIT];
static int seed_count;
static char folder[256];
static volatile long current_case;
static long passed, failed, accepted;
static sn_error last_error;

/* ---- good files ----------------------------------------------------------------------------------------------------- */

static const char cube_obj[] = "# cube\r\nmtllib cube.mtl\nv -1 -1 -1 1 0 0\nv 1 -1 -1 0 1 0\nv 1 1 -1 0 0 1\nv -1 1 -1 1 1 1\n"
                               "v -1 -1 1 0.5 0.5 0.5\nv 1 -1 1 0 0 0\nv 1 1 1.25e0 1 0 1\nv -1 1 1 0 1 1\nvn 0 0 1\nvt 0.5 0.5\n"
                               "g bottom\nf 4//1 3//1 2//1 1//1\ng top side\nf 5/1/1 6/1/1 7/1/1 8/1/1\nusemtl red\no sides\nf 1 2 -3 -4\n"
                               "f 2 3 7\\\n 6\nf 3 4 8 7\nf 4 1 5\nf 4 5 8\ns off\n";
static const char notch_off[] = "COFF # colours\n6 3 0\n0 0 0 255 0 0 255\n4 0 0 0 0 0 255\n4 4 0 0 0 0 255\n2 1 0 1 2 3 4\n0 4 0 9 9 9 9\n"
                                "2 2 3 0 0 0 0\n5 0 1 2 3 4\n3 0 1 5 0.5 0.5 0.5\n3 1 2 5\n";
static const char extra_ply[] =
    "ply\nformat ascii 1.0\ncomment x\nobj_info y\nelement camera 1\nproperty float view\nproperty list uchar float more\nelement vertex "
    "4\n"
    "property float x\nproperty float y\nproperty list uchar int skip\nproperty double z\nproperty uchar red\nproperty float painted\n"
    "element face 4\nproperty list uchar int vertex_indices\nproperty int flags\nelement edge 1\nproperty int a\nend_header\n0.5 2 1 2\n"
    "0 0 0 0 255 0.5\n1 0 1 7 0 0 1e-3\n0 1 2 8 9 0 1 nan\n0 0 0 1 2 -1\n3 0 2 1 5\n3 0 1 3 5\n3 1 2 3 5\n3 0 3 2 5\n12\n";
static const char strips_ply[] =
    "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nelement face 1\n"
    "property list uchar int vertex_indices\nelement tristrips 2\nproperty list int int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n"
    "0 0 1\n3 1 2 3\n9 0 2 1 3 -1 3 2 0 1\n3 0 3 2\n";
/* Instances, a skin, a morph target, sparse and normalized numbers, a strip: tests/write-gltf makes each of these. */
static const char sink_gltf[] =
    "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0,1,2]}],\"nodes\":[{\"name\":\"m\",\"mesh\":0,\"transl"
    "ation\":[0,1,0],\"extensions\":{\"EXT_mesh_gpu_instancing\":{\"attributes\":{\"TRANSLATION\":2,\"ROTATION\":3,\"SCALE\":4}}}"
    "},{\"name\":\"s\",\"mesh\":1,\"skin\":0},{\"children\":[3],\"matrix\":[1,0,0,0,0,1,0,0,0,0,1,0,0,0,4,1]},{\"translation\":[0"
    ",1,0]}],\"bufferViews\":[{\"buffer\":0,\"byteOffset\":0,\"byteLength\":48},{\"buffer\":0,\"byteOffset\":48,\"byteLength\":24"
    "},{\"buffer\":0,\"byteOffset\":72,\"byteLength\":24},{\"buffer\":0,\"byteOffset\":96,\"byteLength\":16},{\"buffer\":0,\"byte"
    "Offset\":112,\"byteLength\":24},{\"buffer\":0,\"byteOffset\":136,\"byteLength\":48},{\"buffer\":0,\"byteOffset\":184,\"byteL"
    "ength\":16,\"byteStride\":4},{\"buffer\":0,\"byteOffset\":200,\"byteLength\":1},{\"buffer\":0,\"byteOffset\":204,\"byteLengt"
    "h\":12},{\"buffer\":0,\"byteOffset\":216,\"byteLength\":16},{\"buffer\":0,\"byteOffset\":232,\"byteLength\":16},{\"buffer\":"
    "0,\"byteOffset\":248,\"byteLength\":128}],\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":4,\"type\":\"VEC"
    "3\",\"sparse\":{\"count\":1,\"indices\":{\"bufferView\":7,\"componentType\":5121},\"values\":{\"bufferView\":8}}},{\"bufferV"
    "iew\":1,\"componentType\":5123,\"count\":12,\"type\":\"SCALAR\"},{\"bufferView\":2,\"componentType\":5126,\"count\":2,\"type"
    "\":\"VEC3\"},{\"bufferView\":3,\"componentType\":5122,\"count\":2,\"type\":\"VEC4\",\"normalized\":true},{\"bufferView\":4,\""
    "componentType\":5126,\"count\":2,\"type\":\"VEC3\"},{\"bufferView\":5,\"componentType\":5126,\"count\":4,\"type\":\"VEC3\"},"
    "{\"bufferView\":6,\"componentType\":5121,\"count\":4,\"type\":\"VEC3\",\"normalized\":true},{\"bufferView\":9,\"componentTyp"
    "e\":5121,\"count\":4,\"type\":\"VEC4\"},{\"bufferView\":10,\"componentType\":5121,\"count\":4,\"type\":\"VEC4\",\"normalized"
    "\":true},{\"bufferView\":11,\"componentType\":5126,\"count\":2,\"type\":\"MAT4\"}],\"meshes\":[{\"primitives\":[{\"attribute"
    "s\":{\"POSITION\":0,\"COLOR_0\":6},\"indices\":1,\"targets\":[{\"POSITION\":5}]}],\"weights\":[0.5]},{\"primitives\":[{\"mod"
    "e\":5,\"attributes\":{\"POSITION\":0,\"JOINTS_0\":7,\"WEIGHTS_0\":8}}]}],\"extensionsUsed\":[\"EXT_mesh_gpu_instancing\"],\""
    "skins\":[{\"joints\":[2,3],\"inverseBindMatrices\":9}],\"buffers\":[{\"byteLength\":376,\"uri\":\"data:;base64,AAAAAAAAAAAAA"
    "AAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAAAAAAAAAAAAAIA/AAACAAEAAAABAAMAAAADAAIAAQACAAMAAAAAAAAAAAAAAAAAAABAQAAAAAAAAAAAAAAAAAAA/"
    "38AAAAAglqCWgAAgD8AAIA/AACAPwAAAEAAAABAAAAAQAAAAAAAAAAAAAAAAAAAAEAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAA/1UAAP9VAAD/V"
    "QAA/1UBAAAAAABAQAAAAAAAAAAAAAEAAAABAAAAAQAAAAEAAP8AAAD/AAAA/wAAAP8AAAAAAIA/AAAAAAAAAAAAAAAAAAAAAAAAgD8AAAAAAAAAAAAAAAAAAAAAA"
    "ACAPwAAAAAAAAAAAAAAAAAAAAAAAIA/AACAPwAAAAAAAAAAAAAAAAAAAAAAAIA/AAAAAAAAAAAAAAAAAAAAAAAAgD8AAAAAAAAAAAAAgL8AAAAAAACAPw==\"}]}";
static const char lines_vtk[] = "# vtk DataFile Version 3.0\nx\nASCII\nDATASET POLYDATA\nPOINTS 5 float\n0 0 0\n1 0 0\n2 0 0\n0 1 0\n0 2 "
                                "0\nLINES 3 9\n3 0 1 2\n2 0 3\n1 4\n";
static const char lines_vtk5[] = "# vtk DataFile Version 5.1\nx\nASCII\nDATASET POLYDATA\nPOINTS 4 float\n0 0 0\n1 0 0\n2 0 0\n0 1 "
                                 "0\nLINES 3 4\nOFFSETS vtktypeint64\n0 2 4\nCONNECTIVITY vtktypeint64\n0 1 2 3\n";
static const char lines_vtp[] =
    "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" header_type=\"UInt64\"><PolyData><Piece NumberOfPoints=\"4\" "
    "NumberOfLines=\"2\">\n"
    "<PointData><DataArray type=\"Float32\" Name=\"a\" format=\"ascii\">1 2 3 4</DataArray></PointData>\n"
    "<Points><DataArray type=\"Float32\" NumberOfComponents=\"3\" format=\"ascii\">0 0 0 1 0 0 2 0 0 0 1 0</DataArray></Points>\n"
    "<Lines><DataArray type=\"Int64\" Name=\"connectivity\" format=\"ascii\">0 1 2 3</DataArray>\n"
    "<DataArray type=\"Int64\" Name=\"offsets\" format=\"ascii\">2 4</DataArray></Lines></Piece></PolyData></VTKFile>\n";
static const char lines_obj[] = "v 0 0 0\nv 1 0 0\nv 2 0 \\\n0\nv 0 1 0\nl 1 2\nl 3 2\nl -1/1 1/2 4\n";
static const char lines_json[] =
    "{\"fibers\":{\"polylines\":[{\"points\":[0,0,0,1,0,0],\"length\":1},{\"points\":[0,0,0,0,1,0,0,2,0]}]}}\n";
static const char areas_json[] =
    "{\"metersPerUnit\":0.001,\"areas\":[{\"bone\":\"ulna\",\"name\":\"tuberosity\",\"landmarks\":[[0,0,0],[1,0,0.5],"
    "[0,1,-2e0]]},{\"bone\":\"radius\",\"landmarks\":[0,0,0,1,0,0,0,1,0]}]}\n";
static const char areas_tsv[] = "# bone\tarea\tx\ty\tz\nulna\ttuberosity\t0\t0\t0\nulna\ttuberosity\t1\t0\t0.5\n"
                                "ulna\ttuberosity\t0\t1\t-2e0\nradius\t\t1\t2\t3\nradius\t\t1\t3\t3\nradius\t\t2\t2\t3\n";
static const char ends_text[] = "# ends\norigin 0 0 0\norigin 0.1, 0 0\ninsertion\t1\t2e-1\t-3\n";
static const char template_json[] =
    "{\"format\":\"sinew-fiber-template\",\"version\":1,\"name\":\"t\",\"curves\":[{\"points\":[0,0,0,0,0,1]},"
    "{\"points\":[1,0,0,1,0.5,0.5,1,0,1]}]}\n";
static const char ends_json[] = "{\"format\":\"sinew-fiber-ends\",\"version\":1,\"origin\":[0,1],\"insertion\":[3]}\n";
static const char muscle_json[] =
    "{\"format\":\"sinew-muscle\",\"version\":1,\"name\":\"t\\u00e9st\",\"metersPerUnit\":0.001,\n"
    "\"mesh\":{\"vertices\":[0,0,0, 1,0,0, 0,1,0, 0,0,1.5],\"triangles\":[0,2,1, 0,1,3, 1,2,3, 0,3,2],\n"
    "\"attributes\":{\"painted\":{\"components\":1,\"integer\":false,\"values\":[0,0.5,1,2]}},\n"
    "\"groups\":{\"names\":[\"a\",\"b\"],\"triangles\":[0,1,-1,0]}},\n"
    "\"roots\":{\"vertices\":[1,2],\"rule\":\"indices\"},\n"
    "\"structure\":{\"samples\":[{\"position\":[0.1,0.1,0.1],\"parent\":-1,\"branch\":0,\"axis\":[0,0,1],\"vertices\":[0,1]},\n"
    "{\"position\":[0.1,0.1,0.9],\"parent\":0,\"branch\":0,\"axis\":[0,0,1],\"vertices\":[2,3]}],\"spacing\":0.8},\n"
    "\"fibers\":{\"directions\":[0,0,1,0,0,1,0,0,1,1,0,0],\"field\":\"tree\",\"polylines\":[{\"points\":[0,0,0,0,0,1]}]},\n"
    "\"attachments\":[{\"bone\":\"ulna\",\"method\":\"contact\",\"vertices\":[0,3],\"distances\":[0.1,-0.2]}],\n"
    "\"unknown\":{\"kept\":[1,2,{\"x\":null}]},\n"
    "\"history\":[{\"tool\":\"mesh-clean\",\"version\":\"0.1.0\",\"args\":[\"--weld\",\"1e-6\"],\"input\":\"sha256:00\"}]}\n";
static const char reference_json[] =
    "{\"format\":\"sinew-muscle\",\"version\":1,\"metersPerUnit\":1,\"mesh\":{\"uri\":\"cube-big.ply\"}}\n";
static const char scene_json[] =
    "{\"format\":\"sinew-scene\",\"version\":1,\"name\":\"s\",\"metersPerUnit\":1,\"rate\":24,\"frames\":[0,10],\"preroll\":0.5,\n"
    "\"gravity\":[0,0,-9.81],\"solver\":{\"method\":\"xpbd\",\"substeps\":4,\"iterations\":2,\"threads\":1},\n"
    "\"motion\":{\"joints\":[{\"name\":\"elbow\",\"type\":\"hinge\",\"axis\":[0,1,0],\"point\":[0,0,0.3],\"keys\":[[0,0],[1,90]],\n"
    "\"interpolation\":\"smooth\"},{\"name\":\"wrist\",\"parent\":\"elbow\",\"type\":\"pose\",\"keys\":[{\"frame\":0,\"rotation\":[1,0,0,0]"
    ",\n"
    "\"translation\":[0,0,0]},{\"time\":1.5,\"matrix\":[1,0,0,0,0,1,0,0,0,0,1,0.5,0,0,0,1]}]}]},\n"
    "\"bones\":[{\"name\":\"ulna\",\"mesh\":\"cube.obj\",\"units\":\"mm\",\"joint\":\"elbow\"}],\n"
    "\"muscles\":[{\"name\":\"m\",\"rig\":\"rig.muscle.json\",\"activation\":{\"keys\":[[0,0],[1,1]]},\"contraction\":0.4,"
    "\"restActivation\":0.1,\n"
    "\"law\":\"paper\",\"stiffness\":{\"relaxed\":1e5,\"active\":1e7,\"internal\":1,\"dihedral\":1e-5,\"volume\":4000},\n"
    "\"volumeRatio\":[[0,1],[1,0.95]],\"density\":1060,\"damping\":5,\"iterations\":1,\"enabled\":true}]}\n";

static const char report_json[] =
    "{\"format\":\"sinew-error-time\",\"version\":1,\"errors\":\"equilibrium\",\"scene\":{\"hash\":\"sha256:00\",\"name\":null,\"muscles\":"
    "[\n"
    "{\"name\":\"m\",\"vertices\":4}]},\"reference\":{\"floor\":1e-6,\"order\":null},\"settings\":[\n"
    "{\"setting\":\"xpbd substeps=4 "
    "scheme=kohout\",\"points\":[{\"held\":0,\"error\":1e-2,\"cpuSeconds\":0.5},{\"held\":1,\"error\":null}]},\n"
    "{\"setting\":\"qn "
    "tolerance=1e-4\",\"points\":[{\"held\":0,\"error\":1e-3,\"solverError\":1e-4,\"cpuSeconds\":0.1,\"wallSeconds\":1}]}]}\n";
static const char settings_text[] =
    "# all keys\nxpbd substeps=4 iterations=2 scheme=romeo precision=single\n\nqn substeps=1\titerations=5 tolerance=1e-6 "
    "preconditioner=corotated # fast\r\nqn\n";

static const char walk_bvh[] =
    "HIERARCHY\r\nROOT hips {\r\n\tOFFSET 0 90.5 0\r\n\tCHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation\r\n"
    "\tJOINT left leg\r\n\t{\r\n\t\tOFFSET 10 -5 0\r\n\t\tCHANNELS 3 Zrotation Xrotation Zrotation\r\n\t\tJOINT toe\r\n\t\t{\r\n"
    "\t\t\tOFFSET 0 -80 1e1\r\n\t\t\tCHANNELS 0\r\n\t\t\tEnd Site\r\n\t\t\t{\r\n\t\t\t\tOFFSET 0 0 7\r\n\t\t\t}\r\n\t\t}\r\n\t}\r\n}\r\n"
    "ROOT prop\r\n{\r\nOFFSET 1 2 3\r\nCHANNELS 1 Yrotation\r\n}\r\nMOTION\r\nFrames:\t3\r\nFrame Time: .0083333\r\n"
    "0 90 0 1 2 3 4 5 6 7\r\n0 91 0 1 2 3 170 5 6 7\r\n1 92 0 1 2 3 -14 5 6 8\r\n";
static const char bones_asf[] =
    "# bones\n:version 1.10\n:name VICON\n:units\n mass 1.0\n length 0.45\n angle deg\n:documentation\n text\n:root\n order TX TY TZ RX "
    "RY RZ\n axis XYZ\n position 0 1 0\n orientation 0 0 9\n:bonedata\n begin\n id 1\n name arm\n direction 1 0 0\n length 4\n axis 0 0 90 "
    "XYZ\n dof rx tz\n limits (-10 10)\n   (-inf 20.0)\n end\n begin\n id 2\n name hand\n direction 0 1 0\n length 2\n axis 90 0 0 ZYX\n"
    " dof rz\n end\n begin\n name nail\n end\n:hierarchy\n begin\n root arm\n arm hand\n hand nail\n end\n:skin\n x.skin\n";
static const char wave_amc[] =
    "#!OML:ASF x\n:FULLY-SPECIFIED\n:DEGREES\n1\nroot 1 2 3 4 5 6\narm 10 1\nhand 20\n2\nroot 1 2 3 4 5 6\narm 11 1\n"
    "hand 21\nnail\n3\nroot 1 2 3 4 5 7\narm 190 1\nhand 2.2e1\n";
static const char sensors_json[] =
    "{\"format\":\"sinew-sensors\",\"version\":1,\"name\":\"s\",\"filter\":6,\"sides\":{\"side\":[\"a\",\"b\"],\"Side\":[\"x\",\"y\"]},"
    "\"muscles\":[\"m1_x\",\"m2_x\",\"m_y\"],\n"
    "\"sensors\":[{\"name\":\"angle_{side}\",\"type\":\"angle\",\"joint\":\"{side}\",\"axis\":\"-x\",\"curve\":[[0,0],[9.5,0.5],[90,1]]},\n"
    "{\"name\":\"fast\",\"type\":\"velocity\",\"joint\":\"b\",\"point\":\"a\",\"relativeTo\":\"world\",\"axis\":[0,3,4],\"filter\":10,"
    "\"trigger\":{\"threshold\":0.4,\"hysteresis\":0.1,\"when\":\"below\",\"attack\":0.02,\"hold\":0.1,\"decay\":0.2,\"level\":0.7}},\n"
    "{\"name\":\"far_{side}\",\"type\":\"distance\",\"joint\":\"{side}\",\"point\":{\"a\":[1,2,3],\"b\":\"a\"},\"to\":{\"joint\":\"world\","
    "\"point\":[0,0,1]},\"curve\":{\"a\":[[0,0],[1,1]],\"b\":[[0,1],[2,0]]}},\n"
    "{\"name\":\"turn\",\"type\":\"angularAcceleration\",\"joint\":\"b\"}],\n"
    "\"channels\":[{\"muscles\":\"m*_{Side}\",\"sensors\":[\"angle_{side}\",{\"sensor\":\"fast\",\"weight\":0.5}],\"combine\":\"sum\","
    "\"floor\":"
    "0.1},{\"muscles\":[\"other\",\"more\"],\"sensors\":\"far_a\",\"trigger\":{\"threshold\":0.5,\"decay\":0.1}}]}\n";
static const char channels_text[] =
    "{\"format\":\"sinew-activation\",\"version\":1,\"channels\":{\"biceps\":{\"times\":[0,1],\"values\":[0,1]},"
    "\"triceps\":{\"times\":[0],\"values\":[0.5]}}}";
static const char muscles_text[] = "# muscles\nbiceps brachii\n\n triceps \r\ndeltoid";

static const char walk_nodes[] =
    "sinew-nodes 1\nmetersPerUnit 0.01\nup y\nnode -1 root\n1 0 0 0 0 1 0 0 0 0 1 0\nnode 0 hip_$AssimpFbx$_PreRotation\n1 0 0 0 0 0 -1 90 "
    "0 1 0 "
    "0\nnode 1 hip\n2 0 0 0 0 2 0 0 0 0 2 0\nnode 2 knee\n1 0 0 0 0 1 0 -40 0 0 1 0\nbind 3\n1 0 0 0 0 0 -1 50 0 1 0 0\nanimation 25 2 "
    "walk\n"
    "channel 2 2 3 2\n0 0 90 0\n12 10 90 0\n0 1 0 0 0\n5 0.9 0.1 0.2 0\n12 0.7 0.7 0 0\n0 2 2 2\n12 2 2 2.5\nchannel 3 1 2 1\n0 0 -40 0\n"
    "0 1 0 0 0\n10 0 1 0 0\n0 1 1 1\nanimation 1000 0 still\nend\n";
static const char motion_json[] =
    "{\"format\":\"sinew-motion\",\"version\":1,\"name\":\"m\",\"metersPerUnit\":0.01,\"rate\":25,\"joints\":[{\"name\":\"a\",\"type\":"
    "\"pose\",\"rest\":[1,2,3],\"restRotation\":[1,0,0,0],\"end\":[1,2,9],\"keys\":[{\"frame\":0,\"rotation\":[1,0,0,0]},{\"frame\":4,"
    "\"rotation\":[0,1,0,0],\"translation\":[1,2,3]}]},{\"name\":\"b\",\"parent\":\"a\",\"type\":\"hinge\",\"axis\":[0,0,1],\"point\":"
    "[1,0,0],\"keys\":[[0,0],[0.1,90]]}],\"coordinates\":[{\"name\":\"a.x\",\"unit\":\"rad\",\"values\":[0,1,2,3,4]},{\"name\":\"a.y\","
    "\"unit\":\"m\",\"rate\":50,\"values\":[0,1]}],\"history\":[]}\n";
static const char skin_json[] = "{\"format\":\"sinew-envelope\",\"version\":1,\"name\":\"s\",\"metersPerUnit\":0.01,\"method\":\"wrap\","
                                "\"reach\":4,\"mesh\":{\"vertices\":"
                                "[0,0,0, 1,0,0, 0,1,0, 0,0,1.5],\"triangles\":[0,2,1, 0,1,3, 1,2,3, "
                                "0,3,2]},\"bones\":[\"a\",\"b\",\"c\"],\n\"influences\":{\"counts\":[1,2,3,1],"
                                "\"bones\":[0,1,0,2,1,0,2],\"weights\":[1,0.75,0.25,0.5,0.25,0.25,1]},\"history\":[]}\n";
static const char arm_tsv[] =
    "\xEF\xBB\xBF# an arm\r\nunits\tmm\r\nfolder\tbones\r\njoint\ttrunk\t-\troot|Hips\tpoint 0,0,1e3\tlevel up_left>up_right\t\r\n"
    "joint\tarm_{side}\ttrunk\t{s}arm\tsphere *_{Side}_humerus@far:{-}1,0,1,36@ball:{+}100,0,1300,40\thand_{side}\t-\r\n"
    "joint\tup_{side}\tarm_{side}\t{s}up\taxis a@far:0,0,-1,2 b?c*\t-\r\n"
    "joint\thand_{side}\tup_{side}\t{S}hand\tmiddle x y\ttip_{side}\tup_{side}>tip_{side}\r\n"
    "place\ttip_{side}\t{s}hand.end\tmean *\r\nbone\t*_{Side}_*\tarm_{side}\t0.0276\r\nbone\t*\ttrunk\tin\r\n"
    "leg\tarm_{side}\tup_{side}\thand_{side}\r\nfoot\thand_{side}\r\nmeet\tup_{side}\t*a\t*b\r\n";
static const char joints_osim[] =
    "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<OpenSimDocument Version=\"40000\"><Model name=\"m\"><Ground "
    "name=\"ground\"/>\n<BodySet><objects>"
    "<Body name=\"a\"><attached_geometry><Mesh name=\"g\"><socket_frame>..</socket_frame><scale_factors>1 2 "
    "3</scale_factors><mesh_file>a.vtp"
    "</mesh_file></Mesh></attached_geometry></Body><Body name=\"b\"/><Body name=\"c\"/></objects></BodySet>\n<JointSet><objects>\n"
    "<CustomJoint "
    "name=\"j\"><socket_parent_frame>g_offset</socket_parent_frame><socket_child_frame>/bodyset/a</socket_child_frame>\n<coordinates>"
    "<Coordinate name=\"q\"><default_value>0.1</default_value><range>-1 1</range><clamped>true</clamped><locked>false</locked></Coordinate>"
    "</coordinates>\n<frames><PhysicalOffsetFrame name=\"g_offset\"><socket_parent>/ground</socket_parent><translation>1 2 3</translation>"
    "<orientation>0 0.5 0</orientation></PhysicalOffsetFrame></frames>\n<SpatialTransform><TransformAxis name=\"rotation1\"><coordinates>q"
    "</coordinates><axis>0 0 1</axis><LinearFunction name=\"function\"><coefficients>1 0</coefficients></LinearFunction></TransformAxis>\n"
    "<TransformAxis name=\"translation1\"><coordinates>q</coordinates><axis>1 0 0</axis><MultiplierFunction name=\"function\"><function>\n"
    "<SimmSpline><x>-1 0 0.5 2</x><y>0 1 4 9</y></SimmSpline></function><scale>1.1</scale></MultiplierFunction></TransformAxis>\n"
    "<TransformAxis name=\"translation2\"><coordinates/><axis>0 1 0</axis><Constant name=\"function\"><value>0.5</value></Constant>"
    "</TransformAxis></SpatialTransform></CustomJoint>\n<FreeJoint name=\"k\"><socket_parent_frame>/bodyset/a</socket_parent_frame>"
    "<socket_child_frame>/bodyset/b</socket_child_frame></FreeJoint>\n<PinJoint name=\"l\"><socket_parent_frame>/bodyset/c"
    "</socket_parent_frame><socket_child_frame>/bodyset/b</socket_child_frame><coordinates><Coordinate "
    "name=\"p\"/></coordinates></PinJoint>\n"
    "</objects></JointSet><ConstraintSet><objects><CoordinateCouplerConstraint><coupled_coordinates_function><PiecewiseLinearFunction>"
    "<x>0 1</x><y>0 2</y></PiecewiseLinearFunction></coupled_coordinates_function>\n<independent_coordinate_names>q"
    "</independent_coordinate_names><dependent_coordinate_name>p</dependent_coordinate_name></CoordinateCouplerConstraint></objects>"
    "</ConstraintSet></Model></OpenSimDocument>\n";
static const char old_osim[] =
    "<OpenSimDocument Version=\"30000\"><Model name=\"m\"><BodySet><objects><Body name=\"ground\"><Joint/></Body>\n<Body name=\"b\"><Joint>"
    "<PinJoint name=\"k\"><parent_body>a</parent_body><location_in_parent>0 1 0</location_in_parent><location>0 0 0.5</location>"
    "<orientation>0.1 0.2 0.3</orientation><reverse>true</reverse>\n<CoordinateSet><objects><Coordinate name=\"q\"><motion_type>rotational"
    "</motion_type></Coordinate></objects></CoordinateSet></PinJoint></Joint>\n<VisibleObject><GeometrySet><objects><DisplayGeometry>"
    "<geometry_file>f.vtp</geometry_file><transform>0 0 1 1 1 1</transform></DisplayGeometry></objects></GeometrySet><scale_factors>3 3 3"
    "</scale_factors></VisibleObject></Body>\n<Body name=\"a\"><Joint><BallJoint "
    "name=\"j\"><parent_body>ground</parent_body></BallJoint></Joint>"
    "</Body></objects></BodySet></Model></OpenSimDocument>\n";
static const char dog_mjcf[] = "<mujoco model=\"m\"><compiler angle=\"degree\" eulerseq=\"xYz\" meshdir=\"bones/\"/>\n<default><joint "
                               "range=\"-10 20\"/><default class=\"c\">"
                               "<joint axis=\"0 1 0\" pos=\"1 0 0\"/><geom type=\"mesh\"/></default></default>\n<asset><mesh "
                               "file=\"femur.stl\" scale=\"2 2 2\"/></asset>\n"
                               "<worldbody><body name=\"a\" pos=\"0 0 1\" euler=\"10 20 30\"><freejoint name=\"root\"/><frame pos=\"1 2 "
                               "3\"><body name=\"b\" childclass=\"c\" "
                               "quat=\"1 0 0 1\">\n<joint name=\"q\" ref=\"5\"/><joint name=\"s\" type=\"slide\"/><geom name=\"f\" "
                               "mesh=\"femur\" pos=\"1 1 1\" xyaxes=\"0 1 0 -1 0 "
                               "0\"/>\n<body zaxis=\"1 1 0\"><joint type=\"ball\"/></body></body></frame></body></worldbody></mujoco>\n";
static const char walk_mot[] = "walk\nversion=1\nnRows=3\nnColumns=4\ninDegrees=yes\n\nUnits are S.I.\n\nendheader\ntime\tq\t"
                               "/jointset/k/p/value\tforce\n0.5\t1\t-2.5\tnan\n0.6\t2e1\t3\t4\n0.8\t90\t1\t0\n";

static const char lengths_tsv[] =
    "# lengths\ntime\telbow.angle\tbiceps.1\tbiceps.2\n0\t0\t0.20\t0.21\n0.1\t5\t0.198\t0.209\n0.2\t10\t0.196\t0.207\n"
    "0.3\t15\t0.195\tnan\n0.4\t20\t0.193\t0.204\n0.5\t25\t0.191\t0.202\n0.6\t30\t0.19\t0.201\n0.7\t35\t0.188\t0.2\n"
    "0.8\t40\t0.187\t0.198\n0.9\t35\t0.188\t0.2\n1\t30\t0.19\t\n1.1\t25\t0.191\t0.202\n1.2\t20\t0.193\t0.204\n";
static const char lengths_csv[] = "\"angle\",\"a b\",c\n1, 0.2 ,0.3\n2,,0.31\n3,0.22,0.32\n";
static const char measured_tsv[] =
    "muscle\tcoordinate\tangle\tarm.mm\tsd.mm\nbiceps\telbow\t10\t20\t2\nbiceps\telbow\t0\t21\t\nbrachialis\thip\t3\t4\t5\n";

static _Noreturn void give_up(const char *what) {
    fprintf(stderr, "mutate_readers: %s\n", what);
    exit(1);
}

static void path_of(const char *name, char *path, size_t size) { snprintf(path, size, "%s/%s", folder, name); }

static void add_seed(kind k, const char *name, const char *data, size_t size) {
    if (seed_count == SEED_LIMIT) give_up("too many seeds");
    seed *s = &seeds[seed_count++];
    s->kind = k;
    snprintf(s->name, sizeof s->name, "%s", name);
    s->content.data = malloc(size + 1);
    if (s->content.data == NULL) give_up("out of memory");
    memcpy(s->content.data, data, size);
    s->content.size = size;
}

/* The file also lies in the folder, where documents refer to it. */
static void add_text(kind k, const char *name, const char *text) {
    char path[512];
    path_of(name, path, sizeof path);
    FILE *file = fopen(path, "wb");
    if (file == NULL || fputs(text, file) < 0 || fclose(file) != 0) give_up("cannot write the good files");
    add_seed(k, name, text, strlen(text));
}

/* The cube in another format. */
static void add_cube(const sn_mesh *cube, const char *name, sn_mesh_encoding encoding) {
    char path[512];
    sn_error error = {0};
    sn_output *output;
    sn_blob blob;
    path_of(name, path, sizeof path);
    if (sn_output_open(path, false, &output, &error) != SN_OK ||
        sn_mesh_write(cube, sn_mesh_format_from_name(name), encoding, output, &error) != SN_OK ||
        sn_output_commit(output, &error) != SN_OK || sn_blob_read(path, &blob, &error) != SN_OK) {
        give_up(error.text);
    }
    add_seed(MESH, name, blob.data, blob.size);
    sn_blob_free(&blob);
}

/* What VTK wrote: forms that only it writes. */
static void add_vtk_files(void) {
    static const char *const names[] = {"text-42.vtk", "text-51.vtk",     "binary-42.vtk",   "binary-51.vtk", "text.vtp",
                                        "raw.vtp",     "inline-zlib.vtp", "base64-zlib.vtp", "raw-zlib.vtp",  "inline-big.vtp"};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        char path[512];
        sn_error error = {0};
        sn_blob blob;
        snprintf(path, sizeof path, "tests/data/vtk/%s", names[i]);
        if (sn_blob_read(path, &blob, &error) != SN_OK) give_up("tests/data is not there: run this in the root of the sources");
        add_seed(MESH, names[i], blob.data, blob.size);
        sn_blob_free(&blob);
    }
}

static void add_cache(void) {
    static const sn_vec3 positions[] = {{0, 0, 0}, {1, 2, 3}, {-1, 0.5, 1e-3}};
    char path[512];
    sn_error error = {0};
    sn_pc2 *cache;
    sn_blob blob;
    path_of("cache.pc2", path, sizeof path);
    if (sn_pc2_create(path, 3, 0.0, 1.0, &cache, &error) != SN_OK || sn_pc2_append(cache, positions, &error) != SN_OK ||
        sn_pc2_append(cache, positions, &error) != SN_OK || sn_pc2_commit(cache, &error) != SN_OK ||
        sn_blob_read(path, &blob, &error) != SN_OK) {
        give_up(error.text);
    }
    add_seed(CACHE, "cache.pc2", blob.data, blob.size);
    sn_blob_free(&blob);
    /* MDD: 2 frames of 3 points, at 0 and 1 s, all big-endian */
    static const unsigned char mdd[8 + 8 + 72] = {0, 0, 0, 2, 0, 0, 0, 3, 0, 0, 0, 0, 0x3f, 0x80, 0, 0, 0x40, 0x20, 0, 0, 0x3e, 0x80};
    add_seed(CACHE, "mdd.pc2", (const char *)mdd, sizeof mdd);
}

static void add_field(void) {
    sn_vec3 positions[] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    sn_triangle triangles[] = {{{0, 2, 1}}, {{0, 1, 3}}, {{1, 2, 3}}, {{0, 3, 2}}};
    const sn_mesh mesh = {.vertex_count = 4, .triangle_count = 4, .positions = positions, .triangles = triangles};
    const sn_distance_field_params params = sn_distance_field_defaults(0.5);
    sn_error error = {0};
    sn_distance_field field;
    sn_output *output;
    sn_blob blob;
    if (sn_distance_field_create(&mesh, &params, &field, &error) != SN_OK || sn_output_open_memory(&output, &error) != SN_OK ||
        sn_distance_field_save(&field, FIELD_HASH, output, &error) != SN_OK ||
        sn_output_take(output, "solid.field", &blob, &error) != SN_OK) {
        give_up(error.text);
    }
    add_seed(FIELD, "solid.field", blob.data, blob.size);
    sn_distance_field_free(&field);
    sn_blob_free(&blob);
}

/* A point that hangs on all vertices in order, and one on two that are listed. */
static void add_weights(void) {
    double all[] = {0.25, 0.25, 0.25, 0.25}, some[] = {0.5, 0.5};
    sn_index listed[] = {0, 3};
    sn_embedding_row rows[] = {{.count = 4, .weights = all}, {.count = 2, .vertices = listed, .weights = some}};
    const sn_embedding embedding = {.point_count = 2, .vertex_count = 4, .rows = rows};
    sn_error error = {0};
    sn_output *output;
    sn_blob blob;
    if (sn_output_open_memory(&output, &error) != SN_OK || sn_embedding_save(&embedding, FIELD_HASH, output, &error) != SN_OK ||
        sn_output_take(output, "fibers.weights", &blob, &error) != SN_OK) {
        give_up(error.text);
    }
    add_seed(WEIGHTS, "fibers.weights", blob.data, blob.size);
    sn_blob_free(&blob);
}

/* The same with its JSON as the only chunk, and the numbers in that. */
static void add_glb(void) {
    char data[sizeof sink_gltf + 32];
    size_t length = (sizeof sink_gltf - 1 + 3) / 4 * 4, size = 20 + length;
    memset(data, ' ', sizeof data);
    const uint32_t head[5] = {0x46546c67, 2, (uint32_t)size, (uint32_t)length, 0x4e4f534a};
    for (int i = 0; i < 20; i++) data[i] = (char)(head[i / 4] >> 8 * (i % 4));
    memcpy(data + 20, sink_gltf, sizeof sink_gltf - 1);
    add_seed(GLTF, "sink-glb.gltf", data, size);
}

static void make_seeds(void) {
    add_text(MESH, "cube.obj", cube_obj);
    add_text(MESH, "notch.off", notch_off);
    add_text(MESH, "extra.ply", extra_ply);
    add_text(MESH, "strips.ply", strips_ply);
    char path[512];
    sn_mesh cube;
    sn_error error = {0};
    path_of("cube.obj", path, sizeof path);
    if (sn_mesh_read(path, &cube, NULL, &error) != SN_OK) give_up(error.text);
    add_cube(&cube, "cube-text.ply", SN_ENCODING_ASCII);
    add_cube(&cube, "cube-little.ply", SN_ENCODING_LITTLE);
    add_cube(&cube, "cube-big.ply", SN_ENCODING_BIG);
    add_cube(&cube, "cube.stl", SN_ENCODING_LITTLE);
    add_cube(&cube, "cube-text.stl", SN_ENCODING_ASCII);
    add_cube(&cube, "cube.off", SN_ENCODING_ASCII);
    add_cube(&cube, "cube-text.vtp", SN_ENCODING_ASCII);
    add_cube(&cube, "cube-little.vtp", SN_ENCODING_LITTLE);
    add_cube(&cube, "cube-big.vtp", SN_ENCODING_BIG);
    sn_mesh_free(&cube);
    add_text(MUSCLE, "rig.muscle.json", muscle_json);
    add_text(MUSCLE, "reference.muscle.json", reference_json);
    add_text(SCENE, "arm.scene.json", scene_json);
    add_text(REPORT, "arm.report.json", report_json);
    add_text(SETTINGS, "all.settings", settings_text);
    add_text(MOTION, "walk.bvh", walk_bvh);
    add_text(MOTION, "wave.amc", wave_amc);
    add_text(SKELETON, "bones.asf", bones_asf);
    add_text(MOTION, "wave.motion.json", motion_json);
    add_text(SENSORS, "body.sensors.json", sensors_json);
    add_text(NAMES, "muscles.names", muscles_text);
    add_text(NAMES, "channels.names", channels_text);
    add_text(MOTION, "walk.nodes", walk_nodes);
    add_text(MODEL, "joints.osim", joints_osim);
    add_text(MODEL, "old.osim", old_osim);
    add_text(MODEL, "dog.mjcf", dog_mjcf);
    add_text(STORAGE, "walk.mot", walk_mot);
    add_text(BODY, "arm.body.tsv", arm_tsv);
    add_text(ENVELOPE, "skin.envelope.json", skin_json);
    add_text(LINES, "old-vtk.lines", lines_vtk);
    add_text(LINES, "new-vtk.lines", lines_vtk5);
    add_text(LINES, "vtp.lines", lines_vtp);
    add_text(LINES, "obj.lines", lines_obj);
    add_text(LINES, "json.lines", lines_json);
    add_text(GLTF, "sink.gltf", sink_gltf);
    add_glb();
    add_vtk_files();
    add_cache();
    add_field();
    add_weights();
    add_text(LANDMARKS, "areas.landmarks.json", areas_json);
    add_text(LANDMARKS, "areas.landmarks.tsv", areas_tsv);
    add_text(SITES, "ends.sites", ends_text);
    add_text(SITES, "fibers.sites", lines_vtp);
    add_text(TEMPLATE, "fan.template.json", template_json);
    add_text(ENDS, "some.ends.json", ends_json);
    add_text(ENDS, "fibers.ends.json", lines_json);
    add_text(LENGTHS, "flexed.lengths.tsv", lengths_tsv);
    add_text(LENGTHS, "plain.lengths.csv", lengths_csv);
    add_text(LENGTHS, "walk.lengths.sto", walk_mot);
    add_text(MEASURED, "elbow.measured.tsv", measured_tsv);
}

/* Each good file in a folder of its format. */
static void write_seeds(const char *target) {
    static const char *const formats[] = {"obj",   "ply",     "stl",  "off",      "vtk",    "vtp",   "muscle", "scene",
                                          "pc2",   "bvh",     "amc",  "asf",      "motion", "osim",  "mjcf",   "mot",
                                          "nodes", "sensors", "body", "envelope", "field",  "lines", "gltf"};
    mkdir(target, 0777);
    for (size_t k = 0; k < sizeof formats / sizeof *formats; k++) {
        char path[1024], part[16];
        snprintf(path, sizeof path, "%s/%s", target, formats[k]);
        snprintf(part, sizeof part, ".%s", formats[k]);
        mkdir(path, 0777);
        for (int i = 0; i < seed_count; i++) {
            if (strstr(seeds[i].name, part) == NULL) continue;
            snprintf(path, sizeof path, "%s/%s/%s", target, formats[k], seeds[i].name);
            FILE *file = fopen(path, "wb");
            if (file == NULL || fwrite(seeds[i].content.data, 1, seeds[i].content.size, file) != seeds[i].content.size ||
                fclose(file) != 0) {
                give_up("cannot write the seeds");
            }
        }
    }
}

/* ---- mutations ------------------------------------------------------------------------------------------------------ */

static size_t below(uint64_t *state, size_t count) { return count == 0 ? 0 : (size_t)(sn_random(state) * (double)count); }

/* Put `size` bytes in the place of `cut` bytes at `at`. */
static void replace(bytes *b, size_t at, size_t cut, const char *data, size_t size) {
    if (b->size - cut + size > b->capacity) return;
    memmove(b->data + at + size, b->data + at + cut, b->size - at - cut);
    memcpy(b->data + at, data, size);
    b->size = b->size - cut + size;
}

static void truncate_file(bytes *b, uint64_t *state) { b->size = below(state, b->size); }

static void flip_bytes(bytes *b, uint64_t *state) {
    for (size_t i = 0, count = 1 + below(state, 8); b->size > 0 && i < count; i++) {
        char *at = &b->data[below(state, b->size)];
        *at = (char)(below(state, 2) == 0 ? (size_t)*at ^ ((size_t)1 << below(state, 8)) : below(state, 256));
    }
}

/* A piece of the file, or of another one, somewhere else in it. */
static void splice(bytes *b, uint64_t *state) {
    const bytes *other = below(state, 2) == 0 ? b : &seeds[below(state, (size_t)seed_count)].content;
    char piece[256];
    size_t size = 1 + below(state, sizeof piece - 1), from = below(state, other->size);
    if (size > other->size - from) size = other->size - from;
    memcpy(piece, other->data + from, size);
    size_t at = below(state, b->size + 1), cut = below(state, 2) == 0 ? 0 : below(state, 64);
    if (cut > b->size - at) cut = b->size - at;
    replace(b, at, cut, piece, size);
}

static void remove_piece(bytes *b, uint64_t *state) {
    size_t at = below(state, b->size), cut = 1 + below(state, 64);
    if (b->size == 0) return;
    replace(b, at, cut > b->size - at ? b->size - at : cut, "", 0);
}

static bool is_number(char c) { return (c >= '0' && c <= '9') || c == '-' || c == '.' || c == '+' || c == 'e'; }

/* What stands in a number's place: limits of every integer, what is no number, what breaks a list. */
static const char *const numbers[] = {"0",
                                      "-1",
                                      "1",
                                      "2",
                                      "3",
                                      "7",
                                      "8",
                                      "9",
                                      "255",
                                      "256",
                                      "-0",
                                      "nan",
                                      "-inf",
                                      "1e9",
                                      "5e",
                                      "1e999",
                                      "--",
                                      "1e-400",
                                      "65536",
                                      "2147483647",
                                      "2147483648",
                                      "4294967295",
                                      "4000000000",
                                      "9223372036854775807",
                                      "99999999999999999999",
                                      "0.1",
                                      "-2147483649",
                                      "",
                                      "\"\"",
                                      "null",
                                      "0x10",
                                      "1,2",
                                      "[]",
                                      "1e308",
                                      "00000000000000000000000000000000000000001"};

/* Another number in the place of one; within the first `reach` bytes, where the counts of a header stand. */
static void edit_number(bytes *b, uint64_t *state, size_t reach) {
    size_t limit = b->size < reach ? b->size : reach, at = below(state, limit), tried = 0;
    while (tried < limit && !is_number(b->data[at])) {
        at = (at + 1) % limit;
        tried++;
    }
    if (tried == limit) return;
    size_t end = at;
    while (at > 0 && is_number(b->data[at - 1])) at--;
    while (end < b->size && is_number(b->data[end])) end++;
    const char *number = numbers[below(state, sizeof numbers / sizeof *numbers)];
    replace(b, at, end - at, number, strlen(number));
}

/* Four bytes that are a large count, a wrong index, NaN or infinity in binary. */
static void edit_word(bytes *b, uint64_t *state) {
    static const char words[][5] = {"\xff\xff\xff\xff", "\xff\xff\xff\x7f", "\0\0\0\x80", "\0\0\xc0\x7f", "\0\0\x80\x7f",
                                    "\x7f\xc0\0\0",     "\x10\0\0\0",       "\0\0\0\x10", "\0\0\0\0",     "\0\0\xf8\x7f"};
    if (b->size < 4) return;
    memcpy(b->data + below(state, b->size - 3), words[below(state, sizeof words / sizeof *words)], 4);
}

/* One line twice, or moved, or gone. */
static void edit_line(bytes *b, uint64_t *state) {
    if (b->size == 0) return;
    size_t start = below(state, b->size), end = start;
    while (start > 0 && b->data[start - 1] != '\n') start--;
    while (end < b->size && b->data[end] != '\n') end++;
    if (end < b->size) end++;
    char line[256];
    size_t size = end - start < sizeof line ? end - start : sizeof line;
    memcpy(line, b->data + start, size);
    if (below(state, 2) == 0) replace(b, start, size, "", 0);
    if (below(state, 2) == 0) replace(b, below(state, b->size + 1), 0, line, size);
}

static void mutate(bytes *b, uint64_t *state) {
    switch (below(state, 8)) {
    case 0:
        truncate_file(b, state);
        break;
    case 1:
        flip_bytes(b, state);
        break;
    case 2:
        splice(b, state);
        break;
    case 3:
        remove_piece(b, state);
        break;
    case 4:
        edit_number(b, state, SIZE_MAX);
        break;
    case 5:
        edit_number(b, state, 400);
        break;
    case 6:
        edit_word(b, state);
        break;
    default:
        edit_line(b, state);
        break;
    }
}

/* ---- the readers ---------------------------------------------------------------------------------------------------- */

/* Of the processor: a busy machine is no fault. */
static double seconds(void) {
    struct timespec now;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* What is wrong with the reader's answer; NULL = nothing. */
static const char *judge(sn_status status, const sn_error *error) {
    if (status == SN_OK) return NULL;
    if (error->text[0] == '\0') return "the error has no text";
    if (strpbrk(error->text, "\n\r") != NULL) return "the error is more than one line";
    if (error->file[0] == '\0') return "the error names no file";
    if (error->code != status) return "the error's code is not the status";
    if (status == SN_ERROR_MEMORY) return "it takes more memory than ten times the file and 64 MB";
    return status == SN_ERROR_INPUT || status == SN_ERROR_IO ? NULL : "the status is none of a reader's";
}

/* Ten times the file, which is in memory already, and 64 MB beside what is taken now; 0 = no limit. Sanitizers reserve too much for that.
 */
static void limit_memory(size_t file_size) {
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
    struct rlimit limit = {RLIM_INFINITY, RLIM_INFINITY};
    unsigned long pages = 0;
    getrlimit(RLIMIT_AS, &limit);
    limit.rlim_cur = limit.rlim_max;
    if (file_size > 0) {
        malloc_trim(0);
        FILE *file = fopen("/proc/self/statm", "r");
        if (file == NULL || fscanf(file, "%lu", &pages) != 1) give_up("cannot read /proc/self/statm");
        fclose(file);
        limit.rlim_cur = pages * (rlim_t)sysconf(_SC_PAGESIZE) + (64UL << 20) + 9 * file_size;
    }
    setrlimit(RLIMIT_AS, &limit);
#else
    (void)file_size;
#endif
}

/* What was read can be written as VTP, and comes back with as much of everything. */
static const char *try_again(const sn_mesh *mesh, sn_error *error) {
    char path[512];
    sn_output *output;
    sn_mesh back;
    path_of("again.vtp", path, sizeof path);
    if (sn_output_open(path, true, &output, error) != SN_OK) return "a file cannot be opened";
    if (sn_mesh_write(mesh, SN_MESH_VTP, SN_ENCODING_DEFAULT, output, error) != SN_OK) {
        sn_output_abort(output);
        return "the mesh cannot be written";
    }
    if (sn_output_commit(output, error) != SN_OK || sn_mesh_read(path, &back, NULL, error) != SN_OK)
        return "what is written cannot be read";
    bool same = back.vertex_count == mesh->vertex_count && back.triangle_count == mesh->triangle_count &&
                back.attribute_count == mesh->attribute_count;
    sn_mesh_free(&back);
    return same ? NULL : "the mesh that comes back is another";
}

static const char *try_mesh(const sn_blob *blob, bool nonfinite, sn_status *status, sn_error *error) {
    sn_mesh mesh;
    *status = sn_mesh_parse(blob, nonfinite, &mesh, error);
    if (*status != SN_OK) return mesh.positions == NULL ? NULL : "a refused mesh is left behind";
    const char *fault = nonfinite                                 ? NULL
                        : sn_mesh_validate(&mesh, error) != SN_OK ? "the mesh is not valid"
                        : blob->size < 65536                      ? try_again(&mesh, error)
                                                                  : NULL;
    sn_mesh_free(&mesh);
    return fault;
}

/* What was read must be writable too. */
static const char *write_muscle(const sn_muscle *muscle, const sn_document *document, sn_error *error) {
    sn_output *output;
    if (sn_output_open("/dev/null", false, &output, error) != SN_OK) return "/dev/null cannot be opened";
    sn_status status = sn_muscle_write(muscle, document, &(sn_write_options){0}, output, error);
    sn_output_abort(output);
    return status == SN_OK ? NULL : "the muscle cannot be written";
}

static const char *try_muscle(const sn_blob *blob, sn_status *status, sn_error *error) {
    const sn_read_options options = {.meters_per_unit = 1.0};
    sn_muscle muscle;
    sn_document *document = NULL;
    *status = sn_muscle_parse(blob, &options, &muscle, &document, error);
    if (*status != SN_OK) return NULL;
    const char *fault = sn_muscle_validate(&muscle, error) != SN_OK ? "the muscle is not valid" : write_muscle(&muscle, document, error);
    sn_document_free(document);
    sn_muscle_free(&muscle);
    return fault;
}

static const char *try_scene(const sn_blob *blob, sn_status *status, sn_error *error) {
    sn_scene scene;
    *status = sn_scene_parse(blob, true, &scene, error);
    if (*status != SN_OK) return NULL;
    const char *fault = sn_scene_validate(&scene, error) != SN_OK ? "the scene is not valid" : NULL;
    sn_scene_free(&scene);
    return fault;
}

static const char *judge_track(const sn_vertex_track *track) {
    if (track->sample_count < 1 || track->vertex_count != 3) return "frames of another mesh were taken";
    for (sn_index i = 0; i < track->sample_count; i++) {
        if (!isfinite(track->times[i]) || (i > 0 && !(track->times[i] > track->times[i - 1]))) return "the times do not ascend";
        if (!sn_finite3(sn_vertex_track_at(track, track->times[i], 2))) return "a coordinate is not finite";
    }
    return NULL;
}

static const char *try_cache(const sn_blob *blob, sn_status *status, sn_error *error) {
    FILE *file = fopen(blob->name, "wb");
    if (file == NULL || fwrite(blob->data, 1, blob->size, file) != blob->size || fclose(file) != 0) give_up("cannot write a cache");
    sn_pc2_data data;
    const sn_track_options options = {.vertex_count = 3, .rate = 24.0, .meters_per_unit = 0.01, .up_y = true};
    sn_vertex_track track;
    *status = sn_pc2_read(blob->name, &data, error);
    if (*status == SN_OK) sn_pc2_free(&data);
    *status = sn_vertex_track_read(blob->name, &options, &track, error);
    if (*status != SN_OK) return NULL;
    const char *fault = judge_track(&track);
    sn_vertex_track_free(&track);
    return fault;
}

static const char *try_report(const sn_blob *blob, sn_status *status, sn_error *error) {
    sn_error_time read;
    *status = sn_error_time_parse(blob, &read, error);
    if (*status != SN_OK) return NULL;
    const sn_error_point *point = sn_error_time_cheapest(&read, 1.0, NULL);
    const char *fault = point != NULL && !(point->total.worst <= 1.0) ? "the cheapest point does not reach the error" : NULL;
    sn_error_time_free(&read);
    return fault;
}

/* What was read is written and read again as the same. */
static const char *try_settings(const sn_blob *blob, sn_status *status, sn_error *error) {
    sn_setting *list, again;
    sn_index count;
    char text[SN_SETTING_LENGTH];
    const char *fault = NULL;
    *status = sn_settings_parse(blob->data, blob->size, &list, &count, error);
    if (*status != SN_OK) sn_error_set_file(error, blob->name);
    for (sn_index i = 0; *status == SN_OK && fault == NULL && i < count; i++) {
        sn_setting_format(&list[i], text);
        bool same = sn_setting_parse(text, &again, error) == SN_OK && memcmp(&again, &list[i], sizeof again) == 0;
        if (!same) fault = "the setting that comes back is another";
    }
    if (*status == SN_OK) free(list);
    return fault;
}

/* What was read can be filtered, resampled, and written. */
static const char *use_clip(sn_clip *clip, sn_error *error) {
    sn_motion motion = {0};
    sn_output *output;
    if (sn_clip_validate(clip, error) != SN_OK) return "the motion is not valid";
    if (sn_clip_filter(clip, 0.2 * clip->rate, NULL, error) != SN_OK) return "the motion cannot be filtered";
    if (sn_clip_resample(clip, 1.5 * clip->rate, error) != SN_OK) return "the motion cannot be resampled";
    if (sn_clip_validate(clip, error) != SN_OK) return "the motion is not valid any more";
    if (sn_clip_to_motion(clip, &motion, error) != SN_OK) return "the motion has no joints";
    if (sn_output_open("/dev/null", true, &output, error) != SN_OK) return "/dev/null cannot be opened";
    sn_status status = sn_motion_document_write(&motion, &(sn_motion_head){.rate = clip->rate}, output, error);
    sn_output_abort(output);
    sn_motion_free(&motion);
    return status == SN_OK ? NULL : "the motion cannot be written";
}

/* A motion, with the good skeleton where its name asks for one; or a skeleton, with the good motion. */
static const char *try_motion(const sn_blob *blob, bool skeleton, sn_status *status, sn_error *error) {
    const sn_clip_options options = {0};
    sn_blob other = {.name = (char[]){"good"}, .data = (char *)(uintptr_t)(skeleton ? wave_amc : bones_asf)};
    other.size = strlen(other.data);
    bool both = skeleton || strstr(blob->name, ".amc") != NULL;
    sn_clip clip;
    *status = sn_clip_parse(skeleton ? &other : blob, skeleton ? blob : both ? &other : NULL, &options, &clip, error);
    if (*status != SN_OK) return clip.joints == NULL ? NULL : "a refused motion is left behind";
    const char *fault = blob->size < 65536 ? use_clip(&clip, error) : NULL;
    sn_clip_free(&clip);
    return fault;
}

static const char *try_model(const sn_blob *blob, sn_status *status, sn_error *error) {
    sn_skeleton skeleton;
    sn_clip clip;
    *status = sn_mjcf_detect(blob) ? sn_mjcf_parse(blob, &skeleton, error) : sn_osim_parse(blob, &skeleton, error);
    if (*status != SN_OK) return skeleton.bodies == NULL ? NULL : "a refused model is left behind";
    *status = sn_skeleton_animate(&skeleton, NULL, &clip, error);
    if (*status != SN_OK) sn_error_set_file(error, blob->name); /* it knows bodies, not files: who reads the file names it */
    const char *fault = *status == SN_OK && blob->size < 65536 ? use_clip(&clip, error) : NULL;
    sn_clip_free(&clip);
    sn_skeleton_free(&skeleton);
    return fault;
}

/* The motion moves the good model too, or is refused. */
static const char *try_storage(const sn_blob *blob, sn_status *status, sn_error *error) {
    static char name[] = "joints.osim";
    static char text[sizeof joints_osim];
    sn_columns columns;
    sn_skeleton skeleton;
    sn_clip clip;
    memcpy(text, joints_osim, sizeof text);
    const sn_blob model = {.name = name, .data = text, .size = sizeof text - 1};
    sn_storage_detect(blob);
    *status = sn_storage_parse(blob, &columns, error);
    if (*status != SN_OK) return columns.values == NULL ? NULL : "a refused motion is left behind";
    if (sn_osim_parse(&model, &skeleton, error) != SN_OK) give_up(error->text);
    *status = sn_skeleton_animate(&skeleton, &columns, &clip, error);
    if (*status != SN_OK) sn_error_set_file(error, blob->name);
    const char *fault = *status == SN_OK ? use_clip(&clip, error) : NULL;
    sn_clip_free(&clip);
    sn_skeleton_free(&skeleton);
    sn_columns_free(&columns);
    return fault;
}

/* What was read can be measured on a motion, or names what that lacks; activations are in [0,1]. */
static const char *use_sensors(const sn_sensors *sensors) {
    static char name[] = "wave.motion.json", text[sizeof motion_json];
    const sn_clip_options options = {0};
    sn_sense_params params = SN_SENSE_PARAMS;
    sn_error error = {0};
    sn_clip clip;
    sn_sense sense;
    memcpy(text, motion_json, sizeof text);
    const sn_blob motion = {.name = name, .data = text, .size = sizeof text - 1};
    if (sn_clip_parse(&motion, NULL, &options, &clip, &error) != SN_OK) give_up(error.text);
    sn_status status = sn_sense_run(sensors, &clip, &params, &sense, &error);
    const char *fault = status == SN_OK || status == SN_ERROR_INPUT ? NULL : "the sensors cannot be measured";
    for (sn_index i = 0; status == SN_OK && i < sense.channel_count; i++)
        for (sn_index k = 0; k < sense.sample_count; k++)
            if (!(sense.activations[i][k] >= 0.0 && sense.activations[i][k] <= 1.0)) fault = "an activation is not in [0,1]";
    if (status == SN_OK) sn_sense_free(&sense);
    sn_clip_free(&clip);
    return fault;
}

static const char *try_sensors(const sn_blob *blob, sn_status *status, sn_error *error) {
    sn_sensors sensors;
    *status = sn_sensors_parse(blob, NULL, &sensors, error);
    if (*status != SN_OK) return sensors.sensors == NULL && sensors.channels == NULL ? NULL : "refused sensors are left behind";
    const char *fault = sensors.channel_count == 0 ? "there is no channel" : blob->size < 65536 ? use_sensors(&sensors) : NULL;
    sn_sensors_free(&sensors);
    return fault;
}

static const char *try_names(const sn_blob *blob, sn_status *status, sn_error *error) {
    sn_muscle_names names;
    bool channels = strstr(blob->data, "\"channels\"") != NULL; /* of an activation document */
    *status = channels ? sn_activation_names_parse(blob, &names, error) : sn_muscle_names_parse(blob, &names, error);
    if (*status != SN_OK) return names.names == NULL ? NULL : "refused names are left behind";
    sn_muscle_names_free(&names);
    return NULL;
}

/* What was read is linked: every name leads somewhere, parents come before children. */
static const char *try_body(const sn_blob *blob, sn_status *status, sn_error *error) {
    sn_fit_table table;
    const char *fault = NULL;
    *status = sn_fit_table_parse(blob, &table, error);
    if (*status != SN_OK) return table.joints == NULL && table.points == NULL ? NULL : "a refused table is left behind";
    for (sn_index j = 0; j < table.joint_count; j++) {
        if (table.joints[j].parent < SN_NONE || table.joints[j].parent >= j) fault = "a parent comes after its child";
        if (table.joints[j].along.given && (table.joints[j].along.to < 0 || table.joints[j].along.to >= table.point_count))
            fault = "a direction leads nowhere";
    }
    for (sn_index b = 0; b < table.bone_count; b++)
        if (table.bones[b].joint < 0 || table.bones[b].joint >= table.joint_count) fault = "a bone hangs nowhere";
    sn_fit_table_row(&table, blob->name);
    sn_fit_table_free(&table);
    return fault;
}

/* What was read is valid, moves with its bones, and can be written. */
/* As it is, and forged: under right hashes. */
static const char *try_field(const sn_blob *blob, sn_status *status, sn_error *error) {
    const char *fault = NULL;
    for (int forged = 0; forged < 2 && fault == NULL; forged++) {
        sn_distance_field field;
        if (forged) field_forge(blob);
        *error = (sn_error){0};
        *status = sn_distance_field_load(blob, FIELD_HASH, &field, error);
        fault = *status == SN_OK ? field_fault(&field) : judge(*status, error);
        if (*status == SN_OK) sn_distance_field_free(&field);
    }
    return fault;
}

static const char *try_lines(const sn_blob *blob, sn_status *status, sn_error *error) {
    sn_fibers fibers;
    sn_polylines_detect(blob);
    *status = sn_polylines_parse(blob, &fibers, error);
    if (*status != SN_OK) return fibers.polylines == NULL ? NULL : "refused fibres are left behind";
    const char *fault = fibers.polyline_count > 0 ? NULL : "no fibre is none";
    for (sn_index i = 0; i < fibers.polyline_count; i++) {
        if (fibers.polylines[i].count < 2) fault = "a fibre is a point";
        for (sn_index k = 0; k < fibers.polylines[i].count; k++)
            if (!sn_finite3(fibers.polylines[i].points[k])) fault = "a fibre goes through what is no place";
    }
    sn_fibers_free(&fibers);
    return fault;
}

/* Weights under the right name, as nobody checks more of them, move points wherever the vertices go. */
static const char *use_weights(const sn_embedding *embedding) {
    enum { MOST = 1 << 16 };
    for (sn_index i = 0; i < embedding->point_count; i++)
        for (sn_index k = 0; embedding->rows[i].vertices != NULL && k < embedding->rows[i].count; k++)
            if (embedding->rows[i].vertices[k] < 0 || embedding->rows[i].vertices[k] >= embedding->vertex_count)
                return "a weight is of no vertex";
    if (embedding->vertex_count > MOST) return NULL;
    sn_vec3 *positions = SN_NEW(sn_vec3, embedding->vertex_count), *points = SN_NEW(sn_vec3, embedding->point_count);
    if (positions == NULL || points == NULL) give_up("out of memory");
    sn_embedding_apply(embedding, positions, NULL, points);
    free(positions);
    free(points);
    return NULL;
}

/* As it is, and under the right name. */
static const char *try_weights(const sn_blob *blob, sn_status *status, sn_error *error) {
    const char *fault = NULL;
    for (int forged = 0; forged < 2 && fault == NULL; forged++) {
        sn_embedding embedding;
        if (forged && blob->size >= FIELD_CHECKSUM_AT) memcpy(blob->data + FIELD_NAME_AT, FIELD_HASH, sizeof FIELD_HASH);
        *error = (sn_error){0};
        *status = sn_embedding_load(blob, FIELD_HASH, &embedding, error);
        fault = *status == SN_OK ? use_weights(&embedding) : judge(*status, error);
        if (*status == SN_OK) sn_embedding_free(&embedding);
    }
    return fault;
}

/* For readers that take a path. */
static void put_file(const sn_blob *blob) {
    FILE *file = fopen(blob->name, "wb");
    if (file == NULL || fwrite(blob->data, 1, blob->size, file) != blob->size || fclose(file) != 0) give_up("cannot write a file");
}

/* The second column over the first: arms that are numbers or none, or a refusal. */
static const char *use_lengths(const sn_columns *c) {
    static const char *const muscle = "a";
    static const sn_index of = 0;
    double *x = calloc((size_t)c->row_count, sizeof *x), *y = calloc((size_t)c->row_count, sizeof *y);
    const double *lengths = y;
    sn_arm_params params = SN_ARM_PARAMS;
    sn_arm_input input = {.row_count = c->row_count,
                          .coordinate = x,
                          .fiber_count = 1,
                          .lengths = &lengths,
                          .muscle_count = 1,
                          .muscles = &muscle,
                          .muscle_of = &of};
    sn_error error = {0};
    sn_arms arms;
    if (x == NULL || y == NULL) give_up("out of memory");
    for (sn_index i = 0; i < c->row_count; i++) {
        double value = c->values[(size_t)i * (size_t)c->column_count];
        x[i] = isfinite(value) ? value : NAN;
        y[i] = c->values[(size_t)i * (size_t)c->column_count + 1];
    }
    sn_status status = sn_moment_arms(&input, &params, &arms, &error);
    const char *fault = status == SN_OK || (status == SN_ERROR_INPUT && error.text[0] != '\0') ? NULL : "the arms fail";
    for (sn_index k = 0; status == SN_OK && k < arms.sample_count; k++)
        if (isinf(arms.muscles[0].mean[k])) fault = "an arm is infinite";
    if (status == SN_OK) sn_arms_free(&arms);
    free(x);
    free(y);
    return fault;
}

static const char *try_lengths(const sn_blob *blob, sn_status *status, sn_error *error) {
    sn_columns columns;
    *status = sn_number_table_parse(blob, &columns, error);
    if (*status != SN_OK) return columns.values == NULL && columns.names == NULL ? NULL : "a refused table is left behind";
    const char *fault = columns.row_count < 1 || columns.column_count < 1 ? "a table of nothing" : NULL, *stem;
    size_t length;
    for (sn_index i = 0; i < columns.column_count; i++)
        if (sn_column_read_name(columns.names[i], &stem, &length) != SN_COLUMN_OTHER &&
            stem + length > columns.names[i] + strlen(columns.names[i]))
            fault = "a stem runs over its name";
    if (columns.times != NULL && isinf(sn_columns_at(&columns, 0, sn_columns_median_step(&columns), columns.times[0])) &&
        isfinite(columns.values[0]))
        fault = "a number becomes infinite";
    if (fault == NULL && columns.column_count > 1 && columns.row_count < 2000) fault = use_lengths(&columns);
    sn_columns_free(&columns);
    return fault;
}

static const char *try_measured(const sn_blob *blob, sn_status *status, sn_error *error) {
    sn_measured_choice choice = {.coordinate = "elbow.angle"};
    sn_measured_arms arms;
    const char *fault = NULL;
    *status = sn_measured_arms_parse(blob, &choice, &arms, error);
    if (*status != SN_OK) return arms.items == NULL ? NULL : "refused arms are left behind";
    for (sn_index i = 0; i < arms.count; i++)
        for (sn_index k = 0; k < arms.items[i].count; k++) {
            if (!(fabs(arms.items[i].arms[k]) <= 0.5) || !isfinite(arms.items[i].angles[k])) fault = "an arm is none";
            if (k > 0 && arms.items[i].angles[k] < arms.items[i].angles[k - 1]) fault = "angles do not ascend";
        }
    sn_measured_arms_free(&arms);
    return fault;
}

static const char *try_landmarks(const sn_blob *blob, sn_status *status, sn_error *error) {
    sn_landmarks landmarks;
    const char *fault = NULL;
    put_file(blob);
    *status = sn_landmarks_read(blob->name, &landmarks, error);
    if (*status != SN_OK) return landmarks.areas == NULL ? NULL : "refused landmarks are left behind";
    if (!(landmarks.meters_per_unit >= 0.0) || isinf(landmarks.meters_per_unit)) fault = "the unit is none";
    for (sn_index i = 0; i < landmarks.count; i++) {
        if (landmarks.areas[i].bone == NULL) fault = "an area is on no bone";
        for (sn_index k = 0; k < landmarks.areas[i].count; k++)
            if (!sn_finite3(landmarks.areas[i].landmarks[k])) fault = "a landmark is no place";
    }
    sn_landmarks_free(&landmarks);
    return fault;
}

static const char *try_sites(const sn_blob *blob, sn_status *status, sn_error *error) {
    sn_end_site *sites;
    sn_index count;
    put_file(blob);
    sn_space space;
    *status = sn_sites_read(blob->name, &count, &sites, &space, error);
    if (*status != SN_OK) return sites == NULL ? NULL : "refused sites are left behind";
    const char *fault = count > 0 ? NULL : "no site is none";
    for (sn_index i = 0; i < count; i++)
        if (!sn_finite3(sites[i].point)) fault = "a site is no place";
    free(sites);
    return fault;
}

static const char *try_template(const sn_blob *blob, sn_status *status, sn_error *error) {
    sn_fibers fibers;
    *status = sn_fiber_template_parse(blob, &fibers, error);
    if (*status != SN_OK) return fibers.polylines == NULL ? NULL : "a refused template is left behind";
    const char *fault = fibers.polyline_count > 0 ? NULL : "no curve is none";
    for (sn_index i = 0; i < fibers.polyline_count; i++)
        for (sn_index k = 0; k < fibers.polylines[i].count; k++)
            if (!sn_finite3(fibers.polylines[i].points[k])) fault = "a curve goes through what is no place";
    sn_fibers_free(&fibers);
    return fault;
}

static const char *try_ends(const sn_blob *blob, sn_status *status, sn_error *error) {
    sn_vec3 positions[] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    const sn_mesh mesh = {.vertex_count = 4, .positions = positions};
    sn_fiber_ends ends;
    *status = sn_fiber_ends_parse(blob, &mesh, &ends, error);
    if (*status != SN_OK) return ends.origin == NULL && ends.insertion == NULL ? NULL : "refused ends are left behind";
    const char *fault = ends.origin_count > 0 && ends.insertion_count > 0 ? NULL : "an end is nowhere";
    for (sn_index i = 0; i < ends.origin_count; i++)
        if (ends.origin[i] < 0 || ends.origin[i] > 3) fault = "fibres begin at no vertex";
    for (sn_index i = 0; i < ends.insertion_count; i++)
        if (ends.insertion[i] < 0 || ends.insertion[i] > 3) fault = "fibres end at no vertex";
    sn_fiber_ends_free(&ends);
    return fault;
}

/* Corners in range; *context counts the parts. */
static sn_status take_part(void *context, const sn_gltf_part *part, sn_error *error) {
    *(long *)context += 1;
    for (sn_index i = 0; i < part->corner_count; i++)
        if (part->corners[i] < 0 || part->corners[i] >= part->vertex_count)
            return sn_fail(error, SN_ERROR_INTERNAL, "a corner is out of range");
    return SN_OK;
}

static const char *try_gltf(const sn_blob *blob, sn_status *status, sn_error *error) {
    long parts = 0;
    bool unbound;
    const sn_gltf_source source = {.file = blob};
    *status = sn_gltf_read(&source, take_part, &parts, error);
    sn_error_set_file(error, blob->name);
    sn_error ignored = {0};
    if (*status == SN_OK && sn_gltf_check(blob, &unbound, &ignored) != SN_OK) return "what is read is refused by its extensions";
    return sn_gltf_is_old(blob) && parts > 1000000 ? "too many parts" : NULL;
}

static const char *try_envelope(const sn_blob *blob, sn_status *status, sn_error *error) {
    sn_envelope envelope;
    sn_output *output;
    sn_envelope_detect(blob);
    *status = sn_envelope_parse(blob, &envelope, error);
    if (*status != SN_OK)
        return envelope.mesh.positions == NULL && envelope.influences == NULL ? NULL : "a refused envelope is left behind";
    const char *fault = sn_envelope_validate(&envelope, error) == SN_OK ? NULL : "the envelope is not valid";
    sn_rigid *poses = SN_NEW(sn_rigid, envelope.bone_count);
    sn_vec3 *places = SN_NEW(sn_vec3, envelope.mesh.vertex_count);
    if (poses == NULL || places == NULL) give_up("out of memory");
    for (sn_index b = 0; b < envelope.bone_count; b++) poses[b] = sn_rigid_identity();
    sn_envelope_deform(&envelope, poses, NULL, places);
    double size = 0.0, moved = 0.0;
    for (sn_index v = 0; v < envelope.mesh.vertex_count; v++) {
        size = fmax(size, sn_norm(envelope.mesh.positions[v]));
        moved = fmax(moved, sn_distance(places[v], envelope.mesh.positions[v]));
    }
    if (moved > 1e-8 * size) fault = "an envelope at rest moves";
    if (sn_output_open("/dev/null", false, &output, error) != SN_OK) give_up("/dev/null cannot be opened");
    if (sn_envelope_write(&envelope, NULL, blob, output, error) != SN_OK) fault = "the envelope cannot be written";
    sn_output_abort(output);
    free(poses);
    free(places);
    sn_envelope_free(&envelope);
    return fault;
}

static void report(const char *name, const char *fault, const sn_error *error) {
    failed++;
    printf("case %ld (%s): %s; '%s' %s:%lld\n", current_case, name, fault, error->text, error->file, (long long)error->line);
}

static const struct itimerval LIMIT = {.it_value = {SECONDS_UNTIL_HANGING, 0}}, NO_LIMIT = {0};

static struct {
    char name[64];
    double seconds;
} longest;

static void note_time(const char *name, double taken) {
    if (!(taken > longest.seconds)) return;
    longest.seconds = taken;
    snprintf(longest.name, sizeof longest.name, "%s", name);
}

/* Read one file, held in memory of exactly its size. */
static void try_file(kind k, const char *name, const char *data, size_t size, bool nonfinite) {
    char path[512];
    sn_error error = {0};
    sn_status status = SN_OK;
    path_of(name, path, sizeof path);
    sn_blob blob = {.name = path, .data = malloc(size + 1), .size = size};
    if (blob.data == NULL) give_up("out of memory");
    memcpy(blob.data, data, size);
    blob.data[size] = '\0';
    setitimer(ITIMER_PROF, &LIMIT, NULL);
    limit_memory(size + 1);
    double start = seconds();
    sn_scene_detect(&blob);
    const char *fault = k == MESH        ? try_mesh(&blob, nonfinite, &status, &error)
                        : k == MUSCLE    ? try_muscle(&blob, &status, &error)
                        : k == SCENE     ? try_scene(&blob, &status, &error)
                        : k == REPORT    ? try_report(&blob, &status, &error)
                        : k == SETTINGS  ? try_settings(&blob, &status, &error)
                        : k == MOTION    ? try_motion(&blob, false, &status, &error)
                        : k == SKELETON  ? try_motion(&blob, true, &status, &error)
                        : k == MODEL     ? try_model(&blob, &status, &error)
                        : k == STORAGE   ? try_storage(&blob, &status, &error)
                        : k == SENSORS   ? try_sensors(&blob, &status, &error)
                        : k == NAMES     ? try_names(&blob, &status, &error)
                        : k == BODY      ? try_body(&blob, &status, &error)
                        : k == ENVELOPE  ? try_envelope(&blob, &status, &error)
                        : k == FIELD     ? try_field(&blob, &status, &error)
                        : k == LINES     ? try_lines(&blob, &status, &error)
                        : k == GLTF      ? try_gltf(&blob, &status, &error)
                        : k == WEIGHTS   ? try_weights(&blob, &status, &error)
                        : k == LANDMARKS ? try_landmarks(&blob, &status, &error)
                        : k == SITES     ? try_sites(&blob, &status, &error)
                        : k == TEMPLATE  ? try_template(&blob, &status, &error)
                        : k == ENDS      ? try_ends(&blob, &status, &error)
                        : k == LENGTHS   ? try_lengths(&blob, &status, &error)
                        : k == MEASURED  ? try_measured(&blob, &status, &error)
                                         : try_cache(&blob, &status, &error);
    double taken = seconds() - start;
    setitimer(ITIMER_PROF, &NO_LIMIT, NULL);
    limit_memory(0);
    free(blob.data);
    last_error = error;
    if (fault == NULL) fault = judge(status, &error);
    note_time(name, taken);
    if (fault != NULL) {
        report(name, fault, &error);
        return;
    }
    passed++;
    accepted += status == SN_OK;
}

static void try_case(long number) {
    uint64_t state = (uint64_t)number * 0x9e3779b97f4a7c15ULL + 1;
    const seed *s = &seeds[number % seed_count];
    bytes b = {.size = s->content.size, .capacity = s->content.size + GROWTH};
    b.data = malloc(b.capacity);
    if (b.data == NULL) give_up("out of memory");
    memcpy(b.data, s->content.data, b.size);
    current_case = number;
    for (size_t i = 0, count = 1 + below(&state, 3); i < count; i++) mutate(&b, &state);
    try_file(s->kind, s->name, b.data, b.size, below(&state, 4) == 0);
    free(b.data);
}

/* ---- files made to hurt --------------------------------------------------------------------------------------------- */

/* A file of a start, one row again and again, and an end. @ in the row is its number. */
static void try_rows(kind k, const char *name, const char *start, const char *row, size_t count, const char *end, bool nonfinite) {
    size_t capacity = strlen(start) + strlen(end) + count * (strlen(row) + 24) + 1, size = strlen(start);
    char *data = malloc(capacity);
    if (data == NULL) give_up("out of memory");
    memcpy(data, start, size);
    for (size_t i = 0; i < count; i++) {
        for (const char *at = row; *at != '\0'; at++) {
            if (*at == '@') {
                size += (size_t)snprintf(data + size, capacity - size, "%zu", i);
            } else {
                data[size++] = *at;
            }
        }
    }
    memcpy(data + size, end, strlen(end));
    current_case = -1;
    try_file(k, name, data, size + strlen(end), nonfinite);
    free(data);
}

/* A header and one byte again and again. */
static void try_block(const char *name, const char *start, size_t start_size, int byte, size_t size) {
    char *data = malloc(start_size + size);
    if (data == NULL) give_up("out of memory");
    memcpy(data, start, start_size);
    memset(data + start_size, byte, size);
    current_case = -1;
    try_file(MESH, name, data, start_size + size, false);
    free(data);
}

/* Files of some MB: ten times the file is then the limit, not the 64 MB. */
static void try_large_files(void) {
    enum { MANY = 2000000, BLOCK = 30 << 20 };
    static const char bytes_ply[] = "ply\nformat binary_little_endian 1.0\nelement vertex 9\nproperty uchar x\nproperty uchar y\n"
                                    "property uchar z\nelement face 110000\nproperty list uchar uchar vertex_indices\nend_header\n";
    static const char points_ply[] = "ply\nformat binary_little_endian 1.0\nelement vertex 6000000\nproperty uchar x\nproperty uchar y\n"
                                     "property uchar z\nproperty uchar a\nelement face 3\nproperty list uchar uchar vertex_indices\n"
                                     "end_header\n";
    static const char legacy[] = "# vtk DataFile Version 3.0\nx\nBINARY\nDATASET POLYDATA\n";
    try_rows(MESH, "colours.obj", "v 0 0 0\n", "v 0 0 0 1 1 1\n", MANY, "f 1 2 3\n", false);
    try_rows(MESH, "corners.obj", "v 0 0 0\nf", " 1", 4 * MANY, "\n", false);
    try_rows(MESH, "points.off", "OFF\n2000000 1 0\n", "0 0 0\n", MANY, "3 0 1 2\n", false);
    try_rows(MESH, "text.vtk", "# vtk DataFile Version 3.0\nx\nASCII\nDATASET POLYDATA\nPOINTS 2000000 float\n", "0 0 0\n", MANY,
             "POLYGONS 1 4\n3 0 1 2\n", false);
    try_rows(MESH, "text.vtp",
             "<VTKFile type='PolyData'><PolyData><Piece NumberOfPoints='2000000' NumberOfPolys='1'><Points><DataArray type='Int8'>",
             "0 0 0\n", MANY, "</DataArray></Points></Piece></PolyData></VTKFile>", false);
    try_rows(MESH, "arrays.vtp", "<VTKFile type='PolyData'><PolyData>", "<Piece NumberOfPoints='3'><Points><DataArray/></Points></Piece>",
             MANY / 10, "", false);
    static const char head[] = "{\"format\":\"sinew-muscle\",\"version\":1,\"x\":[";
    try_rows(MUSCLE, "objects.muscle.json", head, "{},", MANY, "{}]}", false);
    try_rows(MUSCLE, "arrays.muscle.json", head, "[0],", MANY, "[0]]}", false);
    try_rows(MUSCLE, "texts.muscle.json", head, "\"\",", MANY, "\"\"]}", false);
    try_rows(MUSCLE, "values.muscle.json", head, "null,0,", MANY, "0]}", false);
    try_rows(MUSCLE, "numbers.muscle.json", "{\"format\":\"sinew-muscle\",\"version\":1,\"mesh\":{\"vertices\":[0", ",0", 4 * MANY, "]}}",
             false);
    try_rows(MODEL, "tags.osim", "<OpenSimDocument><Model>", "<a/>", MANY, "</Model></OpenSimDocument>", false);
    try_rows(MODEL, "bodies.osim", "<OpenSimDocument><Model><BodySet><objects>", "<Body name='@'/>", 4000,
             "</objects></BodySet></Model></OpenSimDocument>", false);
    try_rows(MODEL, "bodies.mjcf", "<mujoco><worldbody>", "<body name='@'><joint name='@'/></body>", 4000, "</worldbody></mujoco>", false);
    try_rows(MODEL, "joints.mjcf", "<mujoco><worldbody><body>", "<joint name='@' pos='1 2 3'/>", MANY / 10, "</body></worldbody></mujoco>",
             false);
    try_rows(
        MODEL, "knots.osim",
        "<OpenSimDocument><Model><BodySet><objects><Body name='a'><Joint><CustomJoint><parent_body>ground</parent_body><SpatialTransform>"
        "<TransformAxis name='rotation1'><SimmSpline name='function'><x>",
        "1 ", 4 * MANY,
        "</x><y>1</y></SimmSpline></TransformAxis></SpatialTransform></CustomJoint></Joint></Body></objects></BodySet></Model></"
        "OpenSimDocument>",
        false);
    try_rows(STORAGE, "rows.mot", "x\nendheader\ntime other\n", "0 0\n", MANY, "", false);
    try_rows(STORAGE, "columns.mot", "x\nendheader\ntime", "\ta", MANY, "\n", false);
    try_block("corners.ply", bytes_ply, sizeof bytes_ply - 1, 0xff, BLOCK);
    try_block("bytes.ply", points_ply, sizeof points_ply - 1, 0, BLOCK);
    try_block("zeros.vtk", legacy, sizeof legacy - 1, 0, BLOCK);
    try_block("zeros.stl", "", 0, 0, 84); /* no triangles */
}

static void try_hostile_files(void) {
    enum { MANY = 100000 };
    static const char triangle[] = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0.2 0.2 0\n";
    try_rows(MESH, "polygon.obj", "v 0 0 0\nv 9 0 0\nv 1 1 0\nv 0 9 0\nf 1 2 3 4", " 1 2 3", MANY, "\n", false);
    try_rows(MESH, "polygons.obj", triangle, "f 1 2 4 3 1 2 4 3 1 2 4 3 1 2 4 3 1 2 4 3 1 2 4 3 1 2 4 3 1 2 4 3\n", MANY / 10, "", false);
    try_rows(MESH, "groups.obj", triangle, "g group@\nf 1 2 3\n", MANY, "", false);
    try_rows(MESH, "joined.obj", triangle, "\\\n", MANY, "f 1 2 3\n", false);
    try_rows(MESH, "digits.obj", "v ", "9", MANY, " 0 0\nf 1 1 1\n", false);
    try_rows(MESH, "nan.stl", "solid x\n",
             "facet normal 0 0 0\nouter loop\nvertex nan 0 @\nvertex nan nan nan\nvertex 0 -inf 0\nendloop\nendfacet\n", MANY / 4,
             "endsolid\n", true);
    try_rows(MESH, "properties.ply", "ply\nformat ascii 1.0\nelement vertex 1\n", "property float p@\n", MANY, "end_header\n", false);
    try_rows(MESH, "elements.ply", "ply\nformat ascii 1.0\n", "element e@ 4000000000\n", MANY, "end_header\n", false);
    try_rows(MESH, "deep.vtp", "<VTKFile type='PolyData'>", "<PolyData>", MANY, "", false);
    try_rows(MESH, "attributes.vtp", "<VTKFile type='PolyData' ", "a@='x' ", MANY, "/>", false);
    try_rows(MESH, "laughs.vtp", "<!DOCTYPE VTKFile [<!ENTITY e0 'ha'>", "<!ENTITY e1@ '&e@;&e@;'>", MANY / 10, "]><VTKFile>&e1;</VTKFile>",
             false);
    try_rows(MESH, "names.vtp", "<VTKFile type='PolyData'><PolyData><Piece NumberOfPoints='0'><PointData>", "<DataArray Name='x@'/>", MANY,
             "</PointData></Piece></PolyData></VTKFile>", false);
    try_rows(MESH, "fields.vtk", "# vtk DataFile Version 3.0\nx\nASCII\nDATASET POLYDATA\nFIELD f 100000\n", "a@ 1 0 int\n", MANY, "",
             false);
    try_rows(MESH, "metadata.vtk", "# vtk DataFile Version 3.0\nx\nASCII\nDATASET POLYDATA\n", "METADATA\nCOMPONENT_NAMES\n\n", MANY, "",
             false);
    try_rows(MUSCLE, "deep.muscle.json", "{\"format\":\"sinew-muscle\",\"version\":1,\"x\":", "[", MANY, "", false);
    try_rows(MUSCLE, "samples.muscle.json", "{\"format\":\"sinew-muscle\",\"version\":1,\"structure\":{\"samples\":[", "{\"parent\":@},",
             MANY / 2, "{}]}}", false);
    try_rows(SCENE, "joints.scene.json", "{\"format\":\"sinew-scene\",\"version\":1,\"motion\":{\"joints\":[",
             "{\"name\":\"j@\",\"type\":\"pose\",\"keys\":[{\"time\":0}]},", MANY / 20, "{}]}}", false);
    try_rows(SCENE, "muscles.scene.json", "{\"format\":\"sinew-scene\",\"version\":1,\"muscles\":[",
             "{\"name\":\"m@\",\"rig\":\"none\",\"enabled\":false},", MANY / 20, "{\"name\":\"m0\",\"rig\":\"x\",\"enabled\":false}]}",
             false);
}

static bool is_motion(const char *name) { return strstr(name, ".bvh") || strstr(name, ".amc") || strstr(name, ".motion."); }

static void try_hostile_motions(void) {
    enum { MANY = 100000 };
    static const char head[] = "HIERARCHY\nROOT r\n{\nOFFSET 0 0 0\nCHANNELS 1 Xrotation\n";
    static const char frames[] = "HIERARCHY\nROOT r\n{\nOFFSET 0 0 0\nCHANNELS 1 Xrotation\n}\nMOTION\nFrames: 100000\nFrame Time: 1\n";
    try_rows(MOTION, "deep.bvh", head, "JOINT j@ {\nOFFSET 0 0 0\n", MANY, "", false);
    try_rows(MOTION, "alike.bvh", head, "JOINT a {\nOFFSET 0 0 0\n}\n", 4000, "}\nMOTION\nFrames: 1\nFrame Time: 1\n1\n", false);
    try_rows(MOTION, "frames.bvh", frames, "1\n", MANY, "", false);
    try_rows(MOTION, "line.bvh", frames, "1 ", MANY, "", false);
    try_rows(MOTION, "still.bvh", head, "JOINT j@ {\nOFFSET 0 0 0\n}\n", 4000, "}\nMOTION\nFrames: 100000\nFrame Time: 1\n1\n", false);
    try_rows(MOTION, "frames.amc", ":DEGREES\n", "@\nhand 1\n", MANY, "", false);
    try_rows(MOTION, "keywords.amc", ":DEGREES\n", ":RADIANS\n", MANY, "1\nhand 1\n", false);
    try_rows(SKELETON, "bones.asf", ":bonedata\n", "begin\nname b@\nend\n", MANY, ":hierarchy\n", false);
    try_rows(SKELETON, "chain.asf", ":bonedata\nbegin\nname b4000\nend\n", "begin\nname b@\ndof rx ry rz\nend\n", 4000,
             ":hierarchy\nroot b4000\nb4000 b0\n", false);
    try_rows(MOTION, "samples.motion.json", "{\"format\":\"sinew-motion\",\"version\":1,\"coordinates\":[",
             "{\"name\":\"c@\",\"values\":[]},", MANY, "{}]}", false);
    try_rows(MOTION, "long.motion.json",
             "{\"format\":\"sinew-motion\",\"version\":1,\"joints\":[{\"name\":\"a\",\"type\":\"pose\",\"keys\":[", "{\"frame\":@000},",
             MANY / 10, "{\"frame\":99999999999}]}]}", false);
}

static void try_hostile_sensors(void) {
    enum { MANY = 100000 };
    static const char head[] = "{\"format\":\"sinew-sensors\",\"version\":1,\"sides\":[\"0\",\"1\",\"2\",\"3\",\"4\",\"5\",\"6\",\"7\"],";
    char start[1024];
    snprintf(start, sizeof start, "%s\"sensors\":[", head);
    try_rows(SENSORS, "many.sensors.json", start, "{\"name\":\"s@_{side}\",\"type\":\"angle\",\"joint\":\"a\",\"curve\":[[0,0],[1,1]]},",
             4000, "{}]}", false);
    try_rows(SENSORS, "some.sensors.json", start, "{\"name\":\"s@_{side}\",\"type\":\"angle\",\"joint\":\"a\",\"curve\":[[0,0],[1,1]]},",
             500, "{\"name\":\"t\",\"type\":\"angle\",\"joint\":\"a\",\"curve\":[[0,0],[1,1]]}]}", false);
    snprintf(start, sizeof start, "%s\"sensors\":[{\"name\":\"{side}", head);
    try_rows(SENSORS, "long.sensors.json", start, "{side}", MANY, "\",\"type\":\"angle\",\"joint\":\"a\"}]}", false);
    snprintf(start, sizeof start,
             "%s\"sensors\":[{\"name\":\"s\",\"type\":\"angle\",\"joint\":\"a\",\"curve\":[[0,0],[1,1]]}],\"channels\":[", head);
    try_rows(SENSORS, "channels.sensors.json", start, "{\"muscles\":\"m@\",\"sensors\":\"s\"},", 4000,
             "{\"muscles\":\"m\",\"sensors\":\"s\"}]}", false);
    snprintf(start, sizeof start,
             "%s\"sensors\":[{\"name\":\"s\",\"type\":\"angle\",\"joint\":\"a\",\"curve\":[[0,0],[1,1]]}],\"muscles\":["
             "\"aaaaaaaaaaaaaaaaaaaaab\"],"
             "\"channels\":[{\"sensors\":\"s\",\"muscles\":[",
             head);
    try_rows(SENSORS, "patterns.sensors.json", start, "\"*a*a*a*a*a*a*a*a*a*@\",", 4000, "\"m\"]}]}", false);
    try_rows(NAMES, "many.names", "", "m@\n", MANY, "", false);
}

/* Files that found a fault once: all are refused or read, as any other. */
static void try_kept_files(void) {
    struct dirent **entries;
    int count = scandir("tests/data/broken", &entries, NULL, alphasort);
    for (int i = 0; i < count; i++) {
        const char *name = entries[i]->d_name;
        char path[512];
        sn_error error = {0};
        sn_blob blob;
        snprintf(path, sizeof path, "tests/data/broken/%s", name);
        if (name[0] != '.' && sn_blob_read(path, &blob, &error) == SN_OK) {
            kind k = strstr(name, ".muscle.")     ? MUSCLE
                     : strstr(name, ".scene.")    ? SCENE
                     : strstr(name, ".pc2")       ? CACHE
                     : strstr(name, ".report.")   ? REPORT
                     : strstr(name, ".settings")  ? SETTINGS
                     : strstr(name, ".asf")       ? SKELETON
                     : is_motion(name)            ? MOTION
                     : strstr(name, ".osim")      ? MODEL
                     : strstr(name, ".mjcf")      ? MODEL
                     : strstr(name, ".mot")       ? STORAGE
                     : strstr(name, ".sensors.")  ? SENSORS
                     : strstr(name, ".names")     ? NAMES
                     : strstr(name, ".body")      ? BODY
                     : strstr(name, ".envelope")  ? ENVELOPE
                     : strstr(name, ".field")     ? FIELD
                     : strstr(name, ".lines")     ? LINES
                     : strstr(name, ".gltf")      ? GLTF
                     : strstr(name, ".weights")   ? WEIGHTS
                     : strstr(name, ".landmarks") ? LANDMARKS
                     : strstr(name, ".sites")     ? SITES
                     : strstr(name, ".template")  ? TEMPLATE
                     : strstr(name, ".ends")      ? ENDS
                     : strstr(name, ".lengths")   ? LENGTHS
                     : strstr(name, ".measured")  ? MEASURED
                                                  : MESH;
            try_file(k, name, blob.data, blob.size, false);
            sn_blob_free(&blob);
        }
        free(entries[i]);
    }
    if (count >= 0) free(entries);
}

/* ---- main ----------------------------------------------------------------------------------------------------------- */

static void on_alarm(int signal_number) {
    (void)signal_number;
    char text[64];
    int length = snprintf(text, sizeof text, "case %ld hangs\n0 passed, 1 failed\n", current_case);
    if (length > 0 && write(STDOUT_FILENO, text, (size_t)length) > 0) _exit(1);
    _exit(1);
}

static void remove_folder(void) {
    DIR *dir = opendir(folder);
    for (struct dirent *entry; dir != NULL && (entry = readdir(dir)) != NULL;) {
        char path[1024];
        snprintf(path, sizeof path, "%s/%s", folder, entry->d_name);
        if (entry->d_name[0] != '.') unlink(path);
    }
    if (dir != NULL) closedir(dir);
    rmdir(folder);
}

int main(int argc, char **argv) {
    bool seeds_only = argc > 2 && strcmp(argv[1], "--seeds") == 0;
    long count = argc > 1 ? strtol(argv[1], NULL, 10) : 20000, first = argc > 2 ? strtol(argv[2], NULL, 10) : 0;
    const char *base = getenv("TMPDIR");
    snprintf(folder, sizeof folder, "%s/sinew-mutate-XXXXXX", base != NULL ? base : "/tmp");
    if (mkdtemp(folder) == NULL) give_up("cannot make a folder");
    atexit(remove_folder);
    signal(SIGPROF, on_alarm);
    setvbuf(stdout, NULL, _IOLBF, 0);
    mallopt(M_MMAP_THRESHOLD, 1 << 20); /* so that what is freed does not count */
    make_seeds();
    if (seeds_only) {
        write_seeds(argv[2]);
        return 0;
    }
    for (int i = 0; i < seed_count; i++) {
        try_file(seeds[i].kind, seeds[i].name, seeds[i].content.data, seeds[i].content.size, false);
        if (accepted != i + 1) report(seeds[i].name, "a good file was refused", &last_error);
    }
    try_kept_files();
    try_hostile_files();
    try_hostile_motions();
    try_hostile_sensors();
    try_large_files();
    accepted = 0;
    for (long i = 0; i < count; i++) try_case(first + i);
    printf("%ld mutated files, of which %ld were still good\n", count, accepted);
    printf("the longest, %s, took %.2f s of the processor\n", longest.name, longest.seconds);
    for (int i = 0; i < seed_count; i++) free(seeds[i].content.data);
    printf("%ld passed, %ld failed\n", passed, failed);
    return failed > 0;
}
