/* SPDX-License-Identifier: Apache-2.0 */
/* Light times a function of direction: against the product itself, summed over many directions. */
#include "light/product.h"
#include "math/direction.h"
#include "support/sh_light.h"

static void draw_sh(float *c, int count)
{
    for (int i = 0; i < count; i++)
        c[i] = (float)(2 * draw() - 1);
}

/* How far the product is off its projection by a sum. */
static double off_sum(int order, int of_order)
{
    enum { DIRECTIONS = 20000 };
    float f[3 * SH_COUNT_MAX], g[SH_COUNT_MAX], product[3 * SH_COUNT_MAX];
    double sum[3 * SH_COUNT_MAX] = {0}, worst = 0;
    draw_sh(f, 3 * order * order);
    draw_sh(g, of_order * of_order);
    for (int k = 0; k < DIRECTIONS; k++) {
        const struct vec3 e = direction_even(k, DIRECTIONS);
        const double d[3] = {e.x, e.y, e.z};
        double y[SH_COUNT_MAX], rgb[3], scale = 0;
        sh_radiance(order, f, d, rgb);
        sh_basis(of_order, d, y);
        for (int j = 0; j < of_order * of_order; j++)
            scale += (double)g[j] * y[j];
        sh_basis(order, d, y);
        sh_project(order, y, rgb, 4 * PI / DIRECTIONS * scale, sum);
    }
    product_sh(order, 3, f, of_order, g, product);
    for (int i = 0; i < 3 * order * order; i++)
        worst = fmax(worst, fabs((double)product[i] - sum[i]));
    return worst;
}

int main(void)
{
    double worst = 0, dot = 0;
    for (int order = 1; order <= SH_ORDER_MAX; order++)
        for (int of_order = 1; of_order <= SH_ORDER_MAX; of_order++)
            worst = fmax(worst, off_sum(order, of_order));
    ok(worst < 2e-3, "orders 1 to 6 times 1 to 6: the product's projection: %.1g", worst);
    for (int order = 1; order <= SH_ORDER_MAX; order++) {
        float f[SH_COUNT_MAX], g[SH_COUNT_MAX], product[SH_COUNT_MAX];
        double sum = 0;
        draw_sh(f, order * order);
        draw_sh(g, order * order);
        for (int i = 0; i < order * order; i++)
            sum += (double)f[i] * (double)g[i];
        product_sh(order, 1, f, order, g, product);
        dot = fmax(dot, fabs((double)product[0] / SH_Y00 - sum));
    }
    ok(dot < 1e-5, "its integral is the dot product: %.1g", dot);
    return tap_done();
}
