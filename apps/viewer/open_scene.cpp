// Scenes by name or path, as `sfumato render` finds them.
#include "apps/viewer/open_scene.h"

namespace sfumato::viewer {

Result<ChosenScene> choose_scene(const cli::SceneOptions& options) {
    auto choice = cli::choose_scene(options);
    if (!choice)
        return choice.error();
    const auto kept = std::make_shared<cli::SceneChoice>(std::move(*choice));
    return ChosenScene{
        [kept](const apps::Device& device, Context& context) { return cli::open_scene(*kept, device, context); },
        cli::fit_of(*kept)};
}

} // namespace sfumato::viewer
