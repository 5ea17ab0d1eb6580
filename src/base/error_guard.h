/* SPDX-License-Identifier: Apache-2.0 */
/* error_guard: what a function throws, as an error. C++ only: dependencies that throw are behind C
 * faces, and no exception crosses into C.
 */
#ifndef ERROR_GUARD_H
#define ERROR_GUARD_H

extern "C" {
#include "base/error.h"
}

#include <exception>
#include <new>
#include <stdexcept>

/* Runs f, which returns a struct error *, and turns whatever it throws into an error. */
template <class Function> struct error *error_guard(const Function &f) noexcept
{
    try {
        return f();
    } catch (const std::bad_alloc &) {
        return error_memory();
    } catch (const std::length_error &) {
        return error_memory();
    } catch (const std::exception &e) {
        return error_new("%s", e.what());
    } catch (...) {
        return error_new("an unknown exception was thrown");
    }
}

#endif
