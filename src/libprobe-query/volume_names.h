/* SPDX-License-Identifier: Apache-2.0 */
/* volume_names: what the parts of libprobe-query call each other by, once they are in the library.
 *
 * A static library has no private names but those of one file: a program that links it and has a
 * volume_finish of its own would clash. The library's objects are compiled with `-include
 * volume_names.h` (Makefile.am), so that all they show begins with probe_; the objects that the
 * programs link keep the plain names. tests/libprobe-query.t looks, so a function that is new in
 * one of these files and not here is noticed.
 */
#ifndef VOLUME_NAMES_H
#define VOLUME_NAMES_H

#define discs_blend probe_private_discs_blend
#define discs_bytes probe_private_discs_bytes
#define discs_cover probe_private_discs_cover
#define discs_covers probe_private_discs_covers
#define discs_destroy probe_private_discs_destroy
#define discs_draw probe_private_discs_draw
#define discs_fetch probe_private_discs_fetch
#define discs_grid_of probe_private_discs_grid_of
#define discs_list probe_private_discs_list
#define discs_make probe_private_discs_make
#define discs_make_again probe_private_discs_make_again
#define discs_nearest probe_private_discs_nearest

#define lattice_fit probe_private_lattice_fit
#define lattice_orient probe_private_lattice_orient
#define lattice_snap probe_private_lattice_snap

#define sh_basis probe_private_sh_basis
#define sh_basis_wave probe_private_sh_basis_wave
#define sh_cosine probe_private_sh_cosine
#define sh_dominant probe_private_sh_dominant
#define sh_irradiance probe_private_sh_irradiance
#define sh_order_of probe_private_sh_order_of
#define sh_project probe_private_sh_project
#define sh_radiance probe_private_sh_radiance
#define sh_scale_bands probe_private_sh_scale_bands

#define span_axes probe_private_span_axes
#define span_find probe_private_span_find
#define span_flatten probe_private_span_flatten

#define surface_discs probe_private_surface_discs

#define volume_beyond_of probe_private_volume_beyond_of
#define volume_block probe_private_volume_block
#define volume_block_bytes probe_private_volume_block_bytes
#define volume_check_sight probe_private_volume_check_sight
#define volume_coordinates probe_private_volume_coordinates
#define volume_facet_corner probe_private_volume_facet_corner
#define volume_facet_vertex probe_private_volume_facet_vertex
#define volume_finish probe_private_volume_finish
#define volume_make_ready probe_private_volume_make_ready
#define volume_measure probe_private_volume_measure
#define volume_morton probe_private_volume_morton
#define volume_outer probe_private_volume_outer
#define volume_outer_init probe_private_volume_outer_init
#define volume_outer_ray probe_private_volume_outer_ray
#define volume_see probe_private_volume_see
#define volume_see_outside probe_private_volume_see_outside
#define volume_sort probe_private_volume_sort
#define volume_tetra_end probe_private_volume_tetra_end
#define volume_tetra_make probe_private_volume_tetra_make
#define volume_tree_add probe_private_volume_tree_add
#define volume_tree_clear probe_private_volume_tree_clear
#define volume_tree_finish probe_private_volume_tree_finish
#define volume_tree_init probe_private_volume_tree_init
#define volume_tree_near probe_private_volume_tree_near
#define volume_tree_put probe_private_volume_tree_put
#define volume_tree_search probe_private_volume_tree_search
#define volume_zeros probe_private_volume_zeros

#endif
