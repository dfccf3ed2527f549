// Binds an effect's image roles to inputs and to outputs of its own.
#pragma once

#include "apps/bench/adapters.h"
#include "apps/bench/sources.h"
#include "sfumato/effect.h"

#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace sfumato::bench {

// The planes that the effect's roles want, without doubles.
std::vector<std::string> wanted_planes(const EffectInfo& effect, const std::vector<std::string>& opted_in);

// The images struct of one frame, with the outputs that it owns.
class BoundImages {
  public:
    // Errors: an input that the effect must have and the source lacks, no memory.
    static Result<BoundImages> create(Rig& rig, const EffectInfo& effect, const Inputs& inputs,
                                      const std::vector<std::string>& opted_in);

    const void* data() const { return storage_.data(); }
    const apps::HostImage& output() const { return outputs_.front(); }

  private:
    // Bytes, not std::max_align_t: padding is not zeroed reliably.
    struct alignas(std::max_align_t) Unit {
        std::byte bytes[sizeof(std::max_align_t)] = {};
    };

    std::vector<Unit> storage_;
    std::vector<apps::HostImage> outputs_;
};

struct SequenceFrame {
    Frame facts;
    const BoundImages* images;
};

// Runs the effect on the frames in turn on a new instance, and waits.
Result<void> run_sequence(Rig& rig, Context& context, const EffectInfo& effect, const void* parameters,
                          std::span<const SequenceFrame> frames);

} // namespace sfumato::bench
