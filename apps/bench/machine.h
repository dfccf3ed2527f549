// What the device itself can do, to judge an effect's times by.
#pragma once

#include "apps/bench/rig.h"

namespace sfumato::bench {

struct Machine {
    double compute_copy = 0.0;  // bytes a second, read and written, by a compute shader
    double transfer_copy = 0.0; // the same by vkCmdCopyImage
    double dispatch_ms = 0.0;   // an empty dispatch with its barrier
    double bandwidth() const { return compute_copy > transfer_copy ? compute_copy : transfer_copy; }
};

Result<Machine> measure_machine(Rig& rig);

} // namespace sfumato::bench
