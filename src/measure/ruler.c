/* SPDX-License-Identifier: Apache-2.0 */
#include "measure/ruler.h"
#include "image/display.h"
#include "measure/sphere.h"

#include <math.h>

/* fmax that is no call */
static inline double most(double a, double b)
{
    return a > b ? a : b;
}

double ruler_error(const double *light, const double *truth, const double *variance, double floor)
{
    double square[SPHERE_COUNT];
    for (int d = 0; d < SPHERE_COUNT; d++) {
        const double s = most(light[d], 0), below = most(truth[d], floor), x = s - truth[d];
        square[d] = below > 0 ? (x * x - variance[d]) / (below * below) : s > 0;
        square[d] = -most(-most(square[d], -1), -1);
    }
    const double mean = sphere_mean(square);
    return copysign(sqrt(fabs(mean)), mean);
}

struct error *ruler_white(size_t count, const float *mean, double *white)
{
    double exposure = 1, most = 0;
    for (size_t i = 0; i < count; i++)
        most = fmax(most, (double)mean[i]);
    struct error *err = display_exposure(count, mean, &exposure);
    *white = most > 0 ? 1 / exposure : 0;
    return err;
}
