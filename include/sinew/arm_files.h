/*
 * arm_files.h -- tables of lengths and coordinates, and measured moment arms, out of files.   rank 3
 */
#ifndef SINEW_ARM_FILES_H
#define SINEW_ARM_FILES_H

#include "sinew/io.h"
#include "sinew/moment_arm.h"
#include "sinew/skeleton.h"

/*
 * A table of numbers (lib/io/number_table.c): OpenSim's storage, else a row of names, then rows of numbers, parted by tabs, semicolons,
 * commas or blanks, whichever of these (in this order) the row of names has. Lines that are empty or begin with # are passed over; names
 * may be in double quotes. An empty cell is NaN, and so is "nan". A first column called time becomes the times, which then ascend; without
 * one, times are NULL. Errors name the line: also a decimal comma, and a row of another length.
 */
SN_MUST_CHECK sn_status sn_number_table_parse(const sn_blob *blob, sn_columns *out, sn_error *error);
/* The value of a column at a time: linear between rows. NaN where the rows begin later, end earlier, or are more than SN_TABLE_GAP times
 * the median step apart, and between values of which one is NaN. */
double sn_columns_at(const sn_columns *columns, sn_index column, double median_step, double time);
double sn_columns_median_step(const sn_columns *columns); /* s; of the times; 0 of one row */
#define SN_TABLE_GAP 5.0

/* What the name of a column says that it holds. */
typedef enum sn_column_kind {
    SN_COLUMN_PLAIN,   /* nothing */
    SN_COLUMN_FIBER,   /* "MUSCLE.7": a length by simulate */
    SN_COLUMN_LENGTH,  /* "/forceset/MUSCLE|length": a length by OpenSim */
    SN_COLUMN_DEGREES, /* "JOINT.angle" */
    SN_COLUMN_RADIANS, /* "NAME.rad" */
    SN_COLUMN_METERS,  /* "NAME.m" */
    SN_COLUMN_VALUE,   /* "/jointset/JOINT/NAME/value": a coordinate by OpenSim */
    SN_COLUMN_OTHER    /* any other path, as of speeds, activations, forces */
} sn_column_kind;
/* Kind, and what the name speaks of (MUSCLE, JOINT, NAME): *length characters at *stem, in the name itself. */
sn_column_kind sn_column_read_name(const char *name, const char **stem, size_t *length);
/* OpenSim's habit for coordinates that are ways: a stem that ends in _tx, _ty or _tz. */
bool sn_column_is_way(const char *stem, size_t length);

/*
 * Measured arms (lib/io/measured_arms.c): a table as above with the columns muscle, angle (degrees; or angle.rad; of a way: position,
 * metres) and arm (metres; or arm.cm, arm.mm), in any order; and, if they were measured, sd, or lower and upper, in the same units by the
 * same endings: the band is lower to upper, else arm - sd to arm + sd. A column coordinate chooses: rows of others than `coordinate` (by
 * stems) are skipped, and counted. Other columns are passed over. Rows without a number for the arm are left out. SN_ERROR_INPUT: no row is
 * left; an arm of more than 0.5 m; a band upside down.
 */
typedef struct sn_measured_choice {
    const char *coordinate;
    bool is_way;
    sn_index skipped; /* out: rows of other coordinates */
} sn_measured_choice;
SN_MUST_CHECK sn_status sn_measured_arms_parse(const sn_blob *blob, sn_measured_choice *choice, sn_measured_arms *out, sn_error *error);

#endif
