// Scene, effects and their images.
#include "apps/viewer/picture_renderer.h"

#include "apps/cli/exit_code.h"
#include "apps/cli/frame_writer.h"
#include "apps/cli/viewpoint.h"

#include <algorithm>

namespace sfumato::viewer {

using cli::as_device;

namespace {

Result<void> on_device(const Result<void>& done) {
    return done ? Result<void>{} : Result<void>(as_device(done.error()));
}

} // namespace

Result<std::unique_ptr<PictureRenderer>> PictureRenderer::create(apps::Device& device, const SceneOpener& open) {
    ContextInfo info = device.context_info();
    info.frames_in_flight = 1; // every frame is waited for
    info.timestamps = device.timestamps();
    auto context = Context::create(info);
    if (!context)
        return as_device(context.error());
    std::unique_ptr<PictureRenderer> made(new PictureRenderer(device, std::move(*context)));
    auto source = open(device, *made->context_);
    if (!source)
        return source.error();
    made->source_ = std::move(*source);
    return made;
}

PictureRenderer::~PictureRenderer() {
    static_cast<void>(static_cast<bool>(device_.wait_idle()));
}

Result<void> PictureRenderer::make_images(const PictureRequest& request) {
    std::vector<std::pair<std::string, uint32_t>> wanted = {
        {"colour", 4}, {"depth", 1}, {"normal", 4}, {"velocity", 2}, {"next_velocity", 2}};
    for (const std::string& pass : request.passes)
        wanted.emplace_back(pass, pass == "shadow" ? 1 : 4);
    std::map<std::string, apps::HostImage> images;
    for (const auto& [name, components] : wanted) {
        const auto old = images_.find(name);
        if (old != images_.end() && old->second.extent() == request.extent) {
            images[name] = std::move(old->second);
            continue;
        }
        auto image = device_.create_image(cli::float_format(components), request.extent);
        if (!image)
            return as_device(image.error());
        images[name] = std::move(*image);
    }
    images_ = std::move(images);
    if (cli::chain_uses(chain_, "shadow_map") && source_->has_sun_map() && !sun_map_.extent()) {
        auto map = device_.create_image(cli::float_format(1), {cli::sun_map_side, cli::sun_map_side});
        if (!map)
            return as_device(map.error());
        sun_map_ = std::move(*map);
    }
    return {};
}

// Parameters change in place; anything else takes new effects.
Result<void> PictureRenderer::prepare(const PictureRequest& request) {
    const std::string structure = request.structure();
    if (structure == structure_) {
        for (size_t i = 0; i < chain_.size(); ++i)
            chain_[i].parameters = request.chain[i].parameters;
        return {};
    }
    structure_.clear();
    if (auto idle = device_.wait_idle(); !idle)
        return as_device(idle.error());
    runner_.reset();
    chain_ = request.chain;
    if (extent_ != request.extent)
        context_->trim();
    if (auto made = make_images(request); !made)
        return made;
    auto runner = cli::EffectRunner::create(device_, *context_, chain_);
    if (!runner)
        return runner.error();
    auto report = (*runner)->create_report();
    if (!report)
        return report.error();
    runner_ = std::move(*runner);
    report_ = std::move(*report);
    if (auto prepared = runner_->prepare(request.extent); !prepared)
        return prepared;
    extent_ = request.extent;
    structure_ = structure;
    return {};
}

Result<void> PictureRenderer::render(const PictureRequest& request, int frame, uint64_t index) {
    scene::RenderOptions options;
    options.samples = request.samples;
    scene::SceneImages images;
    images.colour = image("colour");
    images.direct = image("direct");
    images.ambient = image("ambient");
    images.depth = image("depth");
    images.normal = image("normal");
    images.velocity = image("velocity");
    images.next_velocity = image("next_velocity");
    images.shadow = image("shadow");
    cli::RoleImages roles;
    for (const auto& [name, one] : images_)
        roles[name] = one.image();
    roles["normals"] = image("normal");
    roles["shadow_map"] = sun_map_.image();
    Frame facts = source_->frame_facts(frame, extent_);
    facts.index = index;
    auto commands = device_.begin();
    if (!commands)
        return as_device(commands.error());
    if (auto recorded = source_->record(*commands, frame, options, images, count_); !recorded)
        return recorded.error();
    if (sun_map_.extent())
        if (auto recorded = source_->record_sun_map(*commands, frame, sun_map_.image(), count_); !recorded)
            return recorded.error();
    ++count_;
    if (auto recorded = runner_->record(*commands, facts, roles, report_); !recorded)
        return recorded.error();
    frame_ = frame;
    return on_device(device_.submit_and_wait());
}

Result<void> PictureRenderer::settle(const PictureRequest& request) {
    if (auto prepared = prepare(request); !prepared)
        return prepared;
    source_->set_camera(request.viewpoint ? cli::standing_at(*request.viewpoint) : scene::CameraPath{});
    if (auto restarted = runner_->restart(); !restarted)
        return restarted;
    for (int frame = std::max(request.frame - request.preroll, 0); frame <= request.frame; ++frame)
        if (auto rendered = render(request, frame, static_cast<uint64_t>(frame)); !rendered)
            return rendered;
    return {};
}

Result<void> PictureRenderer::follow(const PictureRequest& request, const std::optional<scene::View>& previous,
                                     bool cut) {
    const bool anew = cut || request.structure() != structure_;
    if (auto prepared = prepare(request); !prepared)
        return prepared;
    if (anew)
        if (auto restarted = runner_->restart(); !restarted)
            return restarted;
    if (!request.viewpoint)
        source_->set_camera({});
    else if (previous && !anew)
        source_->set_camera(moving_camera(*previous, *request.viewpoint, request.frame));
    else
        source_->set_camera(cli::standing_at(*request.viewpoint));
    // A stream whose time stands still goes on all the same; its numbers lie beyond those of any scene's frames.
    const bool time_stands = !anew && request.frame == frame_;
    constexpr uint64_t beyond = uint64_t{1} << 32;
    const uint64_t index = time_stands ? beyond + ++stream_ : static_cast<uint64_t>(request.frame);
    return render(request, request.frame, index);
}

Image PictureRenderer::image(const char* name) const {
    const auto found = images_.find(name);
    return found == images_.end() ? Image{} : found->second.image();
}

const apps::HostImage* PictureRenderer::result() const {
    if (!runner_)
        return nullptr;
    if (const apps::HostImage* colour = runner_->colour())
        return colour;
    // What was made in place of a picture.
    for (const auto& [name, extra] : runner_->extras())
        if (extra.role->components == 1)
            return extra.image;
    return nullptr;
}

const apps::HostImage* PictureRenderer::find(const std::string& id) const {
    if (id == "frozen")
        return frozen_.image() ? &frozen_ : nullptr;
    if (const size_t dot = id.find('.'); dot != std::string::npos)
        return runner_ ? runner_->output(id.substr(0, dot), id.substr(dot + 1)) : nullptr;
    if (id == "result" && result())
        return result();
    const auto found = images_.find(id == "before" || id == "result" ? "colour" : id);
    return found == images_.end() ? nullptr : &found->second;
}

Image PictureRenderer::picture(const std::string& id) const {
    const apps::HostImage* found = find(id);
    return found ? found->image() : Image{};
}

Result<std::vector<float>> PictureRenderer::read(const std::string& id) {
    const apps::HostImage* found = find(id);
    if (!found)
        return std::vector<float>{};
    auto values = device_.readback(*found);
    return values ? std::move(values) : Result<std::vector<float>>(as_device(values.error()));
}

Result<void> PictureRenderer::freeze() {
    const Image shown = picture("result");
    if (!shown)
        return {};
    if (frozen_.extent() != shown.extent || frozen_.format() != shown.format) {
        auto made = device_.create_image(shown.format, shown.extent);
        if (!made)
            return as_device(made.error());
        frozen_ = std::move(*made);
    }
    auto commands = device_.begin();
    if (!commands)
        return as_device(commands.error());
    VkMemoryBarrier barrier{VK_STRUCTURE_TYPE_MEMORY_BARRIER};
    barrier.srcAccessMask = VK_ACCESS_MEMORY_WRITE_BIT;
    barrier.dstAccessMask = VK_ACCESS_MEMORY_READ_BIT | VK_ACCESS_MEMORY_WRITE_BIT;
    const auto wait = [&] {
        device_.functions().CmdPipelineBarrier(*commands, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT,
                                               VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, 0, 1, &barrier, 0, nullptr, 0,
                                               nullptr);
    };
    VkImageCopy copy{};
    copy.srcSubresource = copy.dstSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
    copy.extent = {shown.extent.width, shown.extent.height, 1};
    wait();
    device_.functions().CmdCopyImage(*commands, shown.handle, VK_IMAGE_LAYOUT_GENERAL, frozen_.image().handle,
                                     VK_IMAGE_LAYOUT_GENERAL, 1, &copy);
    wait();
    return on_device(device_.submit_and_wait());
}

std::vector<NamedTime> PictureRenderer::times() {
    std::vector<NamedTime> result;
    for (const PassTime& time : source_->times())
        result.push_back({"scene", time.pass, time.milliseconds});
    if (runner_)
        for (const auto& [effect, time] : runner_->times())
            result.push_back({effect->name, time.pass, time.milliseconds});
    return result;
}

std::vector<cli::EffectShortfall> PictureRenderer::shortfalls() const {
    return runner_ ? runner_->shortfalls(report_) : std::vector<cli::EffectShortfall>{};
}

Result<void> PictureRenderer::read_pass(cli::RenderedFrame& frame, const std::string& name,
                                        const apps::HostImage& image) {
    auto values = device_.readback(image);
    if (!values)
        return as_device(values.error());
    const auto components = static_cast<uint32_t>(values->size() / (size_t{extent_.width} * extent_.height));
    frame.passes[name] = {components, std::move(*values)};
    return {};
}

Result<cli::RenderedFrame> PictureRenderer::read_back() {
    if (!runner_)
        return Error{ErrorCode::invalid_argument, "nothing has been rendered yet"};
    const scene::SceneInfo& info = source_->info();
    cli::RenderedFrame frame{extent_, frame_, info.frames_per_second, source_->camera(frame_, extent_), {}};
    const apps::HostImage* colour = runner_->colour();
    for (const auto& [name, one] : images_)
        if (auto read = read_pass(frame, name == "colour" && colour ? "sharp" : name, one); !read)
            return read.error();
    if (colour)
        if (auto read = read_pass(frame, "colour", *colour); !read)
            return read.error();
    for (const auto& [name, extra] : runner_->extras()) {
        if (auto read = read_pass(frame, name, *extra.image); !read)
            return read.error();
        for (uint32_t c = 0; c < extra.role->components; ++c)
            frame.passes[name].channels.push_back(cli::extra_channel(name, *extra.role, c));
    }
    return frame;
}

} // namespace sfumato::viewer
