/* Error model of a robot arm for its controller: prediction and compensation in a fixed number of steps.
 *
 * C99 with math.h alone: no heap, no recursion, no static state. All functions are reentrant.
 * SI units: rad, m, N, N m, kg. A twist is (rotation, displacement), a wrench (moment, force), in the axes of the base.
 * The tables are in lm_model.c; lm_model.h has their sizes. Both are generated; this file is the same for every arm.
 */
#ifndef LM_CORE_H
#define LM_CORE_H

#include "lm_model.h"

#if defined(__FAST_MATH__) || (defined(__FINITE_MATH_ONLY__) && __FINITE_MATH_ONLY__)
#error "with -ffast-math, inputs that are not numbers would not be recognised"
#endif

#ifdef LM_FLOAT
typedef float lm_real;
#else
typedef double lm_real;
#endif

#ifdef __cplusplus
extern "C" {
#endif

/* Status. Outputs are zero unless it is LM_OK or LM_SINGULAR. */
#define LM_OK 0
#define LM_INPUT 1    /* an input that is not finite, a last motion beyond -1 .. 1, or an option out of its range */
#define LM_RANGE 2    /* a joint out of its range */
#define LM_LOAD 3     /* a load or an acceleration beyond the tables */
#define LM_SINGULAR 4 /* compensation alone: a step was reduced, or no command leaves less than the wanted joint values */

/* Flags: information, no errors. */
#define LM_OPEN_PLAY 1  /* a play is open in some robots: the direction of approach counts */
#define LM_OVERLOAD 2   /* a drive above its rated torque */
#define LM_JOINT_PLAY 4 /* times 2^k: LM_OPEN_PLAY in the drive or in the bearings of joint k, k < 29 */

typedef struct {
    lm_real q[LM_JOINTS];    /* joint values, rad or m */
    lm_real load[10];        /* mass, centre of mass (3), process force (3) and moment (3), in the axes of the tool */
    lm_real gravity[3];      /* acceleration of free fall in the axes of the base, m/s^2 */
    lm_real side[LM_JOINTS]; /* sign of the last motion of each joint, -1 .. 1; 0 where it is not known */
} lm_input;

typedef struct {
    int status;                      /* LM_OK .. LM_LOAD */
    int flags;                       /* sum of LM_OPEN_PLAY, LM_OVERLOAD and LM_JOINT_PLAY times 2^k of each joint k < 29 concerned */
    lm_real turn[9];                 /* rotation of the tool without errors, row by row */
    lm_real point[3];                /* tool point without errors, m */
    lm_real torques[LM_JOINTS];      /* held by the drives, positive along the motion of the joint, N m or N */
    lm_real joints[LM_JOINTS];       /* expected deflection along each joint, rad or m */
    lm_real elsewhere[6];            /* expected motion of the tool by links, bearings and base */
    lm_real screw[6];                /* expected motion of the tool */
    lm_real covariance[6];           /* of its displacement: xx xy xz yy yz zz, m^2 */
    lm_real mean_square;             /* of the position error, m^2 */
    lm_real length95;                /* 95th percentile of the position error, m */
    lm_real jacobian[6 * LM_JOINTS]; /* motion of the tool per motion of a joint, row by row */
} lm_output;

typedef struct {
    int passes;           /* 1 or 2: two where links and bearings bend, one is exact for joints */
    int whole_pose;       /* 0: the position is corrected; 1: the rotation as well */
    lm_real damping;      /* of the inverse of the Jacobian, m^2, 1e-8 .. 1: more means smaller steps near singular poses, and more error left */
    lm_real largest_step; /* of a joint near singular poses, for what links, bearings and base move, rad or m, at least 0 */
} lm_options;

typedef struct {
    int status;
    lm_real q[LM_JOINTS]; /* joint values to send, within the limits */
    lm_real left[6];      /* expected motion of the tool that remains, under the loads where the arm then stands */
} lm_command;

/* Names of the joints in the order of q, UTF-8. */
extern const char *const lm_joint_names[LM_JOINTS];

/* Fill an input with the payload and gravity of the arm file, unknown last motions, and joint values of zero, or of the middle of a range without it. */
void lm_defaults(lm_input *input);

/* Fill options with one pass for the position alone, a damping of 1e-5 m^2 and a largest step of 10 mrad (or 10 mm). */
void lm_default_options(lm_options *options);

/* Predict pose, torques and error of the tool. Return the status, as in `output`. */
int lm_predict(const lm_input *input, lm_output *output);

/* Predict, and find the joint values whose tool is expected at the error-free pose of the input. Return the status, as in `command`. */
int lm_compensate(const lm_input *input, const lm_options *options, lm_output *output, lm_command *command);

/* Evaluate the stored poses and return how many of them differ from the stored results: 0 on a machine that computes correctly. */
int lm_self_test(void);

#ifdef __cplusplus
}
#endif
#endif
