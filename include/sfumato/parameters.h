// Parameters, described once: a plain struct with member initialisers, and a constexpr table of pointers to its
// members. Validation, --set, TOML, JSON lists, viewer panels, the tables in the docs, presets and the generic tests
// all read this table.
#pragma once

#include "sfumato/result.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace sfumato {

enum class ParameterKind { real, integer, boolean, choice };

enum ParameterFlags : uint32_t {
    parameter_default = 0,
    parameter_logarithmic = 1, // a slider should be logarithmic
    parameter_advanced = 2,    // for tuning; most users leave it alone
    parameter_debug = 4,       // shows the inside of the effect; not part of a look
};

// One row: everything that anyone needs to know of a parameter. Values pass through double whatever their kind:
// booleans are 0 or 1, choices the index into `choices`.
struct ParameterInfo {
    const char* name;
    const char* unit; // "" where it has none
    const char* doc;  // one sentence
    ParameterKind kind;
    double minimum;
    double maximum;
    std::span<const char* const> choices;
    uint32_t flags;
    double (*get)(const void* parameters);
    void (*set)(void* parameters, double value);
};

struct PresetOverride {
    const char* parameter;
    const char* value; // as text, as in --set
};

struct Preset {
    const char* name;
    const char* doc;
    std::span<const PresetOverride> overrides; // everything else has its default
};

struct ParameterTable {
    const char* effect; // kebab-case
    std::span<const ParameterInfo> parameters;
    std::span<const Preset> presets;
    size_t size;                         // sizeof the struct
    void (*construct)(void* parameters); // default-constructs the struct in place

    const ParameterInfo* find(std::string_view name) const;
    const Preset* find_preset(std::string_view name) const;
};

namespace detail {
template <class T>
struct MemberPointer;
template <class Struct, class Member>
struct MemberPointer<Member Struct::*> {
    using StructType = Struct;
    using MemberType = Member;
};

template <auto member>
double get_member(const void* parameters) {
    using Struct = typename MemberPointer<decltype(member)>::StructType;
    return static_cast<double>(static_cast<const Struct*>(parameters)->*member);
}

template <auto member>
void set_member(void* parameters, double value) {
    using Pointer = MemberPointer<decltype(member)>;
    auto& target = static_cast<typename Pointer::StructType*>(parameters)->*member;
    if constexpr (std::is_same_v<typename Pointer::MemberType, bool>)
        target = value != 0.0;
    else if constexpr (std::is_enum_v<typename Pointer::MemberType>)
        target = static_cast<typename Pointer::MemberType>(static_cast<int>(value));
    else
        target = static_cast<typename Pointer::MemberType>(value);
}
} // namespace detail

// A row for a float or int member, with its inclusive range.
template <auto member>
constexpr ParameterInfo parameter(const char* name, const char* unit, double minimum, double maximum, const char* doc,
                                  uint32_t flags = parameter_default) {
    using Member = typename detail::MemberPointer<decltype(member)>::MemberType;
    static_assert(std::is_same_v<Member, float> || std::is_same_v<Member, int>);
    return {name,
            unit,
            doc,
            std::is_same_v<Member, float> ? ParameterKind::real : ParameterKind::integer,
            minimum,
            maximum,
            {},
            flags,
            &detail::get_member<member>,
            &detail::set_member<member>};
}

// A row for a bool member.
template <auto member>
constexpr ParameterInfo parameter(const char* name, const char* doc, uint32_t flags = parameter_default) {
    static_assert(std::is_same_v<typename detail::MemberPointer<decltype(member)>::MemberType, bool>);
    return {name, "", doc,   ParameterKind::boolean,      0.0,
            1.0,  {}, flags, &detail::get_member<member>, &detail::set_member<member>};
}

// A row for an enum member whose enumerators count from 0 in the order of `choices`.
template <auto member>
constexpr ParameterInfo parameter(const char* name, std::span<const char* const> choices, const char* doc,
                                  uint32_t flags = parameter_default) {
    static_assert(std::is_enum_v<typename detail::MemberPointer<decltype(member)>::MemberType>);
    return {name,
            "",
            doc,
            ParameterKind::choice,
            0.0,
            static_cast<double>(choices.size() - 1),
            choices,
            flags,
            &detail::get_member<member>,
            &detail::set_member<member>};
}

template <class Struct>
constexpr ParameterTable parameter_table(const char* effect, std::span<const ParameterInfo> parameters,
                                         std::span<const Preset> presets) {
    static_assert(std::is_trivially_copyable_v<Struct>);
    return {effect, parameters, presets, sizeof(Struct), [](void* target) { new (target) Struct{}; }};
}

// Sets one parameter from text: a number, true/false, on/off or a choice's name. `parameters` points at the struct that
// `table` describes. Errors: unknown name (with the nearest known one), not a value of its kind, out of range.
Result<void> set_parameter(const ParameterTable& table, void* parameters, std::string_view name, std::string_view text);

// The value as text that set_parameter reads back to the same value.
std::string parameter_text(const ParameterInfo& info, const void* parameters);

// Checks every value of the struct: finite, in range, choices that exist. The error names the first that is not.
Result<void> validate_parameters(const ParameterTable& table, const void* parameters);

// Resets the struct to its defaults, then applies the preset's overrides. "" and "default" give the defaults.
Result<void> apply_preset(const ParameterTable& table, void* parameters, std::string_view preset);

// The parameters of a preset: preset<MotionBlurParameters>("high").
template <class Struct>
Result<Struct> preset(std::string_view name) {
    Struct parameters;
    if (auto applied = apply_preset(Struct::table(), &parameters, name); !applied)
        return applied.error();
    return parameters;
}

// Owns a parameter struct known only by its table: for tools that handle any effect.
class ParameterSet {
  public:
    explicit ParameterSet(const ParameterTable& table);

    const ParameterTable& table() const { return *table_; }
    void* data() { return storage_.data(); }
    const void* data() const { return storage_.data(); }

  private:
    const ParameterTable* table_;
    std::vector<std::max_align_t> storage_;
};

// The candidate nearest to `name` by edit distance, or "" when none is near enough to be meant.
std::string nearest_name(std::string_view name, std::span<const std::string> candidates);

} // namespace sfumato
