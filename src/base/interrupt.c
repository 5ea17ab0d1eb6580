/* SPDX-License-Identifier: Apache-2.0 */
#include "base/interrupt.h"
#include "base/error.h"

#include <signal.h>
#include <stddef.h>

static volatile sig_atomic_t came;

static void take_signal(int number)
{
    if (came) { /* delivered when this returns: until then it is held back */
        signal(number, SIG_DFL);
        raise(number);
    }
    came = 1;
}

void interrupt_catch(void)
{
    static const int numbers[] = {SIGINT, SIGTERM};
    struct sigaction action = {.sa_handler = take_signal, .sa_flags = SA_RESTART};
    sigemptyset(&action.sa_mask);
    for (size_t i = 0; i < sizeof numbers / sizeof *numbers; i++) {
        struct sigaction before;
        if (!sigaction(numbers[i], NULL, &before) && before.sa_handler != SIG_IGN)
            sigaction(numbers[i], &action, NULL);
    }
}

bool interrupt_came(void)
{
    return came;
}

struct error *interrupt_error(void)
{
    return interrupt_came() ? error_new("interrupted") : NULL;
}
