/* SPDX-License-Identifier: Apache-2.0 */
#include "bake/figures.h"
#include "base/error.h"
#include "base/file.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

struct error *figures_read(struct report *report, const char *path)
{
    char *text, *rest = NULL;
    size_t size;
    struct error *err = error_wrap(file_read(path, &text, &size), "%s", path);
    for (char *line = err ? NULL : strtok_r(text, "\n", &rest); line && !err;
         line = strtok_r(NULL, "\n", &rest)) {
        char measure[32], of[32] = "";
        struct estimate e = {(double)NAN, (double)NAN, (double)NAN};
        if (sscanf(line, "%31s %31s %lf %lf %lf", measure, of, &e.value, &e.low, &e.high) == 5)
            err = report_add(report, measure, of, e);
        else if (sscanf(line, "%31s %lf", measure, &e.value) == 2)
            err = report_add_number(report, measure, "", e.value);
    }
    if (text)
        free(text);
    return err;
}
