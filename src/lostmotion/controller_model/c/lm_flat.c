#include "lm_flat.h"

static void lm_flat_input(const double q[], const double load[], const double gravity[], const double side[], lm_input *input)
{
    int k;
    for (k = 0; k < LM_JOINTS; k++) {
        input->q[k] = (lm_real)q[k];
        input->side[k] = (lm_real)side[k];
    }
    for (k = 0; k < 10; k++) {
        input->load[k] = (lm_real)load[k];
    }
    for (k = 0; k < 3; k++) {
        input->gravity[k] = (lm_real)gravity[k];
    }
}

static int lm_flat_copy(const lm_real values[], int count, double out[], int at)
{
    int k;
    for (k = 0; k < count; k++) {
        out[at + k] = (double)values[k];
    }
    return at + count;
}

void lm_flat_predict(const double q[], const double load[], const double gravity[], const double side[], double out[])
{
    lm_input input;
    lm_output found;
    int at = 2;
    lm_flat_input(q, load, gravity, side, &input);
    out[0] = (double)lm_predict(&input, &found);
    out[1] = (double)found.flags;
    at = lm_flat_copy(found.turn, 9, out, at);
    at = lm_flat_copy(found.point, 3, out, at);
    at = lm_flat_copy(found.torques, LM_JOINTS, out, at);
    at = lm_flat_copy(found.joints, LM_JOINTS, out, at);
    at = lm_flat_copy(found.elsewhere, 6, out, at);
    at = lm_flat_copy(found.screw, 6, out, at);
    at = lm_flat_copy(found.covariance, 6, out, at);
    at = lm_flat_copy(&found.mean_square, 1, out, at);
    at = lm_flat_copy(&found.length95, 1, out, at);
    (void)lm_flat_copy(found.jacobian, 6 * LM_JOINTS, out, at);
}

void lm_flat_compensate(const double q[], const double load[], const double gravity[], const double side[], const double options[], double out[])
{
    lm_input input;
    lm_output found;
    lm_command command;
    lm_options chosen;
    int at;
    chosen.passes = (options[0] > 1.0) ? 2 : 1;
    chosen.whole_pose = (options[1] > 0.0) ? 1 : 0;
    chosen.damping = (lm_real)options[2];
    chosen.largest_step = (lm_real)options[3];
    lm_flat_input(q, load, gravity, side, &input);
    out[0] = (double)lm_compensate(&input, &chosen, &found, &command);
    at = lm_flat_copy(command.q, LM_JOINTS, out, 1);
    (void)lm_flat_copy(command.left, 6, out, at);
}
