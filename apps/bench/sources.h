// Where input images and ground truth come from: analytic scenes, computed on the device, and frames from files.
#pragma once

#include "apps/bench/raw_file.h"
#include "apps/bench/rig.h"
#include "scene/scene.h"
#include "sfumato/frame.h"
#include "sfumato/parameters.h"

#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace sfumato::bench {

// An image that a scene can give, in the format that a renderer would keep it in.
struct PlaneInfo {
    const char* name;
    VkFormat format;
    uint32_t components;
    Image scene::SceneImages::*member;
    VkFormat compact = VK_FORMAT_UNDEFINED; // what frames are timed with, where that is another one
};

std::span<const PlaneInfo> planes();
const PlaneInfo* find_plane(std::string_view name);

// One frame on the device.
struct Inputs {
    Extent extent;
    Frame frame;
    bool is_compact = false;
    std::map<std::string, apps::HostImage, std::less<>> images; // by plane

    const apps::HostImage* find(std::string_view plane) const;
};

struct LoadRequest {
    Extent extent;
    int frame_offset = 0; // from the frame that shows the scene best
    std::vector<std::string> planes;
    scene::RenderOptions options; // samples, and what the truth is asked for
    // In the formats of a renderer that saves bandwidth; else in those of files, so that errors are the effect's own.
    bool is_compact = false;
    // A source of one frame alone gives a sequence in which nothing moves.
    bool holds_still = false;
};

class Source {
  public:
    virtual ~Source() = default;
    virtual std::string name() const = 0;
    virtual bool has(std::string_view plane) const = 0;
    // Whether the effect is measured on it: on any scene that was named, else on scenes made for the effect; on files
    // if the effect was named, else on those that hold its truth and the camera that it may need.
    virtual bool suits(std::string_view effect) const = 0;
    // The only extent that has a truth, if the source has one of its own.
    virtual std::optional<Extent> native_extent() const = 0;
    // How many frames there are before the one that shows the scene best.
    virtual int earlier_frames() const = 0;
    // Whether the truth can be had for any shutter and number of sub-frames.
    virtual bool is_analytic() const = 0;
    // Why the truth `plane` cannot be had as asked for, "" if it can.
    virtual std::string why_no_truth(std::string_view plane, const scene::RenderOptions& options) const = 0;
    // Planes that the source lacks are left out.
    virtual Result<Inputs> load(Rig& rig, const LoadRequest& request) const = 0;
};

using Sources = std::vector<std::unique_ptr<Source>>;

// The named scenes (none named: all; one named "none": none), then the files. Errors: a name or a file.
Result<Sources> open_sources(const std::vector<std::string>& scenes, const std::vector<std::string>& raw_files,
                             bool is_effect_named);

} // namespace sfumato::bench
