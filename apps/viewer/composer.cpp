// The pass that fills the canvas.
#include "apps/viewer/composer.h"

#include "apps/viewer/compose_shared.h"
#include "shaders/compose.h"

#include <array>
#include <cmath>

namespace sfumato::viewer {

namespace {

constexpr float divider_half_width = 1.5f;

static_assert(static_cast<uint32_t>(PictureKind::colour) == PICTURE_COLOUR &&
              static_cast<uint32_t>(PictureKind::grey) == PICTURE_GREY &&
              static_cast<uint32_t>(PictureKind::depth) == PICTURE_DEPTH &&
              static_cast<uint32_t>(PictureKind::normal) == PICTURE_NORMAL &&
              static_cast<uint32_t>(PictureKind::velocity) == PICTURE_VELOCITY &&
              static_cast<uint32_t>(PictureKind::difference) == PICTURE_DIFFERENCE &&
              static_cast<uint32_t>(PictureKind::grey_difference) == PICTURE_GREY_DIFFERENCE);

} // namespace

Result<std::unique_ptr<Composer>> Composer::create(Context& context) {
    auto executor = Executor::create(context);
    if (!executor)
        return executor.error();
    return std::unique_ptr<Composer>(new Composer(std::move(*executor)));
}

Result<void> Composer::record(VkCommandBuffer commands, const Composition& composition, const Image& canvas) {
    const std::array<Image, 5> images = {composition.left.image, composition.right.image, composition.compared,
                                         composition.truth, canvas};
    Planner planner("viewer");
    shared::ComposeConstants constants{};
    const Rectangle& area = composition.area;
    constants.area = {area.x, area.y, std::max(area.width, 1e-3f), std::max(area.height, 1e-3f)};
    constants.surroundings = {0.09f, 0.09f, 0.10f, 1.0f};
    constants.divider = composition.divider;
    constants.divider_width = divider_half_width;
    constants.exposure = static_cast<float>(std::exp2(composition.exposure));
    constants.gain = static_cast<float>(composition.gain);
    constants.near_depth = static_cast<float>(composition.near_depth);
    constants.left_kind = static_cast<uint32_t>(composition.left.kind);
    constants.right_kind = static_cast<uint32_t>(composition.right.kind);
    std::vector<Access> accesses;
    for (uint32_t i = 0; i < 4; ++i)
        accesses.push_back({images[i] ? planner.host("picture", i, images[i]) : no_resource, AccessKind::fetch});
    const ResourceId target = planner.host("canvas", 4, canvas);
    accesses.push_back({target, AccessKind::write});
    Pass& pass = planner.pass("compose", shaders::compose::compose);
    pass.accesses = std::move(accesses);
    pass.constants = constants_of(constants);
    pass.dispatch.target = target;
    return executor_->execute(commands, std::move(planner).finish(), images, ++count_);
}

} // namespace sfumato::viewer
