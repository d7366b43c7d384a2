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
    model->options.passes = 1;
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

static void *lm_fmi_at(lm_instance *model, unsigned int reference, lm_kind kind)
{
    if (model == 0 || reference >= LM_VARIABLES || lm_variables[reference].kind != kind) {
        return 0;
    }
    return (char *)model + lm_variables[reference].at;
}

static int lm_fmi_get_reals(lm_instance *model, const unsigned int references[], size_t count, double values[])
{
    size_t k;
    for (k = 0; k < count; k++) {
        const lm_real *at = lm_fmi_at(model, references[k], LM_REAL);
        if (at == 0) {
            return LM_FMI_ERROR;
        }
        if (!lm_variables[references[k]].settable) {
            lm_fmi_evaluate(model);
        }
        values[k] = *at;
    }
    return LM_FMI_OK;
}

static int lm_fmi_set_reals(lm_instance *model, const unsigned int references[], size_t count, const double values[])
{
    size_t k;
    for (k = 0; k < count; k++) {
        lm_real *at = lm_fmi_at(model, references[k], LM_REAL);
        if (at == 0 || !lm_variables[references[k]].settable) {
            return LM_FMI_ERROR;
        }
        *at = values[k];
        model->fresh = 0;
    }
    return LM_FMI_OK;
}

static int lm_fmi_get_integers(lm_instance *model, const unsigned int references[], size_t count, int values[])
{
    size_t k;
    for (k = 0; k < count; k++) {
        const int *at = lm_fmi_at(model, references[k], LM_INTEGER);
        if (at == 0) {
            return LM_FMI_ERROR;
        }
        if (!lm_variables[references[k]].settable) {
            lm_fmi_evaluate(model);
        }
        values[k] = *at;
    }
    return LM_FMI_OK;
}

static int lm_fmi_set_integers(lm_instance *model, const unsigned int references[], size_t count, const int values[])
{
    size_t k;
    for (k = 0; k < count; k++) {
        int *at = lm_fmi_at(model, references[k], LM_INTEGER);
        if (at == 0 || !lm_variables[references[k]].settable) {
            return LM_FMI_ERROR;
        }
        *at = values[k];
        model->fresh = 0;
    }
    return LM_FMI_OK;
}
#endif
