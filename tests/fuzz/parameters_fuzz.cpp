// Parameter text, the first line the name, the rest the value: what is taken is valid and prints as itself.
#include "sfumato/sfumato.h"

#include <cstdint>
#include <cstdlib>
#include <string>

using namespace sfumato;

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    const std::string_view text(reinterpret_cast<const char*>(data), size);
    const size_t line = text.find('\n');
    const std::string_view name = text.substr(0, line);
    const std::string_view value = line == std::string_view::npos ? std::string_view() : text.substr(line + 1);
    for (const EffectInfo* effect : effects()) {
        const ParameterTable& table = *effect->parameters;
        ParameterSet set(table);
        (void)apply_preset(table, set.data(), value);
        if (!validate_parameters(table, set.data()))
            std::abort();
        if (!set_parameter(table, set.data(), name, value))
            continue;
        if (!validate_parameters(table, set.data()))
            std::abort();
        const ParameterInfo& info = *table.find(name);
        ParameterSet again(table);
        if (!set_parameter(table, again.data(), name, parameter_text(info, set.data())) ||
            info.get(again.data()) != info.get(set.data()))
            std::abort();
    }
    return 0;
}
