/* SPDX-License-Identifier: Apache-2.0 */
/* memory: how much of it the machine has. */
#ifndef MEMORY_H
#define MEMORY_H

/* Bytes of main memory; infinity where the system does not tell. */
double memory_bytes(void);

#endif
