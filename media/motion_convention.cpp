// Names, modifiers and decoding of motion conventions.
#include "motion_convention.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace sfumato::media {

namespace {

struct Row {
    const char* name;
    MotionUnit unit;
    MotionTime time;
    bool encoded;
    bool y_up;
    bool four;
    double scale;
};

// What is documented or measured of each; where a source leaves sign or scale open, detection says so and the warp
// check is there to find out.
constexpr Row rows[] = {
    {"pixels", MotionUnit::pixels, MotionTime::from_previous, false, false, false, 1.0},
    {"ndc", MotionUnit::ndc, MotionTime::from_previous, false, true, false, 1.0},
    {"uv", MotionUnit::uv, MotionTime::from_previous, false, false, false, 1.0},
    {"sfumato", MotionUnit::pixels, MotionTime::from_previous, false, false, true, 1.0},
    {"blender", MotionUnit::pixels, MotionTime::to_previous, false, true, true, 1.0},
    {"unreal", MotionUnit::ndc, MotionTime::from_previous, true, true, false, 1.0},
    // Vectors span the shutter, by default half a frame.
    {"arnold", MotionUnit::pixels, MotionTime::to_next, false, true, false, 2.0},
    // scale= takes the element's maximum velocity.
    {"vray", MotionUnit::pixels, MotionTime::to_next, true, true, false, 1.0},
    {"redshift", MotionUnit::pixels, MotionTime::to_next, false, true, false, 1.0},
    {"renderman", MotionUnit::pixels, MotionTime::to_next, false, false, false, 1.0},
    {"renderman-back", MotionUnit::pixels, MotionTime::to_previous, false, false, false, 1.0},
    {"nuke-forward", MotionUnit::pixels, MotionTime::to_next, false, true, false, 1.0},
    {"nuke-backward", MotionUnit::pixels, MotionTime::to_previous, false, true, false, 1.0},
    {"rsmb", MotionUnit::pixels, MotionTime::to_next, false, true, false, 1.0},
};

constexpr std::pair<std::string_view, MotionTime> times[] = {
    {"from-previous", MotionTime::from_previous},
    {"to-previous", MotionTime::to_previous},
    {"to-next", MotionTime::to_next},
    {"from-next", MotionTime::from_next},
};

constexpr std::pair<std::string_view, MotionUnit> units[] = {
    {"pixels", MotionUnit::pixels}, {"ndc", MotionUnit::ndc}, {"uv", MotionUnit::uv}};

MotionConvention from_row(const Row& row) {
    MotionConvention convention;
    convention.base = row.name;
    convention.unit = row.unit;
    convention.time = row.time;
    convention.encoded = row.encoded;
    convention.flip_y = row.y_up;
    convention.four_channels = row.four;
    convention.scale = row.scale;
    return convention;
}

const Row* find_row(std::string_view name) {
    for (const Row& row : rows)
        if (row.name == name)
            return &row;
    return nullptr;
}

// True if `modifier` is known; changes `convention` by it.
bool apply_modifier(MotionConvention& convention, std::string_view modifier) {
    for (const auto& [name, time] : times)
        if (modifier == name)
            return convention.time = time, true;
    for (const auto& [name, unit] : units)
        if (modifier == name)
            return convention.unit = unit, true;
    if (modifier == "flip-x")
        convention.flip_x = !convention.flip_x;
    else if (modifier == "flip-y")
        convention.flip_y = !convention.flip_y;
    else if (modifier == "swap")
        convention.swap = !convention.swap;
    else if (modifier == "encoded" || modifier == "raw")
        convention.encoded = modifier == "encoded";
    else if (modifier.starts_with("scale=")) {
        double value = 0.0;
        const char* end = modifier.data() + modifier.size();
        const auto [stop, code] = std::from_chars(modifier.data() + 6, end, value);
        if (code != std::errc() || stop != end || !(std::abs(value) > 1e-9 && std::abs(value) < 1e9))
            return false;
        convention.scale *= value;
    } else
        return false;
    return true;
}

} // namespace

const std::vector<std::string>& motion_convention_names() {
    static const std::vector<std::string> names = [] {
        std::vector<std::string> list;
        for (const Row& row : rows)
            list.emplace_back(row.name);
        return list;
    }();
    return names;
}

Result<MotionConvention> parse_motion_convention(std::string_view text) {
    MotionConvention convention = from_row(rows[0]);
    std::string_view rest = text;
    for (bool first = true;; first = false) {
        const size_t comma = rest.find(',');
        const std::string_view item = rest.substr(0, comma);
        const Row* row = first ? find_row(item) : nullptr;
        if (row)
            convention = from_row(*row);
        else if (!apply_modifier(convention, item))
            return Error{
                ErrorCode::invalid_argument,
                fmt::format("motion convention '{}': '{}' is unknown; names are {}; modifiers are flip-x, flip-y, "
                            "swap, scale=NUMBER, encoded, raw, pixels, ndc, uv, from-previous, to-previous, "
                            "to-next, from-next",
                            text, item, fmt::join(motion_convention_names(), ", "))};
        if (comma == std::string_view::npos)
            return convention;
        rest.remove_prefix(comma + 1);
    }
}

std::string MotionConvention::text() const {
    const Row* row = find_row(base);
    const MotionConvention named = row ? from_row(*row) : MotionConvention{};
    std::string result = named.base;
    auto add = [&result](bool differs, std::string_view modifier) {
        if (differs)
            result += fmt::format(",{}", modifier);
    };
    for (const auto& [name, value] : units)
        add(value == unit && unit != named.unit, name);
    add(encoded != named.encoded, encoded ? "encoded" : "raw");
    add(swap != named.swap, "swap");
    add(flip_x != named.flip_x, "flip-x");
    add(flip_y != named.flip_y, "flip-y");
    for (const auto& [name, value] : times)
        add(value == time && time != named.time, name);
    add(scale != named.scale, fmt::format("scale={:.9g}", scale / named.scale));
    return result;
}

std::string MotionConvention::description() const {
    static constexpr const char* unit_texts[] = {"pixels", "normalised device coordinates (-1 to 1)",
                                                 "fractions of the picture"};
    static constexpr const char* time_texts[] = {"current minus previous position", "previous minus current position",
                                                 "next minus current position", "current minus next position"};
    std::string result = fmt::format("{}{}, {}, x {}, y {}", encoded ? "0 to 1 with 0.5 still, " : "",
                                     unit_texts[static_cast<int>(unit)], time_texts[static_cast<int>(time)],
                                     flip_x ? "to the left" : "to the right", flip_y ? "up" : "down");
    if (swap)
        result += ", axes swapped";
    if (scale != 1.0)
        result += fmt::format(", times {:g}", scale);
    if (four_channels)
        result += "; channels 3 and 4 likewise for the other neighbour";
    return result;
}

std::array<double, 2> MotionConvention::decode(double first, double second, int width, int height) const {
    double x = encoded ? first * 2.0 - 1.0 : first, y = encoded ? second * 2.0 - 1.0 : second;
    if (swap)
        std::swap(x, y);
    const double factor = unit == MotionUnit::pixels ? 0.0 : unit == MotionUnit::ndc ? 0.5 : 1.0;
    const bool backwards = time == MotionTime::to_previous || time == MotionTime::from_next;
    const double sign = backwards ? -scale : scale;
    x *= (factor == 0.0 ? 1.0 : factor * width) * (flip_x ? -sign : sign);
    y *= (factor == 0.0 ? 1.0 : factor * height) * (flip_y ? -sign : sign);
    return {x, y};
}

namespace {

// Fills x, y pairs; counts and zeroes what is not finite.
void decode_pair(const std::vector<float>& first, const std::vector<float>& second, const MotionConvention& convention,
                 int width, int height, std::vector<float>& out, MotionField& field) {
    out.resize(first.size() * 2);
    for (size_t i = 0; i < first.size(); ++i) {
        auto v = convention.decode(double{first[i]}, double{second[i]}, width, height);
        if (!std::isfinite(v[0]) || !std::isfinite(v[1])) {
            ++field.non_finite;
            v = {0.0, 0.0};
        }
        field.longest = std::max(field.longest, std::hypot(v[0], v[1]));
        // A zero with a sign would be another bit pattern of "still".
        out[2 * i] = v[0] == 0.0 ? 0.0f : static_cast<float>(v[0]);
        out[2 * i + 1] = v[1] == 0.0 ? 0.0f : static_cast<float>(v[1]);
    }
}

} // namespace

Result<MotionField> decode_motion(const Planes& motion, const MotionConvention& convention, int width, int height,
                                  const Planes* companion) {
    const size_t needed = convention.four_channels && !companion ? 4 : 2;
    if (motion.channels.size() < needed)
        return Error{ErrorCode::invalid_argument, fmt::format("motion convention {} needs {} channels, the file has {}",
                                                              convention.text(), needed, motion.channels.size())};
    if (companion && (companion->channels.size() < 2 || companion->pixel_count() != motion.pixel_count()))
        return Error{ErrorCode::invalid_argument, "the two motion layers have different sizes"};
    MotionField field;
    field.width = motion.width;
    field.height = motion.height;
    std::vector<float> first, second;
    decode_pair(motion.channels[0], motion.channels[1], convention, width, height, first, field);
    // The other neighbour's vectors, read forward in time, have the same signs: both senses are turned over at once.
    MotionConvention other = convention;
    if (companion) {
        // A layer of its own has the opposite sense: forward is "to next" where backward is "to previous".
        other.time = convention.time == MotionTime::to_previous ? MotionTime::to_next
                     : convention.time == MotionTime::to_next   ? MotionTime::to_previous
                                                                : convention.time;
        decode_pair(companion->channels[0], companion->channels[1], other, width, height, second, field);
    } else if (convention.four_channels) {
        decode_pair(motion.channels[2], motion.channels[3], other, width, height, second, field);
    }
    if (!convention.tells_next()) {
        field.velocity = std::move(first);
        field.next = std::move(second);
    } else {
        field.next = std::move(first);
        field.velocity_is_next = second.empty();
        field.velocity = second.empty() ? field.next : std::move(second);
    }
    return field;
}

} // namespace sfumato::media
