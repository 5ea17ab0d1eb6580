/* SPDX-License-Identifier: Apache-2.0 */
/* compress: stores what the probes of a stream get of groups, skies and suns, as a few numbers a
 * probe (pca.h, compressed.h).
 */
#ifndef COMPRESS_H
#define COMPRESS_H

#include <stddef.h>
#include <stdio.h>

struct error;
struct stream;

/* Replaces the parts' columns of a stream; their errors go. Light (sh, irradiance) stays. Probes
 * without light stay so. Errors: a stream without parts, or one that is compressed; more vectors
 * and clusters than probes, or numbers of a probe, give. */
struct error *compress_stream(struct stream *stream, size_t vectors, size_t clusters, int threads);

/* Writes a table of what 1, 2, 4 ... vectors lose: a line of names, then one each, cells separated
 * by tabs: vectors, clusters, bytes of all; RMS of what is lost, as a share of that of what there
 * is, of all parts together and of each column. */
struct error *compress_table(const struct stream *stream, size_t clusters, FILE *to, int threads);

#endif
