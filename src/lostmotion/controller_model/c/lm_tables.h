/* Layout of the tables, for lm_core.c and the generated lm_model.c alone. The Python package lostmotion defines it in controller_model/tables.py. */
#ifndef LM_TABLES_H
#define LM_TABLES_H

#include "lm_core.h"

typedef struct {
    lm_real start, width, slope;
} lm_piece;

/* base + sum of slope x clip(|load| - start, 0, width); odd: times the sign of the load; travels: of the joint value in place of |load|;
 * weights: of the load by the weights alone */
typedef struct {
    lm_real base;
    int odd, travels, weights, first, count; /* pieces */
    lm_real way[6];
} lm_curve;

typedef struct {
    lm_real order, turns;
    int cosine;
} lm_harmonic;

typedef struct {
    int size; /* directions, 1 to 3 */
    lm_real way[18];
} lm_seat;

/* Share of robots in which a load exceeds the friction. Piecewise linear with `count` pieces, or truncated normal without any. */
typedef struct {
    int seat;
    lm_real lever, nominal, tolerance;
    lm_real base;
    int first, count; /* pieces */
    lm_real scale, low, whole;
} lm_friction;

typedef struct {
    int first, count; /* frictions; the largest share counts */
} lm_threshold;

/* Displacements of a shaft on two rows: cubic splines over three coordinates of the loads. */
typedef struct {
    const lm_real *knots[3];
    int nodes[3];
    const lm_real *coefficients; /* [nodes 0][nodes 1][nodes 2][3] */
    int has_clearance, preloaded;
} lm_spline;

typedef struct {
    int axial;
    int seats[3];
    lm_real power, top, rim, bottom, step;
    const lm_spline *own;
    const lm_spline *wider; /* displacements at a clearance larger by `step`, or with step 0 their growth; 0: the clearance does not scatter */
} lm_load_table;

typedef struct {
    int a, b, c; /* factors */
} lm_size;

typedef struct {
    int size, side;
    lm_real direction[6];
} lm_entry;

typedef struct {
    int size, side;
    lm_real value;
} lm_axis_entry;

typedef struct {
    int first, second, side;
    lm_real matrix[21]; /* upper triangle, row by row */
} lm_product;

typedef struct {
    int first, second, side;
    lm_real value;
} lm_axis_product;

/* The sum of column column' is the constant covariance of a place, without its variance along the axis of the joint. */
typedef struct {
    lm_real direction[6];
} lm_column;

typedef struct {
    int draw;
    lm_real share; /* of compliance and own weight of the place, and with them: */
    const lm_real *compliance; /* 36 numbers, or 0 */
    const lm_real *own_weight; /* 18 numbers, or 0 */
    int first, count;          /* entries */
} lm_shared;

typedef struct {
    int parent, joint, axis, errs; /* axis of the joint in a twist: 2 turning, 5 sliding; errs: its motion or errors move the tool */
    int play;                      /* flags where a play of the place is open */
    lm_real rotation[9], offset[3];
    lm_real mass, moment[3];
    lm_real mean[6];
    const lm_real *compliance; /* 36 numbers, or 0 */
    const lm_real *own_weight; /* 18 numbers, or 0 */
    lm_real axis_variance;     /* constant variance along the axis of the joint */
    int curve, curves;         /* first index and count of each list */
    int harmonic, harmonics;
    int seat, seats;
    int threshold, thresholds;
    int table, tables;
    int size, sizes;
    int entry, entries;
    int axis_entry, axis_entries;
    int product, products;
    int axis_product, axis_products;
    int column, columns;
    int shared, shareds;
} lm_place;

typedef struct {
    lm_real payload, reach, force, moment, gravity;
} lm_validity;

extern const lm_place lm_places[];
extern const lm_piece lm_pieces[];
extern const lm_curve lm_curves[];
extern const lm_harmonic lm_harmonics[];
extern const lm_seat lm_seats[];
extern const lm_friction lm_frictions[];
extern const lm_threshold lm_thresholds[];
extern const lm_load_table lm_load_tables[];
extern const lm_size lm_sizes[];
extern const lm_entry lm_entries[];
extern const lm_axis_entry lm_axis_entries[];
extern const lm_product lm_products[];
extern const lm_axis_product lm_axis_products[];
extern const lm_column lm_columns[];
extern const lm_shared lm_shareds[];
extern const lm_real lm_limits[2 * LM_JOINTS]; /* lower and upper limit of each joint */
extern const lm_real lm_rated[LM_JOINTS];
extern const lm_real lm_load[10];
extern const lm_real lm_gravity[3];
extern const lm_validity lm_valid;

/* A tested pose: what goes in, and part of what must come out. */
typedef struct {
    lm_input input;
    lm_real point[3], screw[6], covariance[6], torques[LM_JOINTS], length95, command[LM_JOINTS];
} lm_vector;

extern const lm_vector lm_vectors[LM_VECTORS];

#endif
