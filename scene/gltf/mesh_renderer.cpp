// A frame: the model is posed, its shadow map drawn, and the images. Colours are means over a grid of samples in each
// pixel, drawn one after the other with the image shifted by parts of a pixel.
#include "scene/gltf/mesh_renderer.h"

#include "scene/scene_constants.h"
#include "scene/scene_request.h"
#include "scene/vec3.h"
#include "shaders/analytic_scene.h"
#include "shaders/mesh_images.h"

#include <algorithm>
#include <cstring>
#include <deque>

namespace sfumato::scene {
namespace {
namespace code = sfumato::shaders::mesh_images;
namespace shared_code = sfumato::shaders::analytic_scene;

constexpr uint32_t shadow_side = 2048;
constexpr size_t light_means = 4, all_means = 6;
constexpr float solid = 0.5f; // opacity from which blended surfaces have a depth and a shadow

struct GatherConstants {
    shared::SceneConstants scene;
    shared::MeshSample place;
};

// A plan with the images that it takes.
struct ImagePlan {
    Planner planner{"scene"};
    std::vector<Image> images;

    ResourceId host(const char* name, const Image& image) {
        images.push_back(image);
        return planner.host(name, static_cast<uint32_t>(images.size() - 1), image);
    }
    // The host's image, or one that is written and forgotten.
    ResourceId target(const char* name, const Image& image, VkFormat otherwise, Extent extent) {
        return image ? host(name, image) : planner.transient(name, otherwise, extent);
    }
    Result<void> execute(Executor& executor, VkCommandBuffer commands, uint64_t index) {
        const Plan plan = std::move(planner).finish();
        return executor.execute(commands, plan, images, index);
    }
};

shared::mat4 product(const Matrix4& a, const Matrix4& b) {
    shared::mat4 result;
    for (size_t column = 0; column < 4; ++column)
        for (size_t row = 0; row < 4; ++row) {
            double sum = 0.0;
            for (size_t k = 0; k < 4; ++k)
                sum += static_cast<double>(a[k * 4 + row]) * static_cast<double>(b[column * 4 + k]);
            result.elements[column * 4 + row] = static_cast<float>(sum);
        }
    return result;
}

} // namespace

struct MeshRenderer::Recording {
    VkCommandBuffer commands = VK_NULL_HANDLE;
    double frame = 0.0;
    const RenderOptions* options = nullptr;
    const SceneImages* images = nullptr;
    uint64_t index = 0;
    Extent extent;
    MeshArena* arena = nullptr;
    std::deque<Posed> moments = {}; // those that were needed so far
    const Posed* shadows_of = nullptr;
};

MeshRenderer::MeshRenderer(const MeshScene& scene, ModelPose first_pose)
    : scene_(&scene), first_pose_(std::move(first_pose)),
      lights_(scene.model, first_pose_, scene.casters, scene.view.light) {}

Result<std::unique_ptr<MeshRenderer>> MeshRenderer::create(Context& context, const ContextInfo& info,
                                                           VkQueueFlags queue_flags, const MeshScene& scene) {
    if (!(queue_flags & VK_QUEUE_GRAPHICS_BIT))
        return Error{ErrorCode::unsupported, "this device has compute queues only, and models are drawn with graphics; "
                                             "the built-in scenes need none"};
    std::unique_ptr<MeshRenderer> made(new MeshRenderer(scene, scene.pose(0.0)));
    if (auto prepared = made->prepare(context, info); !prepared)
        return prepared.error();
    return made;
}

Result<void> MeshRenderer::prepare(Context& context, const ContextInfo& info) {
    auto executor = Executor::create(context);
    if (!executor)
        return executor.error();
    executor_ = std::move(*executor);
    auto device = MeshDevice::create(info);
    if (!device)
        return device.error();
    device_ = std::move(*device);
    if (!device_->has_features(mesh_depth_format,
                               VK_FORMAT_FEATURE_DEPTH_STENCIL_ATTACHMENT_BIT | VK_FORMAT_FEATURE_SAMPLED_IMAGE_BIT) ||
        !device_->has_features(mesh_target_format,
                               VK_FORMAT_FEATURE_COLOR_ATTACHMENT_BIT | VK_FORMAT_FEATURE_STORAGE_IMAGE_BIT))
        return Error{ErrorCode::unsupported, "this device cannot draw into images of 32-bit floats"};
    auto pipelines = make_mesh_pipelines(*device_, info.pipeline_cache);
    if (!pipelines)
        return pipelines.error();
    pipelines_ = std::move(*pipelines);
    auto shadow_map = make_mesh_target(*device_, pipelines_, MeshPass::shadow, {shadow_side, shadow_side});
    if (!shadow_map)
        return shadow_map.error();
    shadow_map_ = std::move(*shadow_map);
    VkSamplerCreateInfo sampler{VK_STRUCTURE_TYPE_SAMPLER_CREATE_INFO};
    sampler.addressModeU = sampler.addressModeV = sampler.addressModeW = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE;
    const MeshFunctions& vk = device_->functions();
    auto nearest = device_->make(vk.CreateSampler, vk.DestroySampler, sampler, "vkCreateSampler");
    if (!nearest)
        return nearest.error();
    nearest_ = std::move(*nearest);
    auto model = MeshModel::create(*device_, pipelines_, scene_->model, pose_triangles(scene_->model, first_pose_));
    if (!model)
        return model.error();
    model_ = std::move(*model);
    const VkDescriptorImageInfo map{nearest_, shadow_map_.images.back().view,
                                    VK_IMAGE_LAYOUT_DEPTH_STENCIL_READ_ONLY_OPTIMAL};
    for (uint32_t i = 0; i < std::max(info.frames_in_flight, 1u); ++i)
        arenas_.emplace_back(*device_, pipelines_, map);
    return {};
}

// A new index takes the next slot, whose frame has finished: as Executor::execute has it.
MeshArena& MeshRenderer::begin(uint64_t index) {
    if (index != index_ || serial_ == 0) {
        index_ = index;
        ++serial_;
        arenas_[serial_ % arenas_.size()].reset();
    }
    return arenas_[serial_ % arenas_.size()];
}

Result<const MeshRenderer::Posed*> MeshRenderer::posed(Recording& recording, double frame) {
    for (const Posed& known : recording.moments)
        if (scene_->is_still || known.frame == frame)
            return &known;
    const ModelPose pose = scene_->pose(frame);
    const TriangleMesh mesh = pose_triangles(scene_->model, pose);
    auto vertices = recording.arena->take(mesh.positions.size() * sizeof(MeshPosedVertex));
    auto constants = recording.arena->take(sizeof(shared::MeshLights));
    if (!vertices || !constants)
        return vertices ? constants.error() : vertices.error();
    std::vector<MeshPosedVertex> packed(mesh.positions.size());
    for (size_t i = 0; i < packed.size(); ++i) {
        std::ranges::copy(mesh.positions[i], packed[i].position);
        std::ranges::copy(mesh.normals[i], packed[i].normal);
    }
    std::memcpy(vertices->mapped, packed.data(), packed.size() * sizeof(MeshPosedVertex));
    const shared::MeshLights lights = lights_.at(pose, shadow_side);
    std::memcpy(constants->mapped, &lights, sizeof(lights));
    recording.moments.push_back({frame, *vertices, *constants, lights.shadow_from_world, lights.shadow.z != 0.0f});
    return &recording.moments.back();
}

Result<void> MeshRenderer::ensure_target(Recording& recording, MeshPass pass) {
    MeshTarget& target = pass == MeshPass::light ? light_ : geometry_;
    if (target.extent == recording.extent)
        return {};
    auto made = make_mesh_target(*device_, pipelines_, pass, recording.extent);
    if (!made)
        return made.error();
    recording.arena->keep(std::move(target.framebuffer));
    for (MeshImage& image : target.images)
        recording.arena->keep(std::move(image));
    target = std::move(*made);
    return {};
}

Result<void> MeshRenderer::ensure_means(Recording& recording, size_t count) {
    if (!means_.empty() && means_.front().extent != recording.extent) {
        for (MeshImage& image : means_)
            recording.arena->keep(std::move(image));
        means_.clear();
    }
    while (means_.size() < count) {
        auto image = device_->create_image(mesh_target_format, recording.extent, 1,
                                           VK_IMAGE_USAGE_STORAGE_BIT | VK_IMAGE_USAGE_SAMPLED_BIT);
        if (!image)
            return image.error();
        means_.push_back(std::move(*image));
    }
    return {};
}

// What was in these images counts no more, whatever became of the frame before.
void MeshRenderer::clear_layouts(const Recording& recording, std::span<const MeshImage> images) const {
    std::vector<VkImageMemoryBarrier> changes;
    for (const MeshImage& image : images) {
        VkImageMemoryBarrier change{VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER};
        change.srcAccessMask = VK_ACCESS_SHADER_WRITE_BIT;
        change.dstAccessMask = VK_ACCESS_SHADER_READ_BIT | VK_ACCESS_SHADER_WRITE_BIT;
        change.oldLayout = VK_IMAGE_LAYOUT_UNDEFINED;
        change.newLayout = VK_IMAGE_LAYOUT_GENERAL;
        change.srcQueueFamilyIndex = change.dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
        change.image = image.image;
        change.subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1};
        changes.push_back(change);
    }
    device_->functions().CmdPipelineBarrier(recording.commands, VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT,
                                            VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT, 0, 0, nullptr, 0, nullptr,
                                            static_cast<uint32_t>(changes.size()), changes.data());
}

void MeshRenderer::draw(const Recording& recording, MeshPass pass, const MeshTarget& target,
                        const shared::MeshDraw& constants, const std::array<const Posed*, 3>& moments) const {
    const MeshFunctions& vk = device_->functions();
    const VkCommandBuffer commands = recording.commands;
    const Posed& now = *moments[0];
    std::vector<VkClearValue> clear(target.images.size());
    clear.back().depthStencil.depth = pass == MeshPass::shadow ? 1.0f : 0.0f;
    VkRenderPassBeginInfo begin{VK_STRUCTURE_TYPE_RENDER_PASS_BEGIN_INFO};
    begin.renderPass = pipelines_.render_pass(pass);
    begin.framebuffer = target.framebuffer;
    begin.renderArea = {{0, 0}, {target.extent.width, target.extent.height}};
    begin.clearValueCount = static_cast<uint32_t>(clear.size());
    begin.pClearValues = clear.data();
    vk.CmdBeginRenderPass(commands, &begin, VK_SUBPASS_CONTENTS_INLINE);
    vk.CmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, pipelines_.pipeline(pass));
    const VkViewport viewport{0, 0, static_cast<float>(target.extent.width), static_cast<float>(target.extent.height),
                              0, 1};
    vk.CmdSetViewport(commands, 0, 1, &viewport);
    vk.CmdSetScissor(commands, 0, 1, &begin.renderArea);
    vk.CmdPushConstants(commands, pipelines_.layout, VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT, 0,
                        sizeof(constants), &constants);
    if (pass != MeshPass::shadow) {
        const auto offset = static_cast<uint32_t>(now.lights.offset);
        vk.CmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, pipelines_.layout, 0, 1, &now.lights.lights,
                                 1, &offset);
    }
    const VkBuffer buffers[mesh_binding_count] = {model_->vertices(), now.vertices.buffer, moments[1]->vertices.buffer,
                                                  moments[2]->vertices.buffer};
    const VkDeviceSize offsets[mesh_binding_count] = {0, now.vertices.offset, moments[1]->vertices.offset,
                                                      moments[2]->vertices.offset};
    vk.CmdBindVertexBuffers(commands, 0, mesh_binding_count, buffers, offsets);
    vk.CmdBindIndexBuffer(commands, model_->indices(), 0, VK_INDEX_TYPE_UINT32);
    for (const MeshDraw& run : model_->draws()) {
        if (pass == MeshPass::shadow && (run.node == scene_->ground || !now.has_shadow))
            continue;
        const VkDescriptorSet material = model_->material(run.material);
        vk.CmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, pipelines_.layout, 1, 1, &material, 0,
                                 nullptr);
        vk.CmdDrawIndexed(commands, run.count, 1, run.first_index, 0, 0);
    }
    vk.CmdEndRenderPass(commands);
}

void MeshRenderer::draw_shadow(Recording& recording, const Posed& moment) {
    if (recording.shadows_of == &moment)
        return;
    recording.shadows_of = &moment;
    shared::MeshDraw constants{};
    constants.clip_from_world = moment.shadow_from_world;
    constants.cutoff = solid;
    draw(recording, MeshPass::shadow, shadow_map_, constants, {&moment, &moment, &moment});
}

// The camera with the image shifted so that the rasteriser's sample, in the pixel's middle, falls on x, y of the pixel.
// The depth range is the renderer's own: nothing in reach is cut off.
shared::MeshDraw MeshRenderer::draw_constants(const Recording& recording, double frame, double x, double y) const {
    const Scene& scene = scene_->view;
    const Camera seen = camera(scene, frame, recording.extent);
    const View view = view_at(scene, frame);
    const Vec3 forward = normalised(view.forward);
    Matrix4 projection = seen.projection;
    const bool orthographic = projection[15] != 0.0f;
    if (orthographic) {
        const double middle = dot(scene_->casters.centre - view.eye, forward);
        const double last = std::max(middle + scene_->reach, 1e-6);
        const double first = std::max(middle - scene_->reach, 0.0);
        projection[10] = static_cast<float>(1.0 / (last - first)); // z = 1 at `first`, 0 at `last`
        projection[14] = static_cast<float>(last / (last - first));
        projection[12] += static_cast<float>((1.0 - 2.0 * x) / recording.extent.width);
        projection[13] += static_cast<float>((1.0 - 2.0 * y) / recording.extent.height);
    } else {
        projection[10] = 0.0f;
        projection[14] = static_cast<float>(1e-4 * scene_->casters.radius);
        projection[8] -= static_cast<float>((1.0 - 2.0 * x) / recording.extent.width);
        projection[9] -= static_cast<float>((1.0 - 2.0 * y) / recording.extent.height);
    }
    const bool infinite = !orthographic && scene.camera.lens.range == DepthRange::reversed_infinite;
    shared::MeshDraw constants{};
    constants.clip_from_world = product(projection, seen.world_to_view);
    constants.eye = {static_cast<float>(view.eye.x), static_cast<float>(view.eye.y), static_cast<float>(view.eye.z),
                     infinite ? SCENE_SKY_DEPTH : static_cast<float>(scene.camera.lens.far_plane)};
    constants.forward = {static_cast<float>(forward.x), static_cast<float>(forward.y), static_cast<float>(forward.z),
                         orthographic ? 1.0f : 0.0f};
    return constants;
}

Result<void> MeshRenderer::geometry(Recording& recording) {
    if (auto ready = ensure_target(recording, MeshPass::geometry); !ready)
        return ready;
    std::array<const Posed*, 3> moments{};
    for (size_t i = 0; i < 3; ++i) {
        constexpr double steps[] = {0.0, -1.0, 1.0};
        auto moment = posed(recording, recording.frame + steps[i]);
        if (!moment)
            return moment.error();
        moments[i] = *moment;
    }
    draw_shadow(recording, *moments[0]);
    shared::MeshDraw constants = draw_constants(recording, recording.frame, 0.5, 0.5);
    constants.detail = scene_->normals_have_detail ? 1u : 0u;
    constants.cutoff = solid;
    draw(recording, MeshPass::geometry, geometry_, constants, moments);

    ImagePlan plan;
    const SceneImages& images = *recording.images;
    const Extent extent = recording.extent;
    const auto read = [&](const char* name, size_t i) {
        return plan.host(name, geometry_.images[i].in(VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL));
    };
    const ResourceId inputs[] = {read("drawn normal", 0), read("drawn before", 1), read("drawn after", 2)};
    const ResourceId outputs[] = {plan.target("depth", images.depth, VK_FORMAT_R32_SFLOAT, extent),
                                  plan.target("normal", images.normal, VK_FORMAT_R16G16B16A16_SFLOAT, extent),
                                  plan.target("velocity", images.velocity, VK_FORMAT_R16G16_SFLOAT, extent),
                                  plan.target("next velocity", images.next_velocity, VK_FORMAT_R16G16_SFLOAT, extent),
                                  plan.target("shadow", images.shadow, VK_FORMAT_R16_SFLOAT, extent)};
    Pass& pass = plan.planner.pass("mesh geometry", code::geometry);
    for (const ResourceId input : inputs)
        pass.accesses.push_back({input, AccessKind::fetch});
    for (const ResourceId output : outputs)
        pass.accesses.push_back({output, AccessKind::write});
    pass.constants = constants_of(scene_constants(scene_->view, recording.frame, extent, recording.options->samples));
    pass.dispatch.target = outputs[0];
    return plan.execute(*executor_, recording.commands, recording.index);
}

// Light of one moment into means_[result] and means_[result + 1], always by the same passes: the same bits in a sharp
// frame and in its truth.
Result<uint32_t> MeshRenderer::radiance(Recording& recording, double frame) {
    if (auto ready = ensure_target(recording, MeshPass::light); !ready)
        return ready.error();
    auto moment = posed(recording, frame);
    if (!moment)
        return moment.error();
    draw_shadow(recording, **moment);
    const int side = recording.options->samples;
    GatherConstants constants{scene_constants(scene_->view, frame, recording.extent, side), {}};
    uint32_t result = 0;
    for (int i = 0; i < side * side; ++i) {
        const double x = (i % side + 0.5) / side, y = (i / side + 0.5) / side;
        shared::MeshDraw camera = draw_constants(recording, frame, x, y);
        // As sharp as the distance of the samples allows.
        camera.bias = -std::log2(static_cast<float>(side));
        // Each sample shows blended surfaces above another opacity: together they are as transparent as they should be.
        camera.cutoff = static_cast<float>((i + 0.5) / (side * side));
        draw(recording, MeshPass::light, light_, camera, {*moment, *moment, *moment});
        constants.place = {1.0f / static_cast<float>(i + 1), static_cast<float>(x), static_cast<float>(y), 0.0f};
        ImagePlan plan;
        const uint32_t before = result;
        result = i % 2 == 0 ? 0 : 2;
        const auto read = [&](const char* name, size_t target) {
            return plan.host(name, light_.images[target].in(VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL));
        };
        const ResourceId direct_in = read("drawn direct", 0), ambient_in = read("drawn ambient", 1);
        const ResourceId direct_mean = i == 0 ? no_resource : plan.host("direct so far", mean(before));
        const ResourceId ambient_mean = i == 0 ? no_resource : plan.host("ambient so far", mean(before + 1));
        const ResourceId direct = plan.host("direct", mean(result)), ambient = plan.host("ambient", mean(result + 1));
        Pass& pass = plan.planner.pass("gather", code::gather);
        pass.accesses = {{direct_in, AccessKind::fetch},   {ambient_in, AccessKind::fetch},
                         {direct_mean, AccessKind::fetch}, {ambient_mean, AccessKind::fetch},
                         {direct, AccessKind::write},      {ambient, AccessKind::write}};
        pass.constants = constants_of(constants);
        pass.dispatch.target = direct;
        if (auto done = plan.execute(*executor_, recording.commands, recording.index); !done)
            return done.error();
    }
    return result;
}

Result<void> MeshRenderer::sharp(Recording& recording) {
    const auto light = radiance(recording, recording.frame);
    if (!light)
        return light.error();
    ImagePlan plan;
    const SceneImages& images = *recording.images;
    constexpr auto half = VK_FORMAT_R16G16B16A16_SFLOAT;
    const ResourceId direct_in = plan.host("direct mean", mean(*light));
    const ResourceId ambient_in = plan.host("ambient mean", mean(*light + 1));
    const ResourceId colour = plan.target("colour", images.colour, half, recording.extent);
    const ResourceId direct = plan.target("direct", images.direct, half, recording.extent);
    const ResourceId ambient = plan.target("ambient", images.ambient, half, recording.extent);
    Pass& pass = plan.planner.pass("resolve", shared_code::resolve);
    pass.accesses = {{direct_in, AccessKind::fetch},
                     {ambient_in, AccessKind::fetch},
                     {colour, AccessKind::write},
                     {direct, AccessKind::write},
                     {ambient, AccessKind::write}};
    pass.dispatch.target = colour;
    return plan.execute(*executor_, recording.commands, recording.index);
}

Result<void> MeshRenderer::truth(Recording& recording) {
    const std::vector<Moment> moments = shutter_moments(recording.options->shutter, recording.frame);
    for (size_t i = 0; i < moments.size(); ++i) {
        const auto light = radiance(recording, moments[i].frame);
        if (!light)
            return light.error();
        ImagePlan plan;
        const bool is_last = i + 1 == moments.size();
        const auto colour = [&](size_t step) { return mean(static_cast<uint32_t>(light_means + step % 2)); };
        const ResourceId direct = plan.host("direct mean", mean(*light));
        const ResourceId ambient = plan.host("ambient mean", mean(*light + 1));
        const ResourceId before = i == 0 ? no_resource : plan.host("mean so far", colour(i + 1));
        const ResourceId after = is_last ? plan.host("truth", recording.images->truth) : plan.host("mean", colour(i));
        shared::AccumulateConstants constants{};
        constants.share = moments[i].share;
        Pass& pass = plan.planner.pass("accumulate", shared_code::accumulate);
        pass.accesses = {{direct, AccessKind::fetch},
                         {ambient, AccessKind::fetch},
                         {before, AccessKind::fetch},
                         {after, AccessKind::write}};
        pass.constants = constants_of(constants);
        pass.dispatch.target = after;
        if (auto done = plan.execute(*executor_, recording.commands, recording.index); !done)
            return done;
    }
    return {};
}

Result<void> MeshRenderer::record(VkCommandBuffer commands, double frame, const RenderOptions& options,
                                  const SceneImages& images, uint64_t index) {
    const auto extent = common_extent(images);
    if (!extent)
        return extent.error();
    Recording recording{commands, frame, &options, &images, index, *extent, &begin(index)};
    for (MeshBuffer& buffer : model_->record_uploads(commands))
        recording.arena->keep(std::move(buffer));
    const bool wants_light = images.colour || images.direct || images.ambient;
    if (wants_light || images.truth) {
        if (auto ready = ensure_means(recording, images.truth ? all_means : light_means); !ready)
            return ready;
        clear_layouts(recording, means_);
    }
    if (images.depth || images.normal || images.velocity || images.next_velocity || images.shadow)
        if (auto done = geometry(recording); !done)
            return done;
    if (wants_light)
        if (auto done = sharp(recording); !done)
            return done;
    return images.truth ? truth(recording) : Result<void>{};
}

Result<void> MeshRenderer::record_traced(VkCommandBuffer commands, std::span<const std::array<float, 4>> values,
                                         const SceneImages& images, uint64_t index) {
    const auto extent = common_extent(images);
    if (!extent)
        return extent.error();
    if (values.size() != size_t{extent->width} * extent->height)
        return Error{ErrorCode::internal, "traced values that do not fit the images"};
    MeshArena& arena = begin(index);
    auto bytes = arena.take(values.size_bytes());
    if (!bytes)
        return bytes.error();
    std::memcpy(bytes->mapped, values.data(), values.size_bytes());
    auto made = device_->create_image(mesh_target_format, *extent, 1,
                                      VK_IMAGE_USAGE_TRANSFER_DST_BIT | VK_IMAGE_USAGE_SAMPLED_BIT);
    if (!made)
        return made.error();
    const MeshFunctions& vk = device_->functions();
    VkImageMemoryBarrier change{VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER};
    change.dstAccessMask = VK_ACCESS_TRANSFER_WRITE_BIT;
    change.newLayout = VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL;
    change.srcQueueFamilyIndex = change.dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
    change.image = made->image;
    change.subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1};
    vk.CmdPipelineBarrier(commands, VK_PIPELINE_STAGE_TOP_OF_PIPE_BIT, VK_PIPELINE_STAGE_TRANSFER_BIT, 0, 0, nullptr, 0,
                          nullptr, 1, &change);
    VkBufferImageCopy copy{};
    copy.bufferOffset = bytes->offset;
    copy.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
    copy.imageExtent = {extent->width, extent->height, 1};
    vk.CmdCopyBufferToImage(commands, bytes->buffer, made->image, change.newLayout, 1, &copy);
    change.srcAccessMask = VK_ACCESS_TRANSFER_WRITE_BIT;
    change.dstAccessMask = VK_ACCESS_SHADER_READ_BIT;
    change.oldLayout = change.newLayout;
    change.newLayout = VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL;
    vk.CmdPipelineBarrier(commands, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT, 0, 0, nullptr,
                          0, nullptr, 1, &change);
    ImagePlan plan;
    const ResourceId read = plan.host("traced", made->in(change.newLayout));
    const ResourceId visibility = plan.target("true visibility", images.true_visibility, VK_FORMAT_R32_SFLOAT, *extent);
    const ResourceId bent =
        plan.target("true bent normal", images.true_bent_normal, VK_FORMAT_R16G16B16A16_SFLOAT, *extent);
    Pass& pass = plan.planner.pass("values", code::values);
    pass.accesses = {{read, AccessKind::fetch}, {visibility, AccessKind::write}, {bent, AccessKind::write}};
    pass.dispatch.target = visibility;
    auto done = plan.execute(*executor_, commands, index);
    arena.keep(std::move(*made));
    return done;
}

} // namespace sfumato::scene
