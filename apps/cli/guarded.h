// Exceptions of the standard library and of those beneath us end here, as errors.
#pragma once

#include "sfumato/result.h"

#include <exception>
#include <new>

namespace sfumato::cli {

// Runs `work`, which returns a Result, and makes an Error of what it throws.
template <class Work>
auto guarded(Work&& work) -> decltype(work()) {
    try {
        return work();
    } catch (const std::bad_alloc&) {
        return Error{ErrorCode::out_of_memory, "out of memory"};
    } catch (const std::exception& exception) {
        return Error{ErrorCode::internal, exception.what()};
    }
}

} // namespace sfumato::cli
