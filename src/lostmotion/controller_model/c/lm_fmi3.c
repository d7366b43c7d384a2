/* The model as an FMU for co-simulation, FMI 3.0. Functions that a model without states does not need return an error. */
#include <stdbool.h>
#include <stdint.h>

#include "lm_fmi.h"

LM_EXPORT const char *fmi3GetVersion(void)
{
    return "3.0";
}

LM_EXPORT void *fmi3InstantiateCoSimulation(const char *name, const char *token, const char *resources, bool visible, bool logging, bool events,
                                            bool early_return, const uint32_t intermediate[], size_t count, void *environment, void (*log)(void),
                                            void (*update)(void))
{
    (void)name;
    (void)resources;
    (void)visible;
    (void)logging;
    (void)events;
    (void)early_return;
    (void)intermediate;
    (void)count;
    (void)environment;
    (void)log;
    (void)update;
    return lm_fmi_new(token);
}

LM_EXPORT void *fmi3InstantiateModelExchange(const char *name)
{
    (void)name;
    return 0;
}

LM_EXPORT void *fmi3InstantiateScheduledExecution(const char *name)
{
    (void)name;
    return 0;
}

LM_EXPORT void fmi3FreeInstance(void *instance)
{
    free(instance);
}

LM_EXPORT int fmi3SetDebugLogging(void *instance, bool on, size_t count, const char *const categories[])
{
    (void)instance;
    (void)on;
    (void)count;
    (void)categories;
    return LM_FMI_OK;
}

LM_EXPORT int fmi3EnterInitializationMode(void *instance, bool has_tolerance, double tolerance, double start, bool has_stop, double stop)
{
    (void)has_tolerance;
    (void)tolerance;
    (void)has_stop;
    (void)stop;
    ((lm_instance *)instance)->time = start;
    return LM_FMI_OK;
}

LM_EXPORT int fmi3Reset(void *instance)
{
    lm_fmi_reset(instance);
    return LM_FMI_OK;
}

LM_EXPORT int fmi3GetFloat64(void *instance, const uint32_t references[], size_t count, double values[], size_t length)
{
    return length == count ? lm_fmi_get_reals(instance, references, count, values) : LM_FMI_ERROR;
}

LM_EXPORT int fmi3SetFloat64(void *instance, const uint32_t references[], size_t count, const double values[], size_t length)
{
    return length == count ? lm_fmi_set_reals(instance, references, count, values) : LM_FMI_ERROR;
}

LM_EXPORT int fmi3GetInt32(void *instance, const uint32_t references[], size_t count, int32_t values[], size_t length)
{
    return length == count ? lm_fmi_get_integers(instance, references, count, values) : LM_FMI_ERROR;
}

LM_EXPORT int fmi3SetInt32(void *instance, const uint32_t references[], size_t count, const int32_t values[], size_t length)
{
    return length == count ? lm_fmi_set_integers(instance, references, count, values) : LM_FMI_ERROR;
}

LM_EXPORT int fmi3DoStep(void *instance, double time, double step, bool no_state_before, bool *event, bool *terminate, bool *early, double *last)
{
    (void)no_state_before;
    *event = false;
    *terminate = false;
    *early = false;
    *last = time + step;
    return lm_fmi_step(instance, time + step);
}

LM_ACCEPTED(fmi3ExitInitializationMode)
LM_ACCEPTED(fmi3Terminate)

LM_REFUSED(fmi3EnterEventMode)
LM_REFUSED(fmi3GetFloat32)
LM_REFUSED(fmi3GetInt8)
LM_REFUSED(fmi3GetUInt8)
LM_REFUSED(fmi3GetInt16)
LM_REFUSED(fmi3GetUInt16)
LM_REFUSED(fmi3GetUInt32)
LM_REFUSED(fmi3GetInt64)
LM_REFUSED(fmi3GetUInt64)
LM_REFUSED(fmi3GetBoolean)
LM_REFUSED(fmi3GetString)
LM_REFUSED(fmi3GetBinary)
LM_REFUSED(fmi3GetClock)
LM_REFUSED(fmi3SetFloat32)
LM_REFUSED(fmi3SetInt8)
LM_REFUSED(fmi3SetUInt8)
LM_REFUSED(fmi3SetInt16)
LM_REFUSED(fmi3SetUInt16)
LM_REFUSED(fmi3SetUInt32)
LM_REFUSED(fmi3SetInt64)
LM_REFUSED(fmi3SetUInt64)
LM_REFUSED(fmi3SetBoolean)
LM_REFUSED(fmi3SetString)
LM_REFUSED(fmi3SetBinary)
LM_REFUSED(fmi3SetClock)
LM_REFUSED(fmi3GetNumberOfVariableDependencies)
LM_REFUSED(fmi3GetVariableDependencies)
LM_REFUSED(fmi3GetFMUState)
LM_REFUSED(fmi3SetFMUState)
LM_REFUSED(fmi3FreeFMUState)
LM_REFUSED(fmi3SerializedFMUStateSize)
LM_REFUSED(fmi3SerializeFMUState)
LM_REFUSED(fmi3DeserializeFMUState)
LM_REFUSED(fmi3GetDirectionalDerivative)
LM_REFUSED(fmi3GetAdjointDerivative)
LM_REFUSED(fmi3EnterConfigurationMode)
LM_REFUSED(fmi3ExitConfigurationMode)
LM_REFUSED(fmi3GetIntervalDecimal)
LM_REFUSED(fmi3GetIntervalFraction)
LM_REFUSED(fmi3GetShiftDecimal)
LM_REFUSED(fmi3GetShiftFraction)
LM_REFUSED(fmi3SetIntervalDecimal)
LM_REFUSED(fmi3SetIntervalFraction)
LM_REFUSED(fmi3SetShiftDecimal)
LM_REFUSED(fmi3SetShiftFraction)
LM_REFUSED(fmi3EvaluateDiscreteStates)
LM_REFUSED(fmi3UpdateDiscreteStates)
LM_REFUSED(fmi3EnterContinuousTimeMode)
LM_REFUSED(fmi3CompletedIntegratorStep)
LM_REFUSED(fmi3SetTime)
LM_REFUSED(fmi3SetContinuousStates)
LM_REFUSED(fmi3GetContinuousStateDerivatives)
LM_REFUSED(fmi3GetEventIndicators)
LM_REFUSED(fmi3GetContinuousStates)
LM_REFUSED(fmi3GetNominalsOfContinuousStates)
LM_REFUSED(fmi3GetNumberOfEventIndicators)
LM_REFUSED(fmi3GetNumberOfContinuousStates)
LM_REFUSED(fmi3EnterStepMode)
LM_REFUSED(fmi3GetOutputDerivatives)
LM_REFUSED(fmi3ActivateModelPartition)
