/* An alarm lamp that blinks, from a packed file with the light of each group of lights: what a game
 * does when its lamps change.
 *
 *     probe-query --pack half --groups -o baked.pack baked.probe
 *     cc example_groups.c $(pkg-config --cflags --libs libprobe-query)
 *     ./a.out baked.pack alarm 1 1 2
 * SPDX-License-Identifier: Apache-2.0 */
#include <probe-query.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

int main(int argc, char **argv)
{
    FILE *in = argc == 6 ? fopen(argv[1], "rb") : NULL;
    if (!in) {
        fprintf(stderr, "usage: example_groups PACKED GROUP X Y Z\n");
        return 2;
    }
    fseek(in, 0, SEEK_END);
    const size_t size = (size_t)ftell(in);
    void *file = malloc(size + 1);
    rewind(in);
    struct probe_volume *volume;
    if (!file || fread(file, 1, size, in) != size ||
        probe_volume_open(&volume, file, size, 0, NULL)) {
        fprintf(stderr, "%s: not a packed file\n", argv[1]);
        return 1;
    }
    const struct probe_image_facts facts = probe_volume_image(volume);
    const size_t width = 3 * (size_t)facts.order * (size_t)facts.order,
                 groups = probe_volume_groups(volume);
    float *lit = malloc(probe_volume_probes(volume) * width * sizeof *lit + 1), weight[3 * 64];
    size_t alarm = 0;
    while (alarm < groups && strcmp(probe_volume_group_name(volume, alarm), argv[2]))
        alarm++;
    if (alarm == groups || groups > 64 || !lit)
        return 1;
    for (size_t i = 0; i < 3 * groups; i++)
        weight[i] = i / 3 == alarm ? 0 : 0.25f; /* all other lamps burn low */
    struct probe_place place = {.cell = PROBE_COLD};
    const double p[3] = {atof(argv[3]), atof(argv[4]), atof(argv[5])};
    for (int frame = 0; frame < 4; frame++) {
        const float up[3] = {0, 1, 0};
        float sh[108], rgb[3];
        weight[3 * alarm] = frame % 2 ? 2.f : 0; /* red, on and off */
        if (probe_volume_relight(volume, weight, lit) || probe_volume_locate(volume, p, &place))
            return 1;
        probe_blend(&place, lit, width, sh);
        (facts.convolved ? probe_irradiance_convolved : probe_irradiance)(facts.order, sh, up, rgb);
        printf("%.9g %.9g %.9g\n", (double)rgb[0], (double)rgb[1], (double)rgb[2]);
    }
    probe_volume_destroy(volume);
    free(lit);
    free(file);
    fclose(in);
    return 0;
}
