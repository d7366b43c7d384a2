/* Time per call of an exported model, and of CasADi's forward kinematics with Jacobian where it is compiled in; best of 200 batches of 300 poses. */
#include "lm_core.h"
#include "lm_tables.h"

#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#define POSES 300
#define BATCHES 200

#ifdef WITH_CASADI
int kinematics(const double **arg, double **res, long long int *iw, double *w, int mem);
#endif

static lm_input inputs[POSES];
static double least[POSES];
static double sink;

static double now(void)
{
    struct timespec time;
    clock_gettime(CLOCK_MONOTONIC, &time);
    return (double)time.tv_sec + 1e-9 * (double)time.tv_nsec;
}

static void call(int what, int pose)
{
    const lm_options options = {1, what == 2, (lm_real)1e-5, (lm_real)0.01};
    lm_output output;
    lm_command command;
    if (what == 0) {
        (void)lm_predict(&inputs[pose], &output);
        sink += (double)output.length95;
    } else if (what < 3) {
        (void)lm_compensate(&inputs[pose], &options, &output, &command);
        sink += (double)command.q[0];
    } else {
#ifdef WITH_CASADI
        double q[LM_JOINTS], pose_out[12], jacobian[6 * LM_JOINTS], w[4096];
        long long int iw[16];
        const double *arg[2] = {q, 0};
        double *res[2] = {pose_out, jacobian};
        int j;
        for (j = 0; j < LM_JOINTS; j++) {
            q[j] = (double)inputs[pose].q[j];
        }
        (void)kinematics(arg, res, iw, w, 0);
        sink += pose_out[0] + jacobian[0];
#endif
    }
}

int main(void)
{
    double best[4] = {1.0, 1.0, 1.0, 1.0};
    double slowest = 0.0, fastest = 1.0;
    int batch, what, pose, j;
    for (pose = 0; pose < POSES; pose++) {
        lm_defaults(&inputs[pose]);
        for (j = 0; j < LM_JOINTS; j++) {
            const double share = (double)rand() / RAND_MAX;
            inputs[pose].q[j] = (lm_real)((double)lm_limits[2 * j] + share * (double)(lm_limits[2 * j + 1] - lm_limits[2 * j]));
        }
    }
    for (batch = 0; batch < BATCHES; batch++) {
        for (what = 0; what < 4; what++) {
            double start = now();
            for (pose = 0; pose < POSES; pose++) {
                call(what, pose);
            }
            start = (now() - start) / POSES;
            best[what] = (start < best[what]) ? start : best[what];
        }
    }
    /* Pose after pose in every batch, so that a busy moment of the machine does not count for one pose alone. */
    for (batch = 0; batch < BATCHES; batch++) {
        for (pose = 0; pose < POSES; pose++) {
            double start = now();
            for (j = 0; j < 20; j++) {
                call(0, pose);
            }
            start = (now() - start) / 20;
            least[pose] = ((batch == 0) || (start < least[pose])) ? start : least[pose];
        }
    }
    for (pose = 0; pose < POSES; pose++) {
        slowest = (least[pose] > slowest) ? least[pose] : slowest;
        fastest = (least[pose] < fastest) ? least[pose] : fastest;
    }
    printf("%.9g %.9g %.9g %.9g %.9g %.9g\n", best[0], best[1], best[2], best[3], slowest / fastest, sink);
    return 0;
}
