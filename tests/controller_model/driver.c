/* Evaluate poses from standard input by the flat interface; results go to standard output. All numbers are doubles in the machine's own order. */
#include "lm_flat.h"

#include <stdio.h>

int main(void)
{
    double in[2 * LM_JOINTS + 17];
    double out[LM_FLAT_PREDICTION + LM_FLAT_COMMAND];
    while (fread(in, sizeof(double), 2 * LM_JOINTS + 17, stdin) == 2 * LM_JOINTS + 17) {
        const double *load = in + LM_JOINTS;
        const double *gravity = load + 10;
        const double *side = gravity + 3;
        const double *options = side + LM_JOINTS;
        lm_flat_predict(in, load, gravity, side, out);
        lm_flat_compensate(in, load, gravity, side, options, out + LM_FLAT_PREDICTION);
        if (fwrite(out, sizeof(double), LM_FLAT_PREDICTION + LM_FLAT_COMMAND, stdout) != LM_FLAT_PREDICTION + LM_FLAT_COMMAND) {
            return 1;
        }
    }
    return lm_self_test();
}
