// A driver that fails on demand: it stands between the library and the real one, counts what is alive, and makes the
// n-th call that may fail, or every call of one function, return an error.
#pragma once

#include "sfumato/context.h"

#include <map>
#include <set>
#include <string>

namespace sfumato::test {

struct FailingDriver {
    // Settings.
    int fail_at = -1;        // this fallible call fails, counted from 0
    std::string fail_always; // every call of this function fails
    VkResult result = VK_ERROR_OUT_OF_DEVICE_MEMORY;
    std::set<std::string> hidden; // functions that the driver says it does not have

    // What happened.
    int calls = 0; // fallible ones
    int failed = 0;
    std::string last_failed;
    std::map<std::string, int> alive; // by what creates it: created minus destroyed

    int total_alive() const;
    // Puts it between a context and its device. One at a time: Vulkan's functions carry no user data.
    void install(ContextInfo& info);
};

} // namespace sfumato::test
