// One frame from its file to what effects take: pictures by role, and the facts of the frame.
#pragma once

#include "apps/cli/camera_source.h"
#include "apps/cli/console.h"
#include "apps/cli/conventions.h"
#include "apps/cli/effect_chain.h"
#include "apps/cli/frame_list.h"
#include "sfumato/image.h"

#include <map>
#include <optional>
#include <string>
#include <vector>

namespace sfumato::cli {

// Interleaved values, row after row from the top.
struct RolePicture {
    Extent extent;
    uint32_t components = 0;
    std::vector<float> values;
};

struct LoadedFrame {
    FrameJob job;
    media::ExrImage image;
    media::ChannelGroup colour; // where in `image` the result goes
    std::map<std::string, RolePicture> roles;
    Frame facts;
    Extent extent; // of the part that the result goes to
};

// Channels that bear the name of a role: "exclusion_mask", "layer_1.X" and "layer_1.Y", "View.layer_1.R" and so on.
media::ChannelGroup named_group(const media::ExrImage& image, std::string_view role);

struct LoaderOptions {
    ConventionOptions conventions;
    std::string camera;
    int threads = 1; // for decoding
};

// Used by one thread at a time.
class FrameLoader {
  public:
    static Result<FrameLoader> create(const EffectChain& chain, const LoaderOptions& options, Console& console);

    // Reads one frame. The first that can be read settles the conventions for all, and says so through the console.
    Result<LoadedFrame> load(const FrameJob& job);

    const std::optional<media::MotionConvention>& motion() const { return motion_; }
    const std::optional<media::DepthConvention>& depth() const { return depth_; }
    const std::optional<media::NormalConvention>& normals() const { return normals_; }

  private:
    FrameLoader(const EffectChain& chain, const LoaderOptions& options, Console& console, CameraSource cameras)
        : chain_(&chain), options_(options), console_(&console), cameras_(std::move(cameras)) {}

    bool needs(std::string_view role) const;
    Result<void> settle(const LoadedFrame& frame, const media::ChannelSelection& channels);
    Result<void> settle_normals_of(const LoadedFrame& frame, const media::ChannelSelection& channels,
                                   Findings& findings);
    void tell(Findings& findings) const;
    Result<void> place_result(LoadedFrame& frame, const media::ChannelSelection& channels) const;
    Result<void> check_camera(const LoadedFrame& frame) const;
    Result<void> decode(LoadedFrame& frame, const media::ChannelSelection& channels);
    Result<void> add_depth(LoadedFrame& frame, const media::ChannelSelection& channels);
    Result<void> add_motion(LoadedFrame& frame, const media::ChannelSelection& channels);
    void add_others(LoadedFrame& frame, const media::ChannelSelection& channels);
    Result<void> check_complete(const LoadedFrame& frame) const;

    const EffectChain* chain_;
    LoaderOptions options_;
    Console* console_;
    CameraSource cameras_;
    bool settled_ = false;
    std::optional<media::MotionConvention> motion_;
    std::optional<media::DepthConvention> depth_;
    std::optional<media::NormalConvention> normals_;
};

} // namespace sfumato::cli
