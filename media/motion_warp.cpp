// Photometric check of motion conventions. A hypothesis fetches, for pixels that move, the neighbouring frame where it
// says that the surface was (or will be); the true one finds the same colour there.
#include "motion_warp.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include <fmt/format.h>

namespace sfumato::media {

namespace {

constexpr double cut_off = 0.25;
constexpr size_t most_samples = 120'000;
// Neighbouring pixels repeat each other, so that hundreds of them make few independent witnesses.
constexpr size_t least_samples = 512;
constexpr size_t least_differing = 128;
// How much lower an error must be to count as evidence rather than noise.
constexpr double clear_margin = 1.1;
// How far below standing still the error must be. Calling a choice wrong takes more: by chance, one of two dozen
// readings of vectors that mean nothing comes near the truth.
constexpr double confirmed_share = 0.95;
constexpr double wrong_share = 0.8;

// Tone-mapped colour after a 3x3 box. The box takes the same noise from all hypotheses, so that the bilinear fetch,
// which blurs as well, favours none.
Planes prepare(const Planes& colour) {
    Planes result{colour.width, colour.height, {}};
    const auto width = static_cast<ptrdiff_t>(colour.width), height = static_cast<ptrdiff_t>(colour.height);
    for (size_t c = 0; c < std::min<size_t>(3, colour.channels.size()); ++c) {
        std::vector<float> toned(colour.pixel_count()), blurred(colour.pixel_count());
        std::transform(colour.channels[c].begin(), colour.channels[c].end(), toned.begin(), [](float value) {
            return std::isnan(value) || value <= 0.0f ? 0.0f : std::isinf(value) ? 1.0f : value / (1.0f + value);
        });
        for (ptrdiff_t y = 0; y < height; ++y)
            for (ptrdiff_t x = 0; x < width; ++x) {
                float sum = 0.0f, count = 0.0f;
                for (ptrdiff_t v = std::max<ptrdiff_t>(0, y - 1); v <= std::min(height - 1, y + 1); ++v)
                    for (ptrdiff_t u = std::max<ptrdiff_t>(0, x - 1); u <= std::min(width - 1, x + 1); ++u) {
                        sum += toned[static_cast<size_t>(v * width + u)];
                        count += 1.0f;
                    }
                blurred[static_cast<size_t>(y * width + x)] = sum / count;
            }
        result.channels.push_back(std::move(blurred));
    }
    return result;
}

struct Tap {
    std::array<size_t, 4> index;
    std::array<float, 4> weight;
};

Tap bilinear(double x, double y, int width, int height) {
    x = std::clamp(x, 0.0, width - 1.0);
    y = std::clamp(y, 0.0, height - 1.0);
    const double left = std::floor(x), top = std::floor(y);
    const auto x0 = static_cast<size_t>(left), y0 = static_cast<size_t>(top);
    const size_t x1 = std::min(x0 + 1, static_cast<size_t>(width) - 1),
                 y1 = std::min(y0 + 1, static_cast<size_t>(height) - 1);
    const auto fx = static_cast<float>(x - left), fy = static_cast<float>(y - top);
    const auto stride = static_cast<size_t>(width);
    return {{y0 * stride + x0, y0 * stride + x1, y1 * stride + x0, y1 * stride + x1},
            {(1 - fx) * (1 - fy), fx * (1 - fy), (1 - fx) * fy, fx * fy}};
}

struct Neighbour {
    Planes colour;
    const std::vector<float>* depth = nullptr;
    bool next = false;

    // Where a surface that moves by u stands in that frame: at x + u in the next, at x - u in the previous.
    double sense() const { return next ? 1.0 : -1.0; }
};

MotionTime turned(MotionTime time) {
    switch (time) {
    case MotionTime::from_previous:
        return MotionTime::to_previous;
    case MotionTime::to_previous:
        return MotionTime::from_previous;
    case MotionTime::to_next:
        return MotionTime::from_next;
    case MotionTime::from_next:
        return MotionTime::to_next;
    }
    return time;
}

// The other pair of channels comes first: "previous - current" becomes "current - next".
MotionTime exchanged(MotionTime time) {
    switch (time) {
    case MotionTime::from_previous:
        return MotionTime::to_next;
    case MotionTime::to_previous:
        return MotionTime::from_next;
    case MotionTime::to_next:
        return MotionTime::from_previous;
    case MotionTime::from_next:
        return MotionTime::to_previous;
    }
    return time;
}

constexpr std::string_view exchange_text = "pairs exchanged";

// The checked convention comes first, its variants follow, simple ones before others.
std::vector<WarpHypothesis> make_hypotheses(const MotionConvention& chosen) {
    std::vector<WarpHypothesis> list;
    for (const double scale : {1.0, 0.5, 2.0})
        for (unsigned bits = 0; bits < 8; ++bits) {
            WarpHypothesis hypothesis;
            hypothesis.convention = chosen;
            hypothesis.convention.scale *= scale;
            auto add = [&](std::string_view text) {
                hypothesis.change += hypothesis.change.empty() ? std::string(text) : fmt::format(",{}", text);
            };
            if (bits & 4) {
                hypothesis.convention.swap = !chosen.swap;
                add("swap");
            }
            if ((bits & 3) == 3) {
                hypothesis.convention.time = turned(chosen.time);
                add("time reversed");
            } else if (bits & 3) {
                bool& flip = bits & 1 ? hypothesis.convention.flip_x : hypothesis.convention.flip_y;
                flip = !flip;
                add(bits & 1 ? "flip-x" : "flip-y");
            }
            if (scale != 1.0)
                add(fmt::format("scale={:g}", scale));
            list.push_back(std::move(hypothesis));
        }
    if (!chosen.four_channels)
        return list;
    for (size_t i = 0; i < 8; ++i) {
        WarpHypothesis hypothesis = list[i];
        hypothesis.convention.time = exchanged(hypothesis.convention.time);
        hypothesis.change = fmt::format("{}{}{}", exchange_text, i > 0 ? "," : "", hypothesis.change);
        list.push_back(std::move(hypothesis));
    }
    return list;
}

class WarpCheck {
  public:
    WarpCheck(const WarpInput& input, const MotionConvention& convention)
        : input_(input), current_(prepare(*input.colour)), hypotheses_(make_hypotheses(convention)),
          width_(input.colour->width), height_(input.colour->height) {
        screen_width_ = input.screen_width > 0 ? input.screen_width : width_;
        screen_height_ = input.screen_height > 0 ? input.screen_height : height_;
    }

    WarpReport run();

  private:
    using Vector = std::array<double, 2>;

    void add_neighbours();
    std::vector<size_t> pick_pixels(const Neighbour& neighbour);
    Vector vector(const Neighbour& neighbour, const MotionConvention& convention, size_t pixel) const;
    double detail(size_t pixel) const;
    double fetch_error(const Neighbour& neighbour, size_t pixel, const Vector& offset, bool& depth_agrees) const;
    void score(const Neighbour& neighbour, const std::vector<size_t>& pixels, bool inside_only);
    void score_pixel(const Neighbour& neighbour, size_t pixel, const std::vector<Vector>& vectors);
    void finish();
    void decide();

    const WarpInput& input_;
    Planes current_;
    std::vector<WarpHypothesis> hypotheses_;
    int width_;
    int height_;
    int screen_width_ = 0;
    int screen_height_ = 0;
    std::vector<Neighbour> neighbours_;
    WarpReport report_;
};

void WarpCheck::add_neighbours() {
    auto add = [&](const Planes* colour, const std::vector<float>* depth, bool next) {
        if (colour)
            neighbours_.push_back({prepare(*colour), input_.depth ? depth : nullptr, next});
    };
    add(input_.previous_colour, input_.previous_depth, false);
    add(input_.next_colour, input_.next_depth, true);
}

// Motion of a pixel, forward in time, between this frame and the neighbour.
WarpCheck::Vector WarpCheck::vector(const Neighbour& neighbour, const MotionConvention& convention,
                                    size_t pixel) const {
    // Without vectors of its own a neighbour gets the other one's: motion is taken to be even.
    const bool other_pair = neighbour.next != convention.tells_next();
    const bool companion = other_pair && input_.companion;
    const auto& channels = companion ? input_.companion->channels : input_.motion->channels;
    const size_t pair = other_pair && !companion && convention.four_channels ? 2 : 0;
    Vector v = convention.decode(double{channels[pair][pixel]}, double{channels[pair + 1][pixel]}, screen_width_,
                                 screen_height_);
    if (!std::isfinite(v[0]) || !std::isfinite(v[1]))
        return {0.0, 0.0};
    // A layer of its own has the opposite sense: forward is "to next" where backward is "to previous".
    if (companion && (convention.time == MotionTime::to_previous || convention.time == MotionTime::to_next))
        v = {-v[0], -v[1]};
    return v;
}

// The spread of the current picture around a pixel: where it is flat, every vector finds the same colour.
double WarpCheck::detail(size_t pixel) const {
    const auto stride = static_cast<size_t>(width_);
    const size_t x = pixel % stride, y = pixel / stride;
    double largest = 0.0;
    for (const std::vector<float>& plane : current_.channels) {
        float low = plane[pixel], high = low;
        for (size_t v = y > 1 ? y - 2 : 0; v <= std::min(y + 2, static_cast<size_t>(height_) - 1); ++v)
            for (size_t u = x > 1 ? x - 2 : 0; u <= std::min(x + 2, stride - 1); ++u) {
                low = std::min(low, plane[v * stride + u]);
                high = std::max(high, plane[v * stride + u]);
            }
        largest = std::max(largest, double{high} - double{low});
    }
    return largest;
}

// Moving pixels, thinned out evenly if there are many, and of these the half with more detail.
std::vector<size_t> WarpCheck::pick_pixels(const Neighbour& neighbour) {
    std::vector<size_t> moving;
    for (size_t i = 0; i < current_.pixel_count(); ++i) {
        const Vector v = vector(neighbour, hypotheses_[0].convention, i);
        if (std::hypot(v[0], v[1]) >= 0.5)
            moving.push_back(i);
    }
    report_.moving = std::max(report_.moving, moving.size());
    std::vector<std::pair<double, size_t>> ranked;
    const double step = std::max(1.0, static_cast<double>(moving.size()) / (2.0 * most_samples));
    for (double at = 0.0; at < static_cast<double>(moving.size()); at += step) {
        const size_t pixel = moving[static_cast<size_t>(at)];
        if (const double spread = detail(pixel); spread > 1e-3)
            ranked.emplace_back(-spread, pixel);
    }
    std::sort(ranked.begin(), ranked.end());
    const size_t kept = ranked.size() < 2 * least_samples ? ranked.size() : (ranked.size() + 1) / 2;
    std::vector<size_t> picked;
    for (size_t i = 0; i < kept; ++i)
        picked.push_back(ranked[i].second);
    std::sort(picked.begin(), picked.end());
    return picked;
}

double WarpCheck::fetch_error(const Neighbour& neighbour, size_t pixel, const Vector& offset,
                              bool& depth_agrees) const {
    const auto stride = static_cast<size_t>(width_);
    const double x = static_cast<double>(pixel % stride) + neighbour.sense() * offset[0];
    const double y = static_cast<double>(pixel / stride) + neighbour.sense() * offset[1];
    const Tap tap = bilinear(x, y, width_, height_);
    if (neighbour.depth) {
        // Nearest, as depths of two surfaces have no mean. Sky agrees with sky.
        const size_t largest =
            static_cast<size_t>(std::max_element(tap.weight.begin(), tap.weight.end()) - tap.weight.begin());
        const double here = double{(*input_.depth)[pixel]}, there = double{(*neighbour.depth)[tap.index[largest]]};
        depth_agrees = !(std::abs(here - there) > 0.1 * std::min(std::abs(here), std::abs(there)));
        if (!depth_agrees)
            return cut_off;
    }
    double sum = 0.0;
    for (size_t c = 0; c < current_.channels.size(); ++c) {
        float value = 0.0f;
        for (size_t i = 0; i < 4; ++i)
            value += tap.weight[i] * neighbour.colour.channels[c][tap.index[i]];
        sum += std::abs(double{value} - double{current_.channels[c][pixel]});
    }
    return std::min(cut_off, sum / static_cast<double>(current_.channels.size()));
}

void WarpCheck::score_pixel(const Neighbour& neighbour, size_t pixel, const std::vector<Vector>& vectors) {
    bool agrees = true, any_agrees = false;
    const double still = fetch_error(neighbour, pixel, {0.0, 0.0}, agrees);
    std::vector<double> errors(vectors.size());
    for (size_t h = 0; h < vectors.size(); ++h) {
        agrees = true;
        errors[h] = fetch_error(neighbour, pixel, vectors[h], agrees);
        any_agrees = any_agrees || agrees;
    }
    // A surface that no hypothesis finds is hidden in the other frame.
    if (!any_agrees)
        return;
    ++report_.used;
    report_.error_still += still;
    for (size_t h = 0; h < vectors.size(); ++h) {
        WarpHypothesis& hypothesis = hypotheses_[h];
        hypothesis.error += errors[h];
        if (std::hypot(vectors[h][0] - vectors[0][0], vectors[h][1] - vectors[0][1]) <= 1.0)
            continue;
        ++hypothesis.differing;
        hypothesis.local_error += errors[h];
        hypothesis.local_chosen += errors[0];
    }
}

void WarpCheck::score(const Neighbour& neighbour, const std::vector<size_t>& pixels, bool inside_only) {
    const auto stride = static_cast<size_t>(width_);
    std::vector<Vector> vectors(hypotheses_.size());
    for (const size_t pixel : pixels) {
        bool inside = true;
        for (size_t h = 0; h < hypotheses_.size(); ++h) {
            vectors[h] = vector(neighbour, hypotheses_[h].convention, pixel);
            const double x = static_cast<double>(pixel % stride) + neighbour.sense() * vectors[h][0];
            const double y = static_cast<double>(pixel / stride) + neighbour.sense() * vectors[h][1];
            inside = inside && x >= 0.0 && y >= 0.0 && x <= width_ - 1.0 && y <= height_ - 1.0;
        }
        // All hypotheses are judged on the same pixels.
        if (inside || !inside_only)
            score_pixel(neighbour, pixel, vectors);
    }
}

void WarpCheck::finish() {
    const double used = std::max(1.0, static_cast<double>(report_.used));
    report_.error_still /= used;
    for (WarpHypothesis& hypothesis : hypotheses_) {
        hypothesis.error /= used;
        const double differing = std::max(1.0, static_cast<double>(hypothesis.differing));
        hypothesis.local_error /= differing;
        hypothesis.local_chosen /= differing;
    }
    report_.error_chosen = hypotheses_[0].error;
    report_.others.assign(hypotheses_.begin() + 1, hypotheses_.end());
    // Equal errors keep the order of the list, in which simpler changes come first.
    std::stable_sort(report_.others.begin(), report_.others.end(),
                     [](const WarpHypothesis& a, const WarpHypothesis& b) { return a.error < b.error; });
}

void WarpCheck::decide() {
    auto can_tell = [](const WarpHypothesis& h) { return h.differing >= least_differing; };
    const auto best = std::find_if(report_.others.begin(), report_.others.end(), can_tell);
    if (report_.used < least_samples || best == report_.others.end()) {
        report_.reasons.push_back(
            fmt::format("only {} moving pixels with detail; {} are needed", report_.used, least_samples));
        return;
    }
    std::string same;
    for (const WarpHypothesis& other : report_.others)
        if (!can_tell(other) && other.change.find("scale") == std::string::npos &&
            other.change.find(exchange_text) == std::string::npos)
            same += (same.empty() ? "" : "; ") + other.change;
    if (!same.empty())
        report_.reasons.push_back("makes no difference on these frames: " + same);
    constexpr double tiny = 1e-6;
    report_.best_other = *best;
    report_.margin = (best->local_error + tiny) / (best->local_chosen + tiny);
    const double still = report_.error_still;
    if (report_.error_chosen > best->error && report_.margin < 1.0 / clear_margin) {
        if (best->error > wrong_share * still)
            report_.reasons.push_back("no reading of the vectors explains the picture much better than standing still");
        else
            report_.verdict = WarpVerdict::wrong;
        return;
    }
    // Every reading that differs must be clearly worse where it differs.
    bool clear = true;
    for (const WarpHypothesis& other : report_.others) {
        const double margin = (other.local_error + tiny) / (other.local_chosen + tiny);
        // Even motion fits both pairs; that is no doubt about the signs.
        if (!can_tell(other) || margin >= clear_margin || other.change == exchange_text)
            continue;
        if (clear || margin < report_.margin) {
            report_.best_other = other;
            report_.margin = margin;
        }
        clear = false;
    }
    if (report_.error_chosen > confirmed_share * still)
        report_.reasons.push_back("the vectors explain the picture no better than standing still");
    else if (!clear)
        report_.reasons.push_back(fmt::format("{} explains the picture nearly as well", report_.best_other.change));
    else
        report_.verdict = WarpVerdict::confirmed;
}

WarpReport WarpCheck::run() {
    add_neighbours();
    for (const bool inside_only : {true, false}) {
        for (const Neighbour& neighbour : neighbours_)
            score(neighbour, pick_pixels(neighbour), inside_only);
        // Where all motion leaves the picture, pixels repeated at the edge are better than none.
        if (report_.used >= least_samples)
            break;
        if (inside_only) {
            report_.used = 0;
            report_.error_still = 0.0;
            hypotheses_ = make_hypotheses(hypotheses_[0].convention);
        }
    }
    finish();
    const auto& motion = input_.motion->channels;
    if (statistics_of(motion[0]).all_zero && statistics_of(motion[1]).all_zero)
        report_.reasons.push_back("all vectors are zero");
    decide();
    return std::move(report_);
}

} // namespace

std::string WarpReport::text() const {
    std::string result;
    if (verdict == WarpVerdict::confirmed)
        result = "confirmed";
    else if (verdict == WarpVerdict::wrong)
        result = fmt::format("wrong: better explained by {} ({})", best_other.change, best_other.convention.text());
    else
        result = "inconclusive";
    result += fmt::format(": error {:.4f} standing still, {:.4f} as read", error_still, error_chosen);
    if (!best_other.change.empty())
        result += fmt::format(", {:.4f} with {}; where the two differ {:.4f} as read, {:.4f} with it", best_other.error,
                              best_other.change, best_other.local_chosen, best_other.local_error);
    result += fmt::format("; {} samples of {} moving pixels", used, moving);
    for (const std::string& reason : reasons)
        result += "; " + reason;
    return result;
}

Result<WarpReport> check_by_warping(const WarpInput& input, const MotionConvention& convention) {
    auto fits = [&](const Planes* planes, size_t channels) {
        bool good = planes->width == input.colour->width && planes->height == input.colour->height &&
                    planes->channels.size() >= channels;
        for (const std::vector<float>& plane : planes->channels)
            good = good && plane.size() == planes->pixel_count();
        return good;
    };
    const size_t pairs = convention.four_channels && !input.companion ? 4 : 2;
    if (!input.colour || !input.motion || (!input.previous_colour && !input.next_colour))
        return Error{ErrorCode::invalid_argument,
                     "checking motion needs colour, motion and a neighbouring frame's colour"};
    if (input.colour->width < 1 || input.colour->height < 1 || !fits(input.colour, 1) || !fits(input.motion, pairs) ||
        (input.companion && !fits(input.companion, 2)))
        return Error{ErrorCode::invalid_argument, "colour and motion have different sizes or too few channels"};
    for (const Planes* neighbour : {input.previous_colour, input.next_colour})
        if (neighbour && !fits(neighbour, std::min<size_t>(3, input.colour->channels.size())))
            return Error{ErrorCode::invalid_argument, "a neighbouring frame has another size than this one"};
    for (const std::vector<float>* depth : {input.depth, input.previous_depth, input.next_depth})
        if (depth && depth->size() != input.colour->pixel_count())
            return Error{ErrorCode::invalid_argument, "depth has another size than colour"};
    return WarpCheck(input, convention).run();
}

} // namespace sfumato::media
