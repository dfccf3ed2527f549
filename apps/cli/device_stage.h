// The device's part of the pipeline: several frames in flight, each with its own transfers.
#pragma once

#include "apps/cli/effect_runner.h"
#include "apps/cli/frame_loader.h"

#include <deque>
#include <memory>
#include <optional>

namespace sfumato::cli {

struct ExtraPicture {
    RolePicture picture;
    const ImageRole* role = nullptr;
};

struct ProcessedFrame {
    LoadedFrame frame;
    std::vector<float> colour; // RGBA, interleaved; empty if no effect puts out colour
    std::map<std::string, ExtraPicture> extras;
};

class DeviceStage {
  public:
    static constexpr uint32_t frames_in_flight = 2;

    static Result<std::unique_ptr<DeviceStage>> create(const std::string& device, const EffectChain& chain);
    ~DeviceStage();

    const std::string& device_name() const { return device_->name(); }
    bool is_full() const { return in_flight_.size() == frames_in_flight; }
    bool is_empty() const { return in_flight_.empty(); }

    // Records and submits a frame; must not be full.
    Result<void> submit(LoadedFrame frame);

    // Waits for the oldest frame in flight; must not be empty. No value for pre-roll.
    Result<std::optional<ProcessedFrame>> collect();

    // Of the frames that were collected, pre-roll left out.
    const ShortfallLog& shortfalls() const { return shortfalls_; }

  private:
    struct Slot {
        apps::Commands commands;
        std::map<std::string, apps::HostBuffer> uploads;   // by role
        std::map<std::string, apps::HostBuffer> readbacks; // "" is colour, extras by name
        FrameReport report;
        std::optional<LoadedFrame> frame;
    };

    explicit DeviceStage(std::unique_ptr<apps::Device> device) : device_(std::move(device)) {}
    Result<void> prepare(const LoadedFrame& frame);
    Result<void> record(Slot& slot);
    Result<void> record_uploads(Slot& slot);
    Result<void> record_readbacks(Slot& slot);
    Result<apps::HostBuffer*> buffer(std::map<std::string, apps::HostBuffer>& buffers, const std::string& name,
                                     size_t bytes);

    std::unique_ptr<apps::Device> device_;
    std::unique_ptr<EffectRunner> runner_;
    std::map<std::string, apps::HostImage> inputs_; // shared by all slots: the queue runs one frame after the other
    std::deque<Slot> slots_;
    std::deque<Slot*> in_flight_; // oldest first
    std::deque<Slot*> free_;
    ShortfallLog shortfalls_;
};

} // namespace sfumato::cli
