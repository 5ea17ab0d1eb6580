/* SPDX-License-Identifier: Apache-2.0 */
#include "base/memory.h"

#include <math.h>
#include <unistd.h>

double memory_bytes(void)
{
    const long pages = sysconf(_SC_PHYS_PAGES), page = sysconf(_SC_PAGESIZE);
    return pages > 0 && page > 0 ? (double)pages * (double)page : (double)INFINITY;
}
