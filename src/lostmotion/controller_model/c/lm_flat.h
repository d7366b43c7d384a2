/* The model with flat arrays alone, for Simulink's C Caller block and for languages without C structures. */
#ifndef LM_FLAT_H
#define LM_FLAT_H

#include "lm_core.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Numbers of results. */
#define LM_FLAT_PREDICTION (34 + 8 * LM_JOINTS)
#define LM_FLAT_COMMAND (7 + LM_JOINTS)

/* q [joints], load [10], gravity [3], side [joints] as in lm_input. Results in the order of lm_output: status, flags, turn (9), point (3),
 * torques, joints, elsewhere (6), screw (6), covariance (6), mean square, length95, jacobian (6 x joints). */
void lm_flat_predict(const double q[], const double load[], const double gravity[], const double side[], double out[]);

/* options [4]: passes, whole_pose, damping, largest_step as in lm_options. Results: status, joint values to send, motion of the tool that remains (6). */
void lm_flat_compensate(const double q[], const double load[], const double gravity[], const double side[], const double options[], double out[]);

#ifdef __cplusplus
}
#endif
#endif
