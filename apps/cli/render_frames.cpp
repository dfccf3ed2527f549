// Rendering, effects and read-back of a scene's frames.
#include "apps/cli/render_frames.h"

#include "apps/cli/exit_code.h"
#include "apps/cli/frame_writer.h"

#include <algorithm>

namespace sfumato::cli {

namespace {

// The truth opens its shutter as the blur in the chain does.
scene::Shutter shutter_of(const EffectChain& chain, int sub_frames) {
    scene::Shutter shutter;
    shutter.sub_frames = sub_frames;
    for (const ChainLink& link : chain) {
        const ParameterInfo* open = link.effect->parameters->find("shutter");
        const ParameterInfo* position = link.effect->parameters->find("shutter_position");
        if (!open || !position)
            continue;
        shutter.open = open->get(link.parameters.data());
        shutter.position = static_cast<scene::ShutterPosition>(static_cast<int>(position->get(link.parameters.data())));
    }
    return shutter;
}

} // namespace

SceneFrames::~SceneFrames() {
    if (device_)
        static_cast<void>(static_cast<bool>(device_->wait_idle()));
}

Result<void> SceneFrames::open() {
    apps::DeviceOptions device_options;
    device_options.device = request_.device;
    auto device = apps::Device::create(device_options);
    if (!device)
        return as_device(device.error());
    device_ = std::move(*device);
    auto runner = EffectRunner::create(*device_, chain_, 2);
    if (!runner)
        return runner.error();
    runner_ = std::move(*runner);
    if (auto prepared = runner_->prepare(extent_); !prepared)
        return prepared;
    auto report = runner_->create_report();
    if (!report)
        return report.error();
    report_ = std::move(*report);
    auto source = open_scene(scene_, *device_, runner_->context());
    if (!source)
        return source.error().code == ErrorCode::invalid_argument ? source.error() : as_device(source.error());
    source_ = std::move(*source);
    return make_images();
}

Result<RenderedFrame> SceneFrames::render(int number, bool restarts) {
    if (restarts)
        if (auto restarted = runner_->restart(); !restarted)
            return restarted.error();
    auto commands = device_->begin();
    if (!commands)
        return as_device(commands.error());
    scene::RenderOptions render_options;
    render_options.samples = request_.samples;
    render_options.shutter = shutter_of(chain_, std::max(1, request_.truths.sub_frames));
    render_options.occlusion = request_.truths.rays;
    if (auto recorded = source_->record(*commands, number, render_options, scene_images(), count_); !recorded)
        return as_device(recorded.error());
    if (sun_map_.extent())
        if (auto recorded = source_->record_sun_map(*commands, number, sun_map_.image(), count_); !recorded)
            return as_device(recorded.error());
    ++count_;
    if (auto recorded = runner_->record(*commands, source_->frame_facts(number, extent_), role_images(), report_);
        !recorded)
        return as_device(recorded.error());
    if (auto done = device_->submit_and_wait(); !done)
        return as_device(done.error());
    return read_back(number);
}

Result<void> SceneFrames::make_images() {
    std::vector<std::pair<const char*, uint32_t>> wanted = {
        {"colour", 4}, {"depth", 1}, {"normal", 4}, {"velocity", 2}, {"next_velocity", 2}};
    if (request_.all_passes || chain_uses(chain_, "direct"))
        wanted.emplace_back("direct", 4);
    if (request_.all_passes || chain_uses(chain_, "ambient"))
        wanted.emplace_back("ambient", 4);
    if (request_.all_passes || chain_uses(chain_, "shadow"))
        wanted.emplace_back("shadow", 1);
    if (request_.truths.sub_frames > 0)
        wanted.emplace_back("truth", 4);
    if (request_.truths.occlusion)
        wanted.insert(wanted.end(), {{"true_visibility", 1}, {"true_bent_normal", 4}});
    for (const auto& [name, components] : wanted) {
        auto image = device_->create_image(float_format(components), extent_);
        if (!image)
            return as_device(image.error());
        images_[name] = std::move(*image);
    }
    if (chain_uses(chain_, "shadow_map") && source_->has_sun_map()) {
        auto map = device_->create_image(float_format(1), {sun_map_side, sun_map_side});
        if (!map)
            return as_device(map.error());
        sun_map_ = std::move(*map);
    }
    return make_profile();
}

Result<void> SceneFrames::make_profile() {
    const RolePicture& texture = request_.particle_texture;
    if (!texture.extent)
        return {};
    auto image = device_->create_image(float_format(1), texture.extent);
    if (!image)
        return as_device(image.error());
    profile_ = std::move(*image);
    if (auto done = device_->upload(profile_, texture.values, 1); !done)
        return as_device(done.error());
    return {};
}

Image SceneFrames::image(const char* name) const {
    const auto found = images_.find(name);
    return found == images_.end() ? Image{} : found->second.image();
}

scene::SceneImages SceneFrames::scene_images() const {
    return {image("colour"), image("direct"),          image("ambient"),         image("depth"),
            image("normal"), image("velocity"),        image("next_velocity"),   image("shadow"),
            image("truth"),  image("true_visibility"), image("true_bent_normal")};
}

RoleImages SceneFrames::role_images() const {
    RoleImages roles;
    for (const auto& [name, image] : images_)
        roles[name] = image.image();
    roles["normals"] = image("normal");
    roles["shadow_map"] = sun_map_.image();
    roles["profile"] = profile_.image();
    return roles;
}

Result<void> SceneFrames::read_pass(RenderedFrame& frame, const std::string& name, const apps::HostImage& image) {
    auto values = device_->readback(image);
    if (!values)
        return as_device(values.error());
    const auto components = static_cast<uint32_t>(values->size() / (size_t{extent_.width} * extent_.height));
    frame.passes[name] = {components, std::move(*values)};
    return {};
}

Result<RenderedFrame> SceneFrames::read_back(int number) {
    RenderedFrame frame{extent_, number, scene_.info.frames_per_second, source_->camera(number, extent_), {}};
    const apps::HostImage* result = runner_->colour();
    for (const auto& [name, image] : images_) {
        if (name == "colour" && result && !request_.all_passes)
            continue;
        if (auto read = read_pass(frame, name == "colour" && result ? "sharp" : name, image); !read)
            return read.error();
    }
    if (result)
        if (auto read = read_pass(frame, "colour", *result); !read)
            return read.error();
    for (const auto& [name, extra] : runner_->extras()) {
        if (auto read = read_pass(frame, name, *extra.image); !read)
            return read.error();
        RenderedPass& pass = frame.passes[name];
        for (uint32_t c = 0; c < extra.role->components; ++c)
            pass.channels.push_back(extra_channel(name, *extra.role, c));
    }
    return frame;
}

} // namespace sfumato::cli
