/* A capture that finds its own order. */
#include "base/error.h"
#include "capture/capture.h"
#include "light/order.h"
#include "stream/stream.h"

struct error *capture_least_order(const struct path_tracer *path, struct capture_settings *settings,
                                  struct table *table, bool again, double loss, int threads,
                                  struct progress *progress, size_t *captured, size_t *left,
                                  double *lost)
{
    const struct dering_settings dering = settings->dering;
    struct capture_settings first = *settings;
    struct dering_count count;
    first.dering.target = DERING_NONE; /* fewer bands ring otherwise */
    first.columns |= CAPTURE_ERROR;
    struct error *err = capture_add_columns(&first, table);
    if (!err)
        err = capture_rows(path, &first, table, 0, table->rows, again, NULL, threads, progress,
                           captured, left);
    if (!err && !*left)
        err = order_least(table, settings->convolved, loss, &settings->order, lost);
    if (!err && !*left)
        err = order_reduce(table, settings->order);
    if (!err && !(settings->columns & CAPTURE_ERROR))
        table_remove_column(table, "sh_error");
    if (!err && dering.target != DERING_NONE)
        err = dering_table(table, &dering, settings->convolved, threads, &count);
    return err;
}
