// Built-in scenes by name.
#include "apps/viewer/open_scene.h"

#include "apps/cli/effect_chain.h"
#include "apps/cli/exit_code.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace sfumato::viewer {

Result<SceneOpener> choose_scene(const std::string& name) {
    if (const scene::Scene* found = scene::find_scene(name))
        return SceneOpener([found](Context& context) { return scene::make_source(context, *found); });
    std::vector<std::string> names;
    for (const scene::Scene& one : scene::scenes())
        names.push_back(one.info.name);
    const std::string hint = cli::did_you_mean(name, names);
    return cli::usage_error(fmt::format("no scene is called '{}'{}", name,
                                        hint.empty() ? fmt::format("; there are {}", fmt::join(names, ", ")) : hint));
}

} // namespace sfumato::viewer
