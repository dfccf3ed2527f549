// Input images from analytic scenes and from files.
#include "apps/bench/sources.h"

#include "apps/bench/adapters.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>

#include <fmt/format.h>

namespace sfumato::bench {
namespace {

constexpr PlaneInfo plane_list[] = {
    {"colour", VK_FORMAT_R16G16B16A16_SFLOAT, 4, &scene::SceneImages::colour},
    {"direct", VK_FORMAT_R16G16B16A16_SFLOAT, 4, &scene::SceneImages::direct},
    {"ambient", VK_FORMAT_R16G16B16A16_SFLOAT, 4, &scene::SceneImages::ambient},
    {"depth", VK_FORMAT_R32_SFLOAT, 1, &scene::SceneImages::depth},
    {"normal", VK_FORMAT_R16G16B16A16_SFLOAT, 4, &scene::SceneImages::normal, VK_FORMAT_R8G8B8A8_SNORM},
    {"velocity", VK_FORMAT_R16G16_SFLOAT, 2, &scene::SceneImages::velocity},
    {"next_velocity", VK_FORMAT_R16G16_SFLOAT, 2, &scene::SceneImages::next_velocity},
    {"shadow", VK_FORMAT_R16_SFLOAT, 1, &scene::SceneImages::shadow},
    {"truth", VK_FORMAT_R32G32B32A32_SFLOAT, 4, &scene::SceneImages::truth},
    {"true_visibility", VK_FORMAT_R32_SFLOAT, 1, &scene::SceneImages::true_visibility},
    {"true_bent_normal", VK_FORMAT_R32G32B32A32_SFLOAT, 4, &scene::SceneImages::true_bent_normal},
};

VkFormat format_of(const PlaneInfo& plane, const LoadRequest& request) {
    return request.is_compact && plane.compact != VK_FORMAT_UNDEFINED ? plane.compact : plane.format;
}

class SceneSource : public Source {
  public:
    SceneSource(const scene::Scene& scene, bool is_named) : scene_(scene), is_named_(is_named) {}

    std::string name() const override { return scene_.info.name; }
    bool has(std::string_view plane) const override { return find_plane(plane) != nullptr; }
    bool suits(std::string_view effect) const override { return is_named_ || scene::is_for(scene_.info, effect); }
    std::optional<Extent> native_extent() const override { return std::nullopt; }
    int earlier_frames() const override { return scene_.info.key_frame; }
    bool is_analytic() const override { return true; }
    std::string why_no_truth(std::string_view, const scene::RenderOptions&) const override { return ""; }

    Result<Inputs> load(Rig& rig, const LoadRequest& request) const override {
        const int number = std::clamp(scene_.info.key_frame + request.frame_offset, 0, scene_.info.frames - 1);
        Inputs inputs;
        inputs.extent = request.extent;
        inputs.is_compact = request.is_compact;
        inputs.frame = scene::frame_facts(scene_, number, request.extent);
        scene::SceneImages images;
        for (const PlaneInfo& plane : plane_list) {
            if (std::ranges::find(request.planes, plane.name) == request.planes.end())
                continue;
            auto image = rig.device().create_image(format_of(plane, request), request.extent);
            if (!image)
                return image.error();
            images.*plane.member = image->image();
            inputs.images.emplace(plane.name, std::move(*image));
        }
        if (auto rendered = rig.render(scene_, number, request.options, images); !rendered)
            return rendered.error();
        return inputs;
    }

  private:
    const scene::Scene& scene_;
    bool is_named_;
};

class RawSource : public Source {
  public:
    RawSource(RawFrame frame, bool is_for_named)
        : frame_(std::move(frame)), is_for_named_(is_for_named),
          name_(std::filesystem::path(frame_.path).stem().string()) {}

    std::string name() const override { return name_; }
    bool has(std::string_view plane) const override { return frame_.find(plane) != nullptr && find_plane(plane); }
    bool suits(std::string_view effect) const override {
        const EffectInfo* info = is_for_named_ ? nullptr : find_effect(effect);
        const char* truth = info ? adapter_of(*info).truth : nullptr;
        return info == nullptr || (!(info->needs_camera && !camera("")) && (truth == nullptr || has(truth)));
    }
    std::optional<Extent> native_extent() const override { return frame_.find("colour")->extent; }
    int earlier_frames() const override { return std::numeric_limits<int>::max(); }
    bool is_analytic() const override { return false; }

    std::string why_no_truth(std::string_view plane, const scene::RenderOptions& options) const override {
        const RawImage* radius = frame_.find("truth_radius");
        if (plane != "true_visibility")
            return "";
        if (options.occlusion.falloff != scene::Falloff::hard)
            return name_ + " has its truth for a hard falloff alone";
        if (radius != nullptr &&
            std::abs(double{radius->values[0]} - options.occlusion.radius) > 1e-5 * options.occlusion.radius)
            return fmt::format("{} has its truth for a radius of {:g} alone, not of {:g}", name_, radius->values[0],
                               options.occlusion.radius);
        return "";
    }

    // There is one frame only: an offset gives a copy of it.
    Result<Inputs> load(Rig& rig, const LoadRequest& request) const override {
        Inputs inputs;
        inputs.extent = request.extent;
        inputs.is_compact = request.is_compact;
        inputs.frame.time_step = 1.0f / 24.0f;
        inputs.frame.camera = camera("");
        inputs.frame.previous_camera = request.holds_still ? inputs.frame.camera : camera("previous_");
        inputs.frame.index = static_cast<uint64_t>(still_index + request.frame_offset);
        for (const std::string& name : request.planes) {
            const RawImage* raw = frame_.find(name);
            const PlaneInfo* plane = find_plane(name);
            if (raw == nullptr || plane == nullptr)
                continue;
            auto image = rig.device().create_image(format_of(*plane, request), request.extent);
            if (!image)
                return image.error();
            const bool stays_zero = name == "velocity" && request.holds_still; // as images are made
            if (!stays_zero)
                if (auto uploaded = upload(rig, *raw, *image); !uploaded)
                    return uploaded.error();
            inputs.images.emplace(name, std::move(*image));
        }
        return inputs;
    }

  private:
    // Column by column, as the file has them row by row.
    static Matrix4 matrix_of(const RawImage& image) {
        Matrix4 matrix;
        for (size_t i = 0; i < 16; ++i)
            matrix[i] = image.values[i % 4 * 4 + i / 4];
        return matrix;
    }

    std::optional<Camera> camera(const std::string& prefix) const {
        const RawImage* view = frame_.find(prefix + "world_to_view");
        const RawImage* projection = frame_.find(prefix + "projection");
        if (view == nullptr || projection == nullptr)
            return std::nullopt;
        Camera camera;
        camera.world_to_view = matrix_of(*view);
        camera.projection = matrix_of(*projection);
        return camera;
    }

    static constexpr int still_index = 1000; // of the frame; those before it count down

    static Result<void> upload(Rig& rig, const RawImage& raw, const apps::HostImage& image) {
        if (raw.extent == image.extent())
            return rig.device().upload(image, raw.values, raw.channels);
        std::vector<float> factors;
        if (raw.name == "velocity" || raw.name == "next_velocity")
            factors = {static_cast<float>(image.extent().width) / static_cast<float>(raw.extent.width),
                       static_cast<float>(image.extent().height) / static_cast<float>(raw.extent.height)};
        return rig.device().upload(image, resized_nearest(raw, image.extent(), factors).values, raw.channels);
    }

    RawFrame frame_;
    bool is_for_named_;
    std::string name_;
};

Error unknown_scene(const std::string& name) {
    std::vector<std::string> names;
    std::string list;
    for (const scene::Scene& known : scene::scenes()) {
        names.push_back(known.info.name);
        list += (list.empty() ? "" : ", ") + known.info.name;
    }
    const std::string near = nearest_name(name, names);
    return {ErrorCode::invalid_argument, "there is no scene '" + name + "'" +
                                             (near.empty() ? "; there are " + list : "; did you mean '" + near + "'?")};
}

} // namespace

std::span<const PlaneInfo> planes() {
    return plane_list;
}

const PlaneInfo* find_plane(std::string_view name) {
    const auto* found = std::ranges::find_if(plane_list, [&](const PlaneInfo& plane) { return plane.name == name; });
    return found == std::end(plane_list) ? nullptr : found;
}

const apps::HostImage* Inputs::find(std::string_view plane) const {
    const auto found = images.find(plane);
    return found == images.end() ? nullptr : &found->second;
}

Result<Sources> open_sources(const std::vector<std::string>& scenes, const std::vector<std::string>& raw_files,
                             bool is_effect_named) {
    Sources sources;
    if (scenes.empty())
        for (const scene::Scene& scene : scene::scenes())
            sources.push_back(std::make_unique<SceneSource>(scene, false));
    for (const std::string& name : scenes) {
        if (name == "none")
            continue;
        const scene::Scene* scene = scene::find_scene(name);
        if (scene == nullptr)
            return unknown_scene(name);
        sources.push_back(std::make_unique<SceneSource>(*scene, true));
    }
    for (const std::string& path : raw_files) {
        auto frame = read_raw_frame(path);
        if (!frame)
            return frame.error();
        sources.push_back(std::make_unique<RawSource>(std::move(*frame), is_effect_named));
    }
    if (sources.empty())
        return Error{ErrorCode::invalid_argument, "there is neither a scene nor a file to measure with"};
    return sources;
}

} // namespace sfumato::bench
