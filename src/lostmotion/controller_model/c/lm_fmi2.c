/* The model as an FMU for co-simulation, FMI 2.0. Functions that a model without states does not need return an error. */
#include "lm_fmi.h"

#define LM_CO_SIMULATION 1

LM_EXPORT const char *fmi2GetTypesPlatform(void)
{
    return "default";
}

LM_EXPORT const char *fmi2GetVersion(void)
{
    return "2.0";
}

LM_EXPORT void *fmi2Instantiate(const char *name, int type, const char *token, const char *resources, const void *callbacks, int visible, int logging)
{
    (void)name;
    (void)resources;
    (void)callbacks;
    (void)visible;
    (void)logging;
    return type == LM_CO_SIMULATION ? lm_fmi_new(token) : 0;
}

LM_EXPORT void fmi2FreeInstance(void *instance)
{
    free(instance);
}

LM_EXPORT int fmi2SetDebugLogging(void *instance, int on, size_t count, const char *const categories[])
{
    (void)instance;
    (void)on;
    (void)count;
    (void)categories;
    return LM_FMI_OK;
}

LM_EXPORT int fmi2SetupExperiment(void *instance, int has_tolerance, double tolerance, double start, int has_stop, double stop)
{
    (void)has_tolerance;
    (void)tolerance;
    (void)has_stop;
    (void)stop;
    ((lm_instance *)instance)->time = start;
    return LM_FMI_OK;
}

LM_EXPORT int fmi2Reset(void *instance)
{
    lm_fmi_reset(instance);
    return LM_FMI_OK;
}

LM_EXPORT int fmi2GetReal(void *instance, const unsigned int references[], size_t count, double values[])
{
    return lm_fmi_get_reals(instance, references, count, values);
}

LM_EXPORT int fmi2SetReal(void *instance, const unsigned int references[], size_t count, const double values[])
{
    return lm_fmi_set_reals(instance, references, count, values);
}

LM_EXPORT int fmi2GetInteger(void *instance, const unsigned int references[], size_t count, int values[])
{
    return lm_fmi_get_integers(instance, references, count, values);
}

LM_EXPORT int fmi2SetInteger(void *instance, const unsigned int references[], size_t count, const int values[])
{
    return lm_fmi_set_integers(instance, references, count, values);
}

LM_EXPORT int fmi2DoStep(void *instance, double time, double step, int no_state_before)
{
    (void)no_state_before;
    return lm_fmi_step(instance, time + step);
}

LM_ACCEPTED(fmi2EnterInitializationMode)
LM_ACCEPTED(fmi2ExitInitializationMode)
LM_ACCEPTED(fmi2Terminate)

LM_REFUSED(fmi2GetBoolean)
LM_REFUSED(fmi2SetBoolean)
LM_REFUSED(fmi2GetString)
LM_REFUSED(fmi2SetString)
LM_REFUSED(fmi2GetFMUstate)
LM_REFUSED(fmi2SetFMUstate)
LM_REFUSED(fmi2FreeFMUstate)
LM_REFUSED(fmi2SerializedFMUstateSize)
LM_REFUSED(fmi2SerializeFMUstate)
LM_REFUSED(fmi2DeSerializeFMUstate)
LM_REFUSED(fmi2GetDirectionalDerivative)
LM_REFUSED(fmi2SetRealInputDerivatives)
LM_REFUSED(fmi2GetRealOutputDerivatives)
LM_REFUSED(fmi2CancelStep)
LM_REFUSED(fmi2GetStatus)
LM_REFUSED(fmi2GetRealStatus)
LM_REFUSED(fmi2GetIntegerStatus)
LM_REFUSED(fmi2GetBooleanStatus)
LM_REFUSED(fmi2GetStringStatus)
