// Parameters in TOML: a table for each effect, `preset` and parameters as keys.
#include "apps/cli/effect_chain.h"
#include "apps/cli/exit_code.h"
#include "media/file_io.h"

#include <fmt/format.h>
#include <toml++/toml.h>

namespace sfumato::cli {

namespace {

constexpr uint64_t max_config_bytes = uint64_t{1} << 20;

Error at(const std::filesystem::path& path, const toml::source_region& source, const std::string& what) {
    return input_error(fmt::format("{}:{}: {}", path.string(), source.begin.line, what));
}

std::string value_text(const toml::node& node) {
    if (const auto* text = node.as_string())
        return text->get();
    if (const auto* flag = node.as_boolean())
        return flag->get() ? "true" : "false";
    if (const auto* whole = node.as_integer())
        return fmt::format("{}", whole->get());
    if (const auto* real = node.as_floating_point())
        return fmt::format("{}", real->get());
    return {};
}

Result<void> read_preset(ChainLink& link, const toml::table& table, const std::filesystem::path& path) {
    const toml::node* node = table.get("preset");
    if (!node)
        return {};
    if (!node->is_string())
        return at(path, node->source(), fmt::format("{}.preset must be text", link.effect->name));
    const std::string preset = value_text(*node);
    if (auto applied = apply_preset(*link.effect->parameters, link.parameters.data(), preset); !applied)
        return at(path, node->source(), applied.error().message);
    link.preset = preset;
    return {};
}

// A preset is a base: wherever it stands in the table, the single values go on top.
Result<void> read_effect(ChainLink& link, const toml::table& table, const std::filesystem::path& path) {
    if (auto read = read_preset(link, table, path); !read)
        return read;
    for (const auto& [key, node] : table) {
        if (key.str() == "preset")
            continue;
        if (node.is_table() || node.is_array())
            return at(path, key.source(), fmt::format("{}.{} must be one value", link.effect->name, key.str()));
        if (auto set = set_parameter(*link.effect->parameters, link.parameters.data(), key.str(), value_text(node));
            !set)
            return at(path, key.source(), set.error().message);
    }
    return {};
}

Result<void> read_root(EffectChain& chain, const toml::table& root, const std::filesystem::path& path) {
    for (const auto& [key, node] : root) {
        const std::string name(key.str());
        if (!find_effect(name))
            return at(path, key.source(), unknown_effect(name).message);
        if (!node.is_table())
            return at(path, key.source(), fmt::format("'{}' must be a table: [{}]", name, name));
        // Settings for effects of other runs may stand in the same file, but must be right.
        ChainLink other{find_effect(name), "", ParameterSet(*find_effect(name)->parameters)};
        ChainLink* link = &other;
        for (ChainLink& candidate : chain)
            if (candidate.effect == other.effect)
                link = &candidate;
        if (auto read = read_effect(*link, *node.as_table(), path); !read)
            return read;
    }
    return {};
}

std::string toml_value(const ParameterInfo& info, const void* parameters) {
    const std::string text = parameter_text(info, parameters);
    if (info.kind == ParameterKind::choice)
        return '"' + text + '"';
    // TOML tells 1 from 1.0; both read back to the same, but a person sees the kind.
    if (info.kind == ParameterKind::real && text.find_first_of(".en") == std::string::npos)
        return text + ".0";
    return text;
}

} // namespace

Result<void> load_config(EffectChain& chain, const std::filesystem::path& path) {
    auto text = media::read_whole_file(path, max_config_bytes);
    if (!text)
        return text.error();
    try {
        const toml::table root = toml::parse(std::string_view(text->data(), text->size()), path.string());
        return read_root(chain, root, path);
    } catch (const toml::parse_error& error) {
        return at(path, error.source(), std::string(error.description()));
    }
}

Result<void> save_config(const EffectChain& chain, const std::filesystem::path& path, bool no_clobber) {
    std::string text = "# Effective parameters; sfumato apply … --config reads them back.\n";
    for (const ChainLink& link : chain) {
        text += fmt::format("\n[{}]\n", link.effect->name);
        if (!link.preset.empty())
            text += fmt::format("# began as preset {}\n", link.preset);
        for (const ParameterInfo& info : link.effect->parameters->parameters)
            text += fmt::format("{} = {}{}\n", info.name, toml_value(info, link.parameters.data()),
                                *info.unit ? fmt::format(" # {}", info.unit) : "");
    }
    auto file = media::AtomicFile::create(path, {no_clobber, true});
    if (!file)
        return file.error();
    file->write(text.data(), text.size());
    return file->commit();
}

} // namespace sfumato::cli
