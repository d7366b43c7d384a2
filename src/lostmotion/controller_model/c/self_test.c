/* Run the stored poses and print the result. */
#include "lm_core.h"

#include <stdio.h>

int main(void)
{
    const int failed = lm_self_test();
    (void)printf("%d of %d poses differ from the stored results; lm_input %lu, lm_output %lu, lm_command %lu bytes\n", failed, LM_VECTORS,
                 (unsigned long)sizeof(lm_input), (unsigned long)sizeof(lm_output), (unsigned long)sizeof(lm_command));
    return (failed == 0) ? 0 : 1;
}
