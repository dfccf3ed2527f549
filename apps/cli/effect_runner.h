// A chain of effects on one device: owns their instances and outputs, and records them one after the other.
#pragma once

#include "apps/cli/effect_chain.h"
#include "apps/cli/shortfalls.h"
#include "apps/common/device.h"

#include <map>
#include <memory>
#include <string>
#include <vector>

namespace sfumato::cli {

// Of the scene's depth from the sun, for effects with a role `shadow_map`.
inline constexpr uint32_t sun_map_side = 1024;

// Inputs by role; the colour output of an effect is the colour of the next.
using RoleImages = std::map<std::string, Image>;

struct ExtraOutput {
    const apps::HostImage* image = nullptr;
    const ImageRole* role = nullptr; // tells how many of the image's channels mean something, and their sign
};

// The buffers in which the effects of one frame in flight tell what its result lacks; see BufferRole::shortfalls.
struct FrameReport {
    struct Entry {
        size_t stage = 0; // place of the effect in the chain
        const BufferRole* role = nullptr;
        apps::HostBuffer buffer;
    };
    std::vector<Entry> entries;
};

class EffectRunner {
  public:
    // `frames_in_flight` as ContextInfo has it. Errors are the device's.
    static Result<std::unique_ptr<EffectRunner>> create(apps::Device& device, const EffectChain& chain,
                                                        uint32_t frames_in_flight);
    // In a context of the caller's, which must outlive the runner.
    static Result<std::unique_ptr<EffectRunner>> create(apps::Device& device, Context& context,
                                                        const EffectChain& chain);

    // Makes the outputs for pictures of this size, with nothing in flight. Cheap if they are there already.
    Result<void> prepare(Extent extent);

    // New histories, for frames that do not follow on the last. Nothing may be in flight.
    Result<void> restart();

    // A report for each frame in flight; none of its buffers may be in use when it is recorded into again.
    Result<FrameReport> create_report() const;

    Result<void> record(VkCommandBuffer commands, const Frame& frame, const RoleImages& inputs,
                        const FrameReport& report);

    // Of a frame that has finished.
    std::vector<EffectShortfall> shortfalls(const FrameReport& report) const;

    // The colour after the last effect that makes some to be written; null if there is none.
    const apps::HostImage* colour() const;
    // What effects put out besides colour, by channel name: "AO", "bent_normal".
    std::map<std::string, ExtraOutput> extras() const;

    // Any output that is made, to be written or not; null if there is none of that name.
    const apps::HostImage* output(std::string_view effect, std::string_view role) const;

    // GPU times of the newest finished frame, effect by effect; see Executor::times.
    std::vector<std::pair<const EffectInfo*, PassTime>> times();

    Context& context() { return *context_; }

  private:
    struct Output {
        const ImageRole* role = nullptr;
        bool is_colour = false;
        bool is_written = false;
        apps::HostImage image;
    };
    struct Stage {
        const ChainLink* link = nullptr;
        std::unique_ptr<AnyEffect> effect;
        bool warms_up = false; // on its first frame, which is told to be one
        std::vector<Output> outputs;
    };

    EffectRunner(apps::Device& device, Context& context) : device_(&device), context_(&context) {}

    apps::Device* device_;
    std::unique_ptr<Context> own_context_; // empty if it is the caller's
    Context* context_;
    std::vector<Stage> stages_;
    Extent extent_;
};

// What a result is called in files: "AO", "bent_normal".
std::string channel_name(const EffectInfo& effect, const ImageRole& role);

// The float format with at least that many components: nothing of the files' precision is lost on the device.
VkFormat float_format(uint32_t components);

} // namespace sfumato::cli
