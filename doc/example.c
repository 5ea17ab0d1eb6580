/* The light along a line, from a packed file: what a game does each frame for what moves.
 *
 *     probe-query --pack half -o baked.pack baked.probe
 *     cc example.c $(pkg-config --cflags --libs libprobe-query) && ./a.out baked.pack 0 1 0  10 1 0
 * SPDX-License-Identifier: Apache-2.0 */
#include <probe-query.h>

#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/mman.h>
#include <sys/stat.h>

int main(int argc, char **argv)
{
    if (argc != 8) {
        fprintf(stderr, "usage: example PACKED X Y Z X Y Z\n");
        return 2;
    }
    struct stat status;
    const int fd = open(argv[1], O_RDONLY);
    void *file = fd >= 0 && !fstat(fd, &status)
                     ? mmap(NULL, (size_t)status.st_size, PROT_READ, MAP_PRIVATE, fd, 0)
                     : MAP_FAILED;
    if (file == MAP_FAILED) {
        perror(argv[1]);
        return 1;
    }
    struct probe_volume *volume;
    const enum probe_status bad = probe_volume_open(&volume, file, (size_t)status.st_size, 0, NULL);
    if (bad) {
        fprintf(stderr, "%s: %s\n", argv[1], probe_status_text(bad));
        return 1;
    }
    const struct probe_image_facts facts = probe_volume_image(volume);
    printf("%zu probes of order %d, %zu cells\n", probe_volume_probes(volume), facts.order,
           probe_volume_cells(volume));

    const int frames = 10;
    struct probe_place place = {.cell = PROBE_COLD};
    for (int frame = 0; frame <= frames; frame++) {
        const float up[3] = {0, 1, 0};
        float sh[108], rgb[3];
        double p[3];
        for (int k = 0; k < 3; k++) {
            const double from = atof(argv[2 + k]), to = atof(argv[5 + k]);
            p[k] = from + (to - from) * frame / frames;
        }
        if (probe_volume_locate(volume, p, &place))
            return 1;
        probe_volume_light(volume, &place, sh);
        (facts.convolved ? probe_irradiance_convolved : probe_irradiance)(facts.order, sh, up, rgb);
        printf("%g %g %g  %s  %.9g %.9g %.9g\n", p[0], p[1], p[2],
               place.inside ? "inside" : "outside", (double)rgb[0], (double)rgb[1], (double)rgb[2]);
    }
    probe_volume_destroy(volume);
    munmap(file, (size_t)status.st_size);
    return 0;
}
