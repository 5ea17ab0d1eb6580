/* The light of surfaces at points of theirs, from a packed file of surface probes.
 *
 *     probe-query --interpolate discs --pack half -o surface.pack captured.probe
 *     cc example_surface.c $(pkg-config --cflags --libs libprobe-query)
 *     echo 1 0 2  0 1 0 | ./a.out surface.pack
 * SPDX-License-Identifier: Apache-2.0 */
#include <probe-query.h>

#include <fcntl.h>
#include <stdio.h>
#include <sys/mman.h>
#include <sys/stat.h>

int main(int argc, char **argv)
{
    if (argc != 2) {
        fprintf(stderr, "usage: example_surface PACKED, and points: X Y Z NX NY NZ\n");
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
    struct probe_surface *surface;
    const enum probe_status bad = probe_surface_open(&surface, file, (size_t)status.st_size, NULL);
    if (bad) {
        fprintf(stderr, "%s: %s\n", argv[1], probe_status_text(bad));
        return 1;
    }
    double p[3];
    float normal[3], rgb[3]; /* the normal's length is 1 */
    while (scanf("%lf %lf %lf %f %f %f", p, p + 1, p + 2, normal, normal + 1, normal + 2) == 6) {
        int covered;
        if (probe_surface_irradiance(surface, p, normal, 1, rgb, &covered))
            return 1;
        printf("%.9g %.9g %.9g%s\n", (double)rgb[0], (double)rgb[1], (double)rgb[2],
               covered ? "" : "  by the nearest disc");
    }
    probe_surface_destroy(surface);
    munmap(file, (size_t)status.st_size);
    return 0;
}
