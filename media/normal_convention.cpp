// Names, evidence and decoding of conventions of normals.
#include "normal_convention.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <optional>

#include <fmt/format.h>

namespace sfumato::media {

namespace {

using Vector = std::array<double, 3>;

double dot(const Vector& a, const Vector& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

std::optional<Vector> unit(const Vector& v) {
    const double length = std::sqrt(dot(v, v));
    if (!(length > 1e-6) || !std::isfinite(length))
        return std::nullopt;
    return Vector{v[0] / length, v[1] / length, v[2] / length};
}

} // namespace

std::string NormalConvention::text() const {
    std::string result = is_world ? "world" : "view";
    result += is_z_forward ? ",z-forward" : "";
    result += is_unsigned ? ",unsigned" : "";
    result += is_flipped ? ",flipped" : "";
    return result;
}

std::string NormalConvention::description() const {
    std::string result = is_world       ? "world space"
                         : is_z_forward ? "view space with +z away from the camera"
                                        : "view space, +z towards the camera";
    result += is_unsigned ? ", held as n/2 + 1/2" : "";
    result += is_flipped ? ", pointing into the surface" : "";
    return result;
}

Result<NormalConvention> parse_normal_convention(std::string_view text) {
    NormalConvention convention;
    const std::string whole(text);
    for (bool first = true;; first = false) {
        const size_t comma = text.find(',');
        const std::string_view item = text.substr(0, comma);
        if (first && (item == "view" || item == "world"))
            convention.is_world = item == "world";
        else if (!first && item == "unsigned")
            convention.is_unsigned = true;
        else if (!first && item == "flipped")
            convention.is_flipped = true;
        else if (!first && item == "z-forward" && !convention.is_world)
            convention.is_z_forward = true;
        else
            return Error{ErrorCode::invalid_argument,
                         fmt::format("normal space '{}': '{}' is unknown; write auto, or view or world with any of "
                                     ",unsigned ,flipped and for view ,z-forward",
                                     whole, item)};
        if (comma == std::string_view::npos)
            return convention;
        text.remove_prefix(comma + 1);
    }
}

// ------------------------------------------------------------------------------------------------- evidence

namespace {

// A pixel's normal in view space, from depth.
struct Sample {
    size_t pixel;
    Vector normal;
};

class DepthNormals {
  public:
    DepthNormals(const std::vector<float>& depth, int width, int height, const Matrix4& projection)
        : depth_(depth), width_(static_cast<size_t>(width)), height_(static_cast<size_t>(height)),
          projection_(projection) {}

    // A grid of at most some ten thousand pixels, without edges and curved places.
    std::vector<Sample> samples() const {
        std::vector<Sample> found;
        const auto stride =
            std::max<size_t>(1, static_cast<size_t>(std::sqrt(static_cast<double>(width_ * height_) / 40000.0)));
        for (size_t y = 1; y + 1 < height_; y += stride)
            for (size_t x = 1; x + 1 < width_; x += stride)
                if (auto normal = normal_at(x, y))
                    found.push_back({y * width_ + x, *normal});
        return found;
    }

  private:
    double at(size_t x, size_t y) const { return double{depth_[y * width_ + x]}; }

    Vector position(size_t x, size_t y) const {
        const double depth = at(x, y);
        const double ndc_x = 2.0 * (static_cast<double>(x) + 0.5) / static_cast<double>(width_) - 1.0;
        const double ndc_y = 2.0 * (static_cast<double>(y) + 0.5) / static_cast<double>(height_) - 1.0;
        if (projection_[11] == 0.0f)
            return {(ndc_x - double{projection_[12]}) / double{projection_[0]},
                    (ndc_y - double{projection_[13]}) / double{projection_[5]}, -depth};
        return {(ndc_x + double{projection_[8]}) / double{projection_[0]} * depth,
                (ndc_y + double{projection_[9]}) / double{projection_[5]} * depth, -depth};
    }

    // Planes have no second difference: of depth's inverse in perspective, of depth in an orthographic picture.
    bool is_flat(size_t x, size_t y, size_t dx, size_t dy) const {
        const double a = at(x - dx, y - dy), b = at(x, y), c = at(x + dx, y + dy);
        if (!(a > 0.0 && b > 0.0 && c > 0.0 && a < 1e9 && b < 1e9 && c < 1e9))
            return false;
        if (projection_[11] == 0.0f)
            return std::abs(a + c - 2.0 * b) < 0.1 * std::abs(c - a) + 1e-5 * b;
        return std::abs(1.0 / a + 1.0 / c - 2.0 / b) < 0.1 * std::abs(1.0 / c - 1.0 / a) + 1e-5 / b;
    }

    std::optional<Vector> normal_at(size_t x, size_t y) const {
        if (!is_flat(x, y, 1, 0) || !is_flat(x, y, 0, 1))
            return std::nullopt;
        const Vector left = position(x - 1, y), right = position(x + 1, y);
        const Vector up = position(x, y - 1), down = position(x, y + 1);
        const Vector a = {right[0] - left[0], right[1] - left[1], right[2] - left[2]};
        const Vector b = {up[0] - down[0], up[1] - down[1], up[2] - down[2]};
        auto normal = unit({a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]});
        // What is seen faces the camera.
        const Vector ray = projection_[11] == 0.0f ? Vector{0.0, 0.0, -1.0} : position(x, y);
        if (normal && dot(*normal, ray) > 0.0)
            normal = Vector{-(*normal)[0], -(*normal)[1], -(*normal)[2]};
        return normal;
    }

    const std::vector<float>& depth_;
    size_t width_, height_;
    const Matrix4& projection_;
};

Vector decoded(Vector v, const NormalConvention& convention) {
    if (convention.is_unsigned && v != Vector{0.0, 0.0, 0.0})
        for (double& value : v)
            value = 2.0 * value - 1.0;
    if (convention.is_flipped)
        for (double& value : v)
            value = -value;
    if (convention.is_z_forward)
        v[2] = -v[2];
    return v;
}

double agreement_of(const NormalConvention& convention, const Planes& normals, const std::vector<Sample>& samples,
                    const Matrix4& world_to_view) {
    double sum = 0.0;
    size_t count = 0;
    for (const Sample& sample : samples) {
        Vector v = decoded({double{normals.channels[0][sample.pixel]}, double{normals.channels[1][sample.pixel]},
                            double{normals.channels[2][sample.pixel]}},
                           convention);
        const Matrix4& m = world_to_view;
        if (convention.is_world)
            v = {m[0] * v[0] + m[4] * v[1] + m[8] * v[2], m[1] * v[0] + m[5] * v[1] + m[9] * v[2],
                 m[2] * v[0] + m[6] * v[1] + m[10] * v[2]};
        const auto normal = unit(v);
        if (!normal)
            continue;
        sum += dot(*normal, sample.normal);
        ++count;
    }
    return count > 0 ? sum / static_cast<double>(count) : 0.0;
}

std::vector<NormalReading> readings_of(const Planes& normals, const std::vector<Sample>& samples,
                                       const Matrix4& world_to_view) {
    bool is_negative = false;
    for (const std::vector<float>& plane : normals.channels)
        is_negative = is_negative || std::ranges::any_of(plane, [](float value) { return value < -0.01f; });
    std::vector<NormalReading> readings;
    for (const bool is_unsigned : {false, true})
        for (const bool is_flipped : {false, true})
            for (const NormalConvention& convention : {NormalConvention{false, is_unsigned, is_flipped, false},
                                                       NormalConvention{true, is_unsigned, is_flipped, false},
                                                       NormalConvention{false, is_unsigned, is_flipped, true}})
                if (!(is_unsigned && is_negative))
                    readings.push_back({convention, agreement_of(convention, normals, samples, world_to_view)});
    std::ranges::stable_sort(readings, std::ranges::greater{}, &NormalReading::agreement);
    return readings;
}

// ---------------------------------------------------------------------------------------------- name and header

std::string plain(std::string_view text) {
    std::string result;
    for (const char c : text.substr(text.rfind('.') + 1)) // npos + 1 is 0
        if (std::isalnum(static_cast<unsigned char>(c)))
            result += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return result;
}

void detect_by_name_and_header(const ExrImage& image, const ChannelGroup& group, NormalDetection& found) {
    const std::string name = plain(group.layer);
    const ExrPart& part = image.parts[group.part];
    std::string attribute;
    std::string renderer = renderer_of(part, attribute);
    if (renderer.empty() && group.part != 0)
        renderer = renderer_of(image.parts[0], attribute);
    const auto set = [&](bool is_world, Confidence confidence, const std::string& reason) {
        found.convention.is_world = is_world;
        found.confidence = confidence;
        found.reasons.push_back(reason);
    };
    if (part.find_attribute("sfumato/normals") != nullptr)
        set(false, Confidence::attribute, "attribute 'sfumato/normals' says view space");
    else if (name.find("world") != std::string::npos)
        set(true, Confidence::named, fmt::format("{} is named after world space", group.text()));
    else if (name.starts_with("view") || name == "vraynormals")
        set(false, Confidence::named, fmt::format("{} has the name of normals in view space", group.text()));
    else if (!renderer.empty())
        set(renderer != "vray" && renderer != "nuke", Confidence::attribute,
            fmt::format("attribute '{}' is {}'s, whose normals are in {} space", attribute, renderer,
                        renderer != "vray" && renderer != "nuke" ? "world" : "view"));
    else
        set(false, Confidence::guess, "nothing in name or header tells the space; view is assumed");
}

double agreement_with(const NormalDetection& found, const NormalConvention& convention) {
    for (const NormalReading& reading : found.readings)
        if (reading.convention == convention)
            return reading.agreement;
    return -1.0;
}

constexpr size_t enough_samples = 100;
constexpr double fits = 0.8;     // mean cosine of a reading that can be right: smooth shading and bumps take some
constexpr double differs = 0.03; // less apart, readings are as good as each other

void weigh_evidence(NormalDetection& found, std::string_view told) {
    const NormalReading& best = found.readings.front();
    const double claimed = agreement_with(found, found.convention);
    found.reasons.push_back(fmt::format("against normals from depth at {} pixels: {:.3f} as {}, {:.3f} as {} (mean "
                                        "cosine)",
                                        found.samples,
                                        agreement_with(found, {true, best.convention.is_unsigned, false}), "world",
                                        agreement_with(found, {false, best.convention.is_unsigned, false}), "view"));
    if (best.agreement < fits) {
        found.warnings.push_back(fmt::format("no reading of the normals fits the depth (best {}: {:.3f})",
                                             best.convention.text(), best.agreement));
        return;
    }
    if (claimed >= best.agreement - differs)
        return;
    if (!told.empty()) {
        found.warnings.push_back(fmt::format(
            "normal space {} looks wrong: it agrees with normals from depth to {:.3f}, "
            "{} to {:.3f}; say --normal-space {} if it is",
            found.convention.text(), claimed, best.convention.text(), best.agreement, best.convention.text()));
        return;
    }
    found.convention = best.convention;
    found.confidence = Confidence::values;
    found.reasons.push_back(fmt::format("taken as {}, which fits", best.convention.text()));
    if (best.convention.is_flipped || best.convention.is_unsigned || best.convention.is_z_forward)
        found.warnings.push_back(
            fmt::format("the normals are {}: they are read as such", best.convention.description()));
}

} // namespace

Result<NormalDetection> detect_normals(const ExrImage& image, const ChannelGroup& group, std::string_view told,
                                       const Planes& normals, const std::vector<float>& depth, const Camera* camera) {
    NormalDetection found;
    if (told == "auto")
        told = {};
    if (!told.empty()) {
        auto convention = parse_normal_convention(told);
        if (!convention)
            return convention.error();
        found.convention = *convention;
        found.confidence = Confidence::told;
        found.reasons.push_back(fmt::format("space {} was told", convention->text()));
    } else {
        detect_by_name_and_header(image, group, found);
    }
    if (normals.channels.size() < 3 || camera == nullptr || depth.size() != normals.pixel_count()) {
        found.reasons.push_back("not verified: that takes depth and a camera");
        return found;
    }
    const auto samples = DepthNormals(depth, normals.width, normals.height, camera->projection).samples();
    if (samples.size() < enough_samples) {
        found.reasons.push_back("not verified: too few pixels with even depth");
        return found;
    }
    found.samples = samples.size();
    found.readings = readings_of(normals, samples, camera->world_to_view);
    weigh_evidence(found, told);
    return found;
}

void decode_normals(Planes& normals, const NormalConvention& convention) {
    if (convention == NormalConvention{convention.is_world} || normals.channels.size() < 3)
        return;
    for (size_t i = 0; i < normals.pixel_count(); ++i) {
        const Vector v =
            decoded({double{normals.channels[0][i]}, double{normals.channels[1][i]}, double{normals.channels[2][i]}},
                    convention);
        for (size_t c = 0; c < 3; ++c)
            normals.channels[c][i] = static_cast<float>(v[c]);
    }
}

} // namespace sfumato::media
