// What all effects have in common: a description that tools can read, and a class that records into a command buffer.
#pragma once

#include "sfumato/executor.h"
#include "sfumato/frame.h"
#include "sfumato/parameters.h"
#include "sfumato/plan.h"

#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace sfumato {

enum class ImageUse { input, optional_input, output, optional_output };

// One image that an effect takes: a member of its images struct.
struct ImageRole {
    const char* name;
    const char* doc; // what it holds, in which convention
    ImageUse use;
    uint32_t components; // least number of channels
    bool is_signed;      // holds negative values: unsigned formats are refused
    Image& (*get)(void* images);

    bool is_output() const { return use == ImageUse::output || use == ImageUse::optional_output; }
    bool is_optional() const { return use == ImageUse::optional_input || use == ImageUse::optional_output; }
};

// What the result of a frame lacks, as the effect tells it in a buffer.
struct Shortfall {
    const char* name;   // of the kind; of several frames that fall short alike, the worst speaks for all
    double excess;      // the larger, the worse
    std::string text;   // what is missing, part of a sentence
    std::string remedy; // a setting that would help, "parameter=value"; empty where no single one does
};

// One buffer that an effect takes: a member of its images struct, which holds both.
struct BufferRole {
    const char* name;
    const char* doc; // what it holds, in which layout
    ImageUse use;
    uint32_t element_bytes; // its size is a multiple of this
    uint64_t largest_bytes;
    Buffer& (*get)(void* images);
    // Reads what the device has written into one element, for a frame of these parameters: nothing where the result is
    // whole. Null where the buffer does not tell.
    std::vector<Shortfall> (*shortfalls)(const void* contents, const void* parameters) = nullptr;

    bool is_output() const { return use == ImageUse::output || use == ImageUse::optional_output; }
    bool is_optional() const { return use == ImageUse::optional_input || use == ImageUse::optional_output; }
};

// Everything there is to know of an effect. Tools, docs and generic tests read this.
struct EffectInfo {
    const char* name;    // kebab-case, "motion-blur"
    const char* summary; // one sentence
    const char* source;  // the documents it follows
    const ParameterTable* parameters;
    std::span<const ImageRole> images;
    size_t images_size; // sizeof the images struct
    bool needs_camera;  // whether Frame::camera must be given
    // The plan of one frame. A pure function; handles of the images are not looked at, only format and extent.
    // Expects validated input (validate_effect).
    Plan (*plan)(const Frame& frame, const void* parameters, const void* images);
    // What the effect alone knows to be wrong: combinations of parameters and images. May be null. The text is empty
    // where nothing is wrong.
    std::string (*check)(const Frame& frame, const void* parameters, const void* images) = nullptr;
    std::span<const BufferRole> buffers = {};
};

// All effects of the library.
std::span<const EffectInfo* const> effects();
const EffectInfo* find_effect(std::string_view name);

// Checks everything that a host can get wrong: parameter ranges, roles, formats, extents, sizes of buffers, matrices.
// With `need_handles` also that views are not null and layouts are right.
Result<void> validate_effect(const EffectInfo& effect, const Frame& frame, const void* parameters, const void* images,
                             bool need_handles);

// Validates, then plans.
Result<Plan> plan_effect(const EffectInfo& effect, const Frame& frame, const void* parameters, const void* images);

// One instance of any effect on one stream of frames.
class AnyEffect {
  public:
    static Result<std::unique_ptr<AnyEffect>> create(Context& context, const EffectInfo& effect);

    const EffectInfo& info() const { return *info_; }

    // Records the effect into `commands`. `parameters` and `images` point at the structs that info() describes.
    Result<void> record(VkCommandBuffer commands, const Frame& frame, const void* parameters, const void* images);

    std::vector<PassTime> times() { return executor_->times(); }

  private:
    AnyEffect(const EffectInfo& effect, std::unique_ptr<Executor> executor);
    const EffectInfo* info_;
    std::unique_ptr<Executor> executor_;
    std::vector<Image> host_images_;
    std::vector<Buffer> host_buffers_;
};

// The typed face of AnyEffect that hosts use: MotionBlur is Effect<MotionBlurParameters, MotionBlurImages>.
template <class Parameters, class Images>
class Effect {
  public:
    static const EffectInfo& info() { return Images::effect(); }

    static Result<std::unique_ptr<Effect>> create(Context& context) {
        auto effect = AnyEffect::create(context, info());
        if (!effect)
            return effect.error();
        return std::unique_ptr<Effect>(new Effect(std::move(*effect)));
    }

    static Result<Plan> plan(const Frame& frame, const Parameters& parameters, const Images& images) {
        return plan_effect(info(), frame, &parameters, &images);
    }

    Result<void> record(VkCommandBuffer commands, const Frame& frame, const Parameters& parameters,
                        const Images& images) {
        return effect_->record(commands, frame, &parameters, &images);
    }

    std::vector<PassTime> times() { return effect_->times(); }

  private:
    explicit Effect(std::unique_ptr<AnyEffect> effect) : effect_(std::move(effect)) {}
    std::unique_ptr<AnyEffect> effect_;
};

} // namespace sfumato
