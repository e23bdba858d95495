/*
 * anatomy.h -- the sample arm in numbers: a right arm hanging straight down, palm forward.
 *
 * Millimetres; x forward, y towards the body, z up; the elbow's hinge is the y axis. A body is a smooth union of tubes that
 * follow a few cross-sections each; a carving tube is taken away instead. Sizes are those of a man of average height: humerus
 * 330 mm, forearm 250 mm, belly of the biceps about 13 cm^2.
 */
#ifndef ARM_ANATOMY_H
#define ARM_ANATOMY_H

#include <stdbool.h>

enum { ARM_MAX_SECTIONS = 10, ARM_MAX_TUBES = 6 };

/* An elliptical cross-section: centre and half axes. */
typedef struct arm_section {
    double x, y, z;
    double wide, thick; /* half axes along the tube's `across` direction and at right angles to it */
} arm_section;

typedef struct arm_tube {
    bool carve;       /* take it away from what the tubes before it have made */
    double blend;     /* width of the rounded seam with the tubes before it */
    double across[3]; /* direction of `wide`; it is made perpendicular to the tube everywhere */
    int count;
    arm_section sections[ARM_MAX_SECTIONS];
} arm_tube;

typedef struct arm_body {
    const char *name;
    int count;
    arm_tube tubes[ARM_MAX_TUBES];
} arm_body;

/* clang-format off */
static const arm_body arm_bodies[] = {
    {"scapula", 5, {
        /* glenoid, with the supraglenoid and infraglenoid tubercles at its ends */
        {false, 0, {1, 0, 0}, 4, {{-2, 44, 320, 5, 5}, {-2, 44, 308, 10, 5.5}, {-3, 44, 292, 12, 5.5}, {-4, 43, 276, 5, 5}}},
        /* neck, cut short */
        {false, 8, {0, 0, 1}, 3, {{-3, 46, 297, 13, 9}, {-6, 62, 298, 12, 8}, {-10, 80, 298, 12, 6}}},
        /* coracoid process */
        {false, 6, {0, 0, 1}, 4, {{-2, 60, 306, 8, 8}, {10, 56, 322, 7, 6}, {24, 43, 321, 6, 6}, {30, 36, 315, 5.5, 5.5}}},
        /* the dish of the glenoid follows the head of the humerus at a distance */
        {true, 2, {1, 0, 0}, 2, {{-4, 12, 296, 27, 27}, {-4, 12, 294, 27, 27}}},
        /* infraglenoid tubercle, whole again where the dish cut into it */
        {false, 3, {1, 0, 0}, 2, {{-4, 44, 282, 6, 5}, {-4, 44, 278, 5, 5}}},
    }},
    {"humerus", 6, {
        /* shaft, flaring into the condyles */
        {false, 0, {0, 1, 0}, 7, {{-1, 2, 290, 16, 15}, {0, 0, 262, 13.5, 13.5}, {0, 0, 215, 11.5, 11.5}, {0, 0, 150, 10.5, 10.5},
                                  {0, 0, 80, 11.5, 10}, {0, 1, 40, 17, 9}, {0, 1, 16, 23, 8}}},
        /* head */
        {false, 6, {0, 1, 0}, 2, {{-4, 12, 296, 23, 23}, {-4, 12, 294, 23, 23}}},
        /* greater tubercle */
        {false, 6, {0, 1, 0}, 2, {{4, -13, 296, 12, 12}, {3, -11, 284, 11, 11}}},
        /* trochlea (medial lip, groove) and capitulum */
        {false, 5, {1, 0, 0}, 6, {{0, 19, 0, 12, 12}, {0, 13, 0, 10.5, 10.5}, {0, 7, 0, 9, 9}, {0, -1, 0, 9.5, 9.5},
                                  {0, -13, 0, 11, 11}, {0, -19, 0, 9, 9}}},
        /* epicondyles */
        {false, 6, {0, 0, 1}, 3, {{-2, 29, 14, 7, 6}, {-1, 2, 15, 8, 6}, {-2, -25, 13, 6.5, 6}}},
        /* olecranon fossa */
        {true, 3, {0, 1, 0}, 2, {{-17, 6, 22, 9, 9}, {-16, 6, 12, 9, 9}}},
    }},
    {"ulna", 3, {
        /* olecranon, shaft, head */
        {false, 0, {0, 1, 0}, 8, {{-20, 6, 14, 8, 7}, {-22, 6, 2, 8.5, 7.5}, {-19, 6, -14, 9, 9}, {-12, 7, -34, 8.5, 9},
                                  {-9, 9, -60, 7, 8}, {-7, 13, -120, 6.5, 7}, {-3, 17, -195, 5.5, 5.5}, {-2, 18, -240, 8, 7}}},
        /* coronoid process */
        {false, 5, {0, 1, 0}, 3, {{-12, 6, -24, 9, 9}, {0, 6, -23, 8, 7}, {9, 6, -20, 6, 5}}},
        /* trochlear notch: a bearing around the trochlea */
        {true, 2, {1, 0, 0}, 2, {{0, 30, 0, 13.5, 13.5}, {0, -20, 0, 13.5, 13.5}}},
    }},
    {"radius", 3, {
        /* head, neck, shaft, flaring to the wrist */
        {false, 0, {0, 1, 0}, 8, {{1, -16, -14, 10, 10}, {1, -16, -22, 10, 10}, {1, -16, -33, 7.5, 7.5}, {0, -17, -62, 7.5, 7.5},
                                  {1, -22, -120, 8, 7}, {2, -22, -180, 8.5, 7.5}, {3, -19, -225, 13, 9}, {3, -17, -240, 15, 9}}},
        /* radial tuberosity: forward and towards the ulna */
        {false, 5, {0, 0, 1}, 2, {{1, -16, -46, 11, 7}, {7, -12.5, -46, 9, 6}}},
        /* cup of the head under the capitulum */
        {true, 2, {1, 0, 0}, 2, {{0, 10, 0, 13.5, 13.5}, {0, -40, 0, 13.5, 13.5}}},
    }},
    {"biceps", 2, {
        /* long head: supraglenoid tubercle, over the head of the humerus, down its groove; then the common distal tendon */
        {false, 0, {0, 1, 0}, 10, {{-1, 43, 317, 4.5, 4.5}, {8, 27, 329, 4.2, 4.2}, {25, 0, 316, 4.2, 4.2}, {32, -8, 280, 4.6, 4.6},
                                   {36, -10, 235, 9.5, 8.5}, {43, -10, 180, 16, 14.5}, {45, -8, 125, 16, 14}, {39, -3, 65, 6.5, 5.5},
                                   {27, -8, -8, 5.4, 4.2}, {9, -12.5, -46.5, 5, 4.2}}},
        /* short head: coracoid process, then beside the long head down to the distal tendon */
        {false, 6, {0, 1, 0}, 7, {{29, 38, 318, 4.5, 4.5}, {33, 26, 282, 4.6, 4.6}, {38, 17, 238, 9, 8.5}, {44, 12, 180, 16, 14.5},
                                  {45, 9, 125, 15, 13.5}, {40, 0, 72, 6, 5.5}, {36, -4, 46, 4, 4}}},
    }},
    {"brachialis", 1, {
        /* broad and flat: front of the humerus to the coronoid process */
        {false, 0, {0, 1, 0}, 8, {{11, -4, 204, 7, 4}, {13, -2, 182, 15, 6.5}, {15, 0, 152, 21, 8.5}, {20, 0, 112, 24, 8.5},
                                  {21, 2, 72, 21, 7.5}, {21, 6, 32, 13, 6}, {19.5, 8, -2, 8, 4.5}, {8, 6.5, -22, 6, 4}}},
    }},
    {"triceps", 2, {
        /* long head: infraglenoid tubercle, belly, flat tendon to the olecranon */
        {false, 0, {0, 1, 0}, 8, {{-5, 44, 281, 4.5, 4.5}, {-16, 33, 252, 8, 7}, {-30, 21, 212, 15, 13.5}, {-35, 13, 165, 18, 17},
                                  {-35, 9, 115, 18, 14.5}, {-29, 6, 65, 15, 7}, {-25.5, 6, 34, 10, 4.5}, {-22, 6, 17, 7, 4}}},
        /* lateral head: back of the humerus below its head */
        {false, 6, {0, 1, 0}, 6, {{-10, -5, 258, 5, 4}, {-20, -9, 236, 10, 8}, {-31, -14, 195, 15, 14.5}, {-34, -12, 150, 16, 14.5},
                                  {-32, -6, 105, 13, 12}, {-28, 2, 65, 8, 6}}},
    }},
};
/* clang-format on */

enum { ARM_BODY_COUNT = sizeof arm_bodies / sizeof *arm_bodies };

#endif
