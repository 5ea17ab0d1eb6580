/* SPDX-License-Identifier: Apache-2.0 */
/* A capture that finds its own order. */
#include "base/error.h"
#include "capture/capture.h"
#include "light/order.h"
#include "stream/stream.h"

struct error *capture_least_order(struct capture_job *job, struct table *table, double loss,
                                  int *order, double *lost)
{
    const struct capture_settings *settings = job->settings;
    struct capture_settings first = *settings;
    struct capture_job first_job = *job;
    struct dering_count count;
    first_job.settings = &first;
    first_job.slice = NULL;
    first.dering.target = DERING_NONE; /* fewer bands ring otherwise */
    first.columns |= CAPTURE_ERROR;
    struct error *err = capture_add_columns(&first, table);
    if (!err)
        err = capture_rows(&first_job, table, 0, table->rows);
    job->captured = first_job.captured;
    job->left = first_job.left;
    if (!err && !job->left)
        err = order_least(table, settings->convolved, loss, order, lost);
    if (!err && !job->left)
        err = order_reduce(table, *order);
    if (!err && !(settings->columns & CAPTURE_ERROR))
        table_remove_column(table, "sh_error");
    if (!err && settings->dering.target != DERING_NONE)
        err = dering_table(table, &settings->dering, settings->convolved, job->threads, &count);
    return err;
}
