/* What both versions of the FMI share: an instance, its variables by number, and their evaluation.
 *
 * The model has no state: its results belong to the inputs that are set now, so they are computed again when one is read after an input has changed.
 */
#ifndef LM_FMI_H
#define LM_FMI_H

#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include "lm_core.h"

#if defined(_WIN32)
#define LM_EXPORT __declspec(dllexport)
#elif defined(__GNUC__)
#define LM_EXPORT __attribute__((visibility("default")))
#else
#define LM_EXPORT
#endif

/* Status of a function, the same numbers in FMI 2 and 3. */
enum { LM_FMI_OK = 0, LM_FMI_WARNING = 1, LM_FMI_ERROR = 3 };

typedef struct {
    double time;
    lm_input input;
    lm_options options;
    lm_output output;
    lm_command command;
    int fresh; /* whether output and command belong to the inputs */
} lm_instance;

typedef enum { LM_REAL, LM_INTEGER } lm_kind;

/* A variable: where it is in the instance, its type, and whether it may be set. */
typedef struct {
    size_t at;
    lm_kind kind;
    int settable;
} lm_variable;

/* Generated: LM_TOKEN, and lm_variables with LM_VARIABLES entries, by value reference. */
#include "lm_variables.h"

static void lm_fmi_reset(lm_instance *model)
{
    memset(model, 0, sizeof *model);
    lm_defaults(&model->input);
    lm_default_options(&model->options);
}

static lm_instance *lm_fmi_new(const char *token)
{
    lm_instance *model = 0;
    if (token != 0 && strcmp(token, LM_TOKEN) == 0) {
        model = malloc(sizeof *model);
    }
    if (model != 0) {
        lm_fmi_reset(model);
    }
    return model;
}

static void lm_fmi_evaluate(lm_instance *model)
{
    if (!model->fresh) {
        (void)lm_compensate(&model->input, &model->options, &model->output, &model->command);
        model->fresh = 1;
    }
}

/* Status of a step: a warning where the model does not answer. */
static int lm_fmi_step(lm_instance *model, double end)
{
    model->time = end;
    lm_fmi_evaluate(model);
    return model->command.status == LM_OK || model->command.status == LM_SINGULAR ? LM_FMI_OK : LM_FMI_WARNING;
}

/* Where a variable of this type is, with results that belong to the inputs; 0 for another number or type. */
static const void *lm_fmi_read(lm_instance *model, unsigned int reference, lm_kind kind)
{
    if (model == 0 || reference >= LM_VARIABLES || lm_variables[reference].kind != kind) {
        return 0;
    }
    if (!lm_variables[reference].settable) {
        lm_fmi_evaluate(model);
    }
    return (const char *)model + lm_variables[reference].at;
}

/* Where a variable of this type is set, after which results are out of date; 0 where it is none that may be set. */
static void *lm_fmi_write(lm_instance *model, unsigned int reference, lm_kind kind)
{
    if (model == 0 || reference >= LM_VARIABLES || lm_variables[reference].kind != kind || !lm_variables[reference].settable) {
        return 0;
    }
    model->fresh = 0;
    return (char *)model + lm_variables[reference].at;
}

static int lm_fmi_get_reals(lm_instance *model, const unsigned int references[], size_t count, double values[])
{
    size_t k;
    for (k = 0; k < count; k++) {
        const lm_real *at = lm_fmi_read(model, references[k], LM_REAL);
        if (at == 0) {
            return LM_FMI_ERROR;
        }
        values[k] = *at;
    }
    return LM_FMI_OK;
}

static int lm_fmi_set_reals(lm_instance *model, const unsigned int references[], size_t count, const double values[])
{
    size_t k;
    for (k = 0; k < count; k++) {
        lm_real *at = lm_fmi_write(model, references[k], LM_REAL);
        if (at == 0) {
            return LM_FMI_ERROR;
        }
        *at = values[k];
    }
    return LM_FMI_OK;
}

static int lm_fmi_get_integers(lm_instance *model, const unsigned int references[], size_t count, int values[])
{
    size_t k;
    for (k = 0; k < count; k++) {
        const int *at = lm_fmi_read(model, references[k], LM_INTEGER);
        if (at == 0) {
            return LM_FMI_ERROR;
        }
        values[k] = *at;
    }
    return LM_FMI_OK;
}

static int lm_fmi_set_integers(lm_instance *model, const unsigned int references[], size_t count, const int values[])
{
    size_t k;
    for (k = 0; k < count; k++) {
        int *at = lm_fmi_write(model, references[k], LM_INTEGER);
        if (at == 0) {
            return LM_FMI_ERROR;
        }
        *at = values[k];
    }
    return LM_FMI_OK;
}

/* Functions that a model without states does not need: those that always succeed, and those that it does not have. */
#define LM_ANSWERED(name, status) \
    LM_EXPORT int name(void *instance) \
    { \
        (void)instance; \
        return status; \
    }
#define LM_ACCEPTED(name) LM_ANSWERED(name, LM_FMI_OK)
#define LM_REFUSED(name) LM_ANSWERED(name, LM_FMI_ERROR)
#endif
